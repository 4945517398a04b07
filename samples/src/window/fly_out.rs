//! The animation that shows culling at work: a walk, the moment at which the culling is frozen, a
//! flight of the eye above that moment and back, and the walk again.

use std::collections::VecDeque;
use std::f32::consts::TAU;
use std::path::Path;

use antumbra::cull::Camera;
use antumbra::glam::Vec3;
use antumbra::gpu::{Device, Readback};
use antumbra::render::{FrameRequest, RenderView, Renderer, VisibilitySnapshot};

use super::loaded_scene::LoadedScene;
use super::scene_view::SceneView;
use super::show::ShowOptions;
use bench::animated_png::AnimatedPng;
use bench::memory::copy_of;
use bench::run_error::RunError;
use bench::signals::Signals;
use bench::strategy::Strategy;
use bench::terminal::output::say_wrote;

/// The number of images without `--frames`: six seconds.
pub const IMAGES: u32 = 84;
/// The most images: their pixels are kept until the colours of the file are known.
pub const MAX_IMAGES: u32 = 600;
const IMAGES_PER_SECOND: u16 = 14;

/// The frame of the path at which the walk begins: on `street` in a corner before a long street.
const FIRST_FRAME: u32 = 124;
/// The number of frames of the path from one image to the next.
const STEP: u32 = 4;
/// The number of images before the first one that are drawn, so that the culling is settled.
const LEAD_IN: u32 = 8;

/// The shares of the images, in percent, before and after which the eye flies.
const FLIGHT: [u32; 2] = [22, 78];
/// The number of images of which one fades to the beginning.
const FADING: u32 = 16;
/// The share of the flight that leads out, and that leads back.
const SLOPE: f32 = 0.36;
/// The place of the eye above the frozen moment, from the place of the walker, in metres.
const BACK_M: f32 = 42.0;
const UP_M: f32 = 82.0;
const ASIDE_M: f32 = 26.0;
/// The distance of the point on the ground that the eye above looks at, in metres.
const AHEAD_M: f32 = 62.0;

/// A moment of the animation.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Moment {
    /// A walk, so many images after its beginning.
    Walk(u32),
    /// A flight, at this part of it: 0 is its beginning, 1 its end.
    Flight(f32),
}

/// The moments of an animation of this number of images.
#[derive(Clone, Copy, Debug)]
struct Schedule {
    images: u32,
}

impl Schedule {
    /// Returns the images at which the flight begins and ends.
    fn flight(self) -> [u32; 2] {
        FLIGHT.map(|share| self.images * share / 100)
    }

    fn moment(self, image: u32) -> Moment {
        let [begin, end] = self.flight();
        if image < begin {
            Moment::Walk(image)
        } else if image < end {
            Moment::Flight((image - begin + 1) as f32 / (end - begin + 1) as f32)
        } else {
            Moment::Walk(image - (end - begin))
        }
    }

    /// Returns the number of images at the end that fade to the beginning.
    fn fading(self) -> u32 {
        (self.images / FADING).min(LEAD_IN)
    }

    /// Returns the share of the beginning in an image.
    fn faded(self, image: u32) -> f32 {
        let left = self.images.saturating_sub(image);
        1.0 - left as f32 / (self.fading() + 1) as f32
    }
}

/// Returns the camera of a flight from a walker's and back, at this part of it.
fn flying(walker: Camera, part: f32) -> Camera {
    let smooth = |part: f32| {
        let part = part.clamp(0.0, 1.0);
        part * part * part * (part * (part * 6.0 - 15.0) + 10.0)
    };
    let lift = smooth(part / SLOPE).min(smooth((1.0 - part) / SLOPE));
    let level = Vec3::new(walker.forward.x, 0.0, walker.forward.z);
    let along = level.try_normalize().unwrap_or(Vec3::X);
    let aside = along.cross(Vec3::Y) * (ASIDE_M * (TAU * part).sin());
    let above = walker.eye - along * BACK_M + aside + Vec3::Y * UP_M;
    let ground = Vec3::new(walker.eye.x, 0.0, walker.eye.z) + along * AHEAD_M;
    let ahead = walker.forward.normalize_or(along);
    let down = (ground - above).normalize_or(along);
    Camera { eye: walker.eye.lerp(above, lift), forward: ahead.lerp(down, lift), ..walker }
}

/// The renderer and the state of the walk.
struct Walk<'a> {
    device: &'a Device,
    renderer: Renderer,
    scene_view: SceneView,
    strategy: Strategy,
    history: RenderView,
    /// The camera of the newest frame.
    camera: Camera,
    image: Readback,
}

impl Walk<'_> {
    /// Draws the frames up to the image with this number, counted from the lead-in, and returns it.
    /// Waits for each frame, so that the culling knows the same results in each run.
    fn image_at(&mut self, number: u32) -> Result<Vec<u8>, RunError> {
        let last = FIRST_FRAME + number * STEP - LEAD_IN * STEP;
        for frame in last.saturating_sub(STEP - 1)..=last {
            let camera = self.scene_view.camera(frame, self.renderer.size());
            self.camera = camera.unwrap_or(self.scene_view.start);
            let request = FrameRequest::new(self.strategy, self.camera);
            let request = FrameRequest { image: Some(&self.image), ..request };
            self.renderer.render(&mut self.history, request)?;
            self.renderer.wait_idle(&mut self.history)?;
        }
        copy_of(&self.image.rgba8()?)
    }

    /// Freezes the newest frame.
    fn freeze(&mut self) -> Result<VisibilitySnapshot, RunError> {
        let view = self.renderer.view_of(&self.camera);
        Ok(self.renderer.snapshot(&mut self.history, view)?)
    }

    /// Draws the frozen moment at this part of the flight.
    fn image_from_above(
        &mut self,
        frozen: &VisibilitySnapshot,
        part: f32,
    ) -> Result<Vec<u8>, RunError> {
        let camera = flying(self.camera, part);
        self.renderer.render_snapshot(frozen, camera, Some(&self.image), None)?;
        self.device.wait_idle()?;
        copy_of(&self.image.rgba8()?)
    }
}

