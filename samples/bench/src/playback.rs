//! The camera, the clips and the clock of a scene out of a file, for each frame.

use std::f32::consts::TAU;
use std::fmt::Display;

use antumbra::cull::{Aabb, Camera, Projection};
use antumbra::glam::{Vec2, Vec3};
use antumbra::import;
use antumbra::import::SceneAnimator;
use antumbra::scene::FOV_Y_RAD;

use crate::camera_path::CameraTrack;
use crate::choices::unknown;
use crate::run_error::RunError;

/// The frames per second if no clip determines the length of a walk.
const FRAMES_A_SECOND: f64 = 60.0;
/// The angle by which a camera that turns around something looks down, in radians.
const DOWN_RAD: f32 = 0.35;
/// The factor on the distance at which everything would just fit.
const ROOM: f32 = 1.05;
/// The smallest size that the camera's distance is made for, in metres.
const LEAST_M: f32 = 1e-5;
/// The angle to the side under which a resting scene is shown, so that its length is visible, in
/// radians.
const TURNED_RAD: f32 = 0.6;
/// The number of points by which the rims of the cylinder around a scene are sampled.
const RIM_POINTS: u32 = 64;

/// Returns the index of the camera of that name, or of the first one if no name is given. Returns
/// `None` if there is neither a name nor a camera.
///
/// # Errors
/// A name that no camera has, with the existing names.
pub fn find_camera(
    cameras: &[import::SceneCamera],
    wanted: Option<&str>,
    file: &dyn Display,
) -> Result<Option<usize>, RunError> {
    let Some(wanted) = wanted else {
        return Ok((!cameras.is_empty()).then_some(0));
    };
    if let Some(place) = cameras.iter().position(|camera| camera.name == wanted) {
        return Ok(Some(place));
    }
    let names: Vec<&str> = cameras.iter().map(|camera| camera.name.as_str()).collect();
    Err(RunError::user(match names.as_slice() {
        [] => format!(
            "there is no camera '{wanted}' in {file}, nor any other: name none to go around the scene"
        ),
        names => format!("{file}: {}", unknown("camera", wanted, names)),
    }))
}

/// The time of each frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrameClock {
    /// A fixed number of frames per second.
    Steady {
        /// The frames per second.
        hz: f64,
    },
    /// A time span, from its beginning in the first frame to its end in the last one.
    Spread {
        /// The time, in seconds.
        seconds: f64,
        /// The number of frames.
        frames: u32,
    },
}

impl FrameClock {
    /// Creates the clock of a walk of `frames` frames. If a clip of the camera lasts `seconds`, the
    /// walk plays it once from end to end.
    pub fn of_walk(seconds: Option<f32>, frames: u32) -> Self {
        match seconds {
            Some(seconds) => Self::Spread { seconds: seconds.into(), frames },
            None => Self::Steady { hz: FRAMES_A_SECOND },
        }
    }

    /// Returns the seconds after the beginning.
    pub fn seconds(&self, frame: u32) -> f64 {
        match *self {
            Self::Steady { hz } => f64::from(frame) / hz,
            Self::Spread { seconds, frames } => {
                let last = frames.saturating_sub(1).max(1);
                seconds * f64::from(frame.min(last)) / f64::from(last)
            }
        }
    }
}

/// Returns a camera of a file in each frame of `clock`, on images of `size` pixels, while clips
/// play.
pub fn cameras(
    animator: &mut SceneAnimator,
    camera: &import::SceneCamera,
    clock: FrameClock,
    frames: u32,
    size: [u32; 2],
) -> CameraTrack {
    animator.pose(clock.seconds(0));
    let first = animator.seen_by(camera, size);
    let others = if animator.moves(camera.node) { 1..frames } else { 1..1 };
    let others = others.map(|frame| {
        animator.pose(clock.seconds(frame));
        animator.seen_by(camera, size)
    });
    CameraTrack::Filmed(first, others.collect())
}

/// The playing clips of a file. No two of them move the same thing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Clips {
    playing: Vec<usize>,
}

impl Clips {
    /// Returns all clips but those that move something of an earlier one; `first` precedes all
    /// others.
    pub fn all(animator: &SceneAnimator, first: Option<usize>) -> Self {
        Self { playing: animator.compatible(first) }
    }

    /// Returns the clip after the one that plays alone. After the last clip, or after several, the
    /// first one follows.
    pub fn next(&self, animator: &SceneAnimator) -> Self {
        let after = match self.playing.as_slice() {
            [clip] => clip + 1,
            _ => 0,
        };
        let clip = after.checked_rem(animator.clips().len());
        Self { playing: clip.into_iter().collect() }
    }

    /// Returns their indices.
    pub fn playing(&self) -> &[usize] {
        &self.playing
    }