/// Draws the animation and writes it to `file`. A signal ends it without a file.
///
/// # Errors
/// A strategy whose decisions only the GPU knows; a failed device; a file that cannot be written.
pub fn run(
    device: &Device,
    options: &ShowOptions,
    loaded: LoadedScene,
    file: &Path,
    signals: &Signals,
) -> Result<(), RunError> {
    let LoadedScene { renderer, scene_view, .. } = loaded;
    let strategy = options.strategy;
    renderer.supports(strategy)?;
    let size = options.size;
    let mut walk = Walk {
        device,
        strategy,
        history: renderer.new_view()?,
        camera: scene_view.start,
        image: Readback::new(device, [size.width, size.height])?,
        renderer,
        scene_view,
    };
    let schedule = Schedule { images: options.frames.unwrap_or(IMAGES) };
    let mut beginning = VecDeque::new();
    for number in 0..LEAD_IN {
        beginning.push_back(walk.image_at(number)?);
    }
    beginning.drain(..(LEAD_IN - schedule.fading()) as usize);
    let mut animation = AnimatedPng::new(size, IMAGES_PER_SECOND);
    let mut frozen = None;
    for image in 0..schedule.images {
        if signals.received().is_some() {
            return Err(RunError::given_up());
        }
        let mut pixels = match schedule.moment(image) {
            Moment::Walk(number) => walk.image_at(LEAD_IN + number)?,
            Moment::Flight(part) => {
                let snapshot = match frozen.take() {
                    Some(snapshot) => snapshot,
                    None => walk.freeze()?,
                };
                let pixels = walk.image_from_above(&snapshot, part)?;
                frozen = Some(snapshot);
                pixels
            }
        };
        if image + schedule.fading() >= schedule.images
            && let Some(first) = beginning.pop_front()
        {
            mix(&mut pixels, &first, schedule.faded(image));
        }
        animation.push(&pixels).map_err(RunError::machine)?;
    }
    animation.write(file).map_err(RunError::machine)?;
    say_wrote(file);
    Ok(())
}

/// Mixes this share of other pixels into pixels.
fn mix(pixels: &mut [u8], others: &[u8], share: f32) {
    for (pixel, other) in pixels.iter_mut().zip(others) {
        let part = f32::from(*pixel);
        *pixel = (part + (f32::from(*other) - part) * share).round() as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use antumbra::cull::Projection;

    #[test]
    fn the_walk_goes_on_where_it_was_frozen() {
        for images in [1, 2, 3, 9, 16, IMAGES, MAX_IMAGES] {
            let schedule = Schedule { images };
            let moments = (0..images).map(|image| schedule.moment(image));
            let mut walked = 0;
            let mut flown = 0.0;
            for moment in moments {
                match moment {
                    Moment::Walk(number) => {
                        assert_eq!(number, walked);
                        walked += 1;
                    }
                    Moment::Flight(part) => {
                        assert!(part > flown && part < 1.0, "{images}: {part}");
                        flown = part;
                    }
                }
            }
            assert!(walked > 0 && (images < 9 || flown > 0.7));
        }
    }

    #[test]
    fn the_end_fades_to_the_beginning() {
        let schedule = Schedule { images: IMAGES };
        assert_eq!(schedule.fading(), 5);
        let shares: Vec<f32> = (IMAGES - 5..IMAGES).map(|image| schedule.faded(image)).collect();
        assert!(shares[0] > 0.0 && shares[4] < 1.0 && shares.is_sorted());
        let mut pixels = [0, 100, 255];
        mix(&mut pixels, &[100, 0, 255], 0.25);
        assert_eq!(pixels, [25, 75, 255]);
    }

    #[test]
    fn the_eye_flies_from_the_walker_and_back() {
        let walker = Camera {
            eye: Vec3::new(3.0, 1.7, 5.0),
            forward: Vec3::new(0.0, 0.05, -2.0),
            up: Vec3::Y,
            projection: Projection::perspective(1.0),
            near: 0.2,
        };
        for end in [0.0, 1.0] {
            let camera = flying(walker, end);
            assert!(camera.eye.distance(walker.eye) < 1e-3);
            assert!(camera.forward.angle_between(walker.forward) < 1e-3);
        }
        let above = flying(walker, 0.5);
        assert!(above.eye.y > 80.0 && above.forward.y < -0.5 && above.forward.z < -0.5);
        // No step is a leap.
        let path: Vec<Vec3> = (0..48).map(|at| flying(walker, at as f32 / 47.0).eye).collect();
        assert!(path.windows(2).all(|pair| pair[0].distance(pair[1]) < 12.0));
    }
}