    /// Returns their names in words.
    pub fn describe(&self, animator: &SceneAnimator) -> String {
        let all = animator.clips();
        match self.playing.as_slice() {
            [] => "none".to_owned(),
            [clip] => all.get(*clip).map_or_else(String::new, |clip| clip.name.clone()),
            clips if clips.len() == all.len() => format!("all {}", clips.len()),
            clips => format!("{} of {}", clips.len(), all.len()),
        }
    }

    /// Returns a sentence about the clips that cannot play, if there are any.
    pub fn conflicts(&self, animator: &SceneAnimator) -> Option<String> {
        let left_out = animator.clips().iter().enumerate();
        let left_out = left_out.filter(|(place, _)| !self.playing.contains(place));
        let names: Vec<String> = left_out.map(|(_, clip)| format!("'{}'", clip.name)).collect();
        match names.len() {
            0 => None,
            1..=8 => Some(format!(
                "of its clips {} do not play at first: others move the same objects",
                names.join(", ")
            )),
            count => Some(format!(
                "{count} of its clips do not play at first: others move the same objects"
            )),
        }
    }
}

/// A turn around something that fits into the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    centre: Vec3,
    away_m: f32,
}

impl Orbit {
    /// Creates a turn around everything in `bounds`, on images of `size` pixels.
    pub fn around(bounds: &Aabb, size: [u32; 2]) -> Self {
        let half = (bounds.max - bounds.min) * 0.5;
        let is_something = half.is_finite() && half.cmpge(Vec3::ZERO).all();
        let (centre, half) = if is_something {
            ((bounds.min + bounds.max) * 0.5, half.max(Vec3::splat(LEAST_M)))
        } else {
            (Vec3::ZERO, Vec3::ONE)
        };
        // The upright cylinder around the bounds looks the same from all sides. Its rims determine
        // the distance at which it fits.
        let tangent_up = (FOV_Y_RAD * 0.5).tan() / ROOM;
        let tangent_across = tangent_up * size[0].max(1) as f32 / size[1].max(1) as f32;
        let (down, level) = DOWN_RAD.sin_cos();
        let rims = (0..RIM_POINTS).flat_map(|point| {
            let rim =
                Vec2::from_angle(TAU * point as f32 / RIM_POINTS as f32) * half.x.hypot(half.z);
            [-half.y, half.y].map(|height| {
                let nearer = rim.y * level + height * down;
                let up = height * level - rim.y * down;
                (rim.x.abs() / tangent_across).max(up.abs() / tangent_up) + nearer
            })
        });
        let away_m = rims.fold(0.0, f32::max);
        Self { centre, away_m }
    }

    /// Returns the camera in one of `frames` frames.
    pub fn camera(&self, frame: u32, frames: u32) -> Camera {
        let around = Vec2::from_angle(TAU * frame as f32 / frames.max(1) as f32);
        let (down, level) = DOWN_RAD.sin_cos();
        let outward = Vec3::new(around.y * level, down, around.x * level);
        Camera {
            eye: self.centre + outward * self.away_m,
            forward: -outward,
            up: Vec3::Y,
            projection: Projection::perspective(FOV_Y_RAD),
            near: self.away_m * 1e-3,
        }
    }
}

/// Returns a camera that looks at something from its front and somewhat from the side. It is as
/// near as images of `size` pixels allow if the left part of the image, a share of `covered` (from
/// 0 to less than 1) of the width, is covered.
pub fn portrait(bounds: &Aabb, size: [u32; 2], covered: f32) -> Camera {
    let Orbit { centre, .. } = Orbit::around(bounds, size);
    let (down, level) = DOWN_RAD.sin_cos();
    let (aside, ahead) = TURNED_RAD.sin_cos();
    let outward = Vec3::new(aside * level, down, ahead * level);
    let right = Vec3::new(ahead, 0.0, -aside);
    let up = outward.cross(right);
    let tangent_up = (FOV_Y_RAD * 0.5).tan() / ROOM;
    let tangent_across = tangent_up * size[0].max(1) as f32 / size[1].max(1) as f32;
    // The eye moves aside by this share of its distance, so that the centre is in the middle of the
    // free part.
    let aside_tangent = tangent_across * ROOM * covered;
    let free_tangent = tangent_across * (1.0 - covered);
    let away_for = |corner: Vec3| {
        let to = corner - centre;
        let nearer = to.dot(outward);
        let across = (to.dot(right) + aside_tangent * nearer).abs() / free_tangent;
        across.max(to.dot(up).abs() / tangent_up) + nearer
    };
    let away_m = bounds.corners().into_iter().map(away_for).fold(LEAST_M, f32::max);
    let away_m = if away_m.is_finite() { away_m } else { 1.0 };
    Camera {
        eye: centre + (outward - right * aside_tangent) * away_m,
        forward: -outward,
        up: Vec3::Y,
        projection: Projection::perspective(FOV_Y_RAD),
        near: away_m * 1e-3,
    }
}

#[cfg(test)]
mod tests {
    use antumbra::animation;

    use super::*;

    #[test]
    fn a_walk_goes_from_end_to_end() {
        let clock = FrameClock::of_walk(Some(12.0), 121);
        assert_eq!([0, 60, 120, 121].map(|frame| clock.seconds(frame)), [0.0, 6.0, 12.0, 12.0]);
        let one = FrameClock::of_walk(Some(12.0), 1);
        assert_eq!(one.seconds(0), 0.0);
        let steady = FrameClock::of_walk(None, 121);
        assert_eq!(steady.seconds(90), 1.5);
    }

    /// Checks that everything is in the image, and returns the part of its height or width that it
    /// fills.
    fn filled(camera: &Camera, bounds: &Aabb, size: [u32; 2]) -> f32 {
        let right = camera.forward.cross(Vec3::Y).normalize();
        let up = right.cross(camera.forward);
        let tangent = camera.projection.height_at(0.5);
        let aspect = size[0] as f32 / size[1] as f32;
        let mut most: f32 = 0.0;
        for corner in bounds.corners() {
            let to = corner - camera.eye;
            let depth = to.dot(camera.forward);
            assert!(depth > camera.near);
            let across = to.dot(right).abs() / (depth * tangent * aspect);
            most = most.max(across).max(to.dot(up).abs() / (depth * tangent));
        }
        assert!(most < 1.0, "{most}");
        most
    }

    #[test]
    fn a_portrait_fills_the_image_however_small_the_thing_is() {
        for scale in [1e-4, 1.0, 1e5] {
            let low = Vec3::new(-3.0, 0.0, 1.0);
            let high = Vec3::new(5.0, 2.0, 9.0);
            let bounds = Aabb { min: low * scale, max: high * scale };
            for size in [[1280, 720], [300, 900]] {
                let filled = filled(&portrait(&bounds, size, 0.0), &bounds, size);
                assert!(filled > 0.9, "{scale}: {filled}");
            }
        }
        for nothing in [Aabb::EMPTY, Aabb::new(Vec3::ONE, Vec3::ONE)] {
            let camera = portrait(&nothing, [4, 3], 0.0);
            assert!(camera.eye.is_finite() && camera.near > 0.0);
        }
    }

    #[test]
    fn a_portrait_leaves_free_what_is_covered() {
        let bounds = Aabb { min: Vec3::new(-3.0, 0.0, 1.0), max: Vec3::new(5.0, 2.0, 9.0) };
        for size in [[1280, 720], [960, 540], [300, 900]] {
            for covered in [0.0, 0.18, 0.25] {
                let camera = portrait(&bounds, size, covered);
                filled(&camera, &bounds, size);
                let right = camera.forward.cross(Vec3::Y).normalize();
                let tangent = camera.projection.height_at(0.5) * size[0] as f32 / size[1] as f32;
                let across = bounds.corners().map(|corner| {
                    let to = corner - camera.eye;
                    to.dot(right) / (to.dot(camera.forward) * tangent)
                });
                let leftmost = across.into_iter().fold(f32::INFINITY, f32::min);
                assert!(leftmost > 2.0 * covered - 1.0, "{size:?}, {covered}: {leftmost}");
            }
        }
    }

    #[test]
    fn a_turn_has_everything_in_the_image() {
        let bounds = Aabb { min: Vec3::new(-3.0, 0.0, 1.0), max: Vec3::new(5.0, 2.0, 9.0) };
        for size in [[1280, 720], [300, 900], [1, 1]] {
            let orbit = Orbit::around(&bounds, size);
            for frame in 0..7 {
                let camera = orbit.camera(frame, 7);
                filled(&camera, &bounds, size);
            }
        }
        let nothing = Orbit::around(&Aabb::EMPTY, [4, 3]).camera(0, 1);
        assert!(nothing.eye.is_finite() && nothing.near > 0.0);
    }

    #[test]
    fn cameras_are_found_or_listed() {
        let camera = |name: &str| import::SceneCamera {
            name: name.to_owned(),
            node: animation::RigNodeId(0),
            projection: Projection::perspective(1.0),
            aspect_ratio: None,
            near_m: 0.1,
        };
        let cameras = [camera("walk"), camera("fly")];
        let find = |wanted| find_camera(&cameras, wanted, &"a.glb");
        assert_eq!(find(None), Ok(Some(0)));
        assert_eq!(find(Some("fly")), Ok(Some(1)));
        let refused = find(Some("wlak")).unwrap_err();
        let expected = "a.glb: unknown camera 'wlak': there is walk and fly; did you mean 'walk'?";
        assert_eq!((refused.to_string().as_str(), refused.exit_code()), (expected, 2));
        assert_eq!(find_camera(&[], None, &"a.glb"), Ok(None));
        let refused = find_camera(&[], Some("walk"), &"a.glb").unwrap_err().to_string();
        assert!(refused.contains("nor any other"), "{refused}");
    }
}
