//! Cameras of the file.
//!
//! All culling and drawing is in perspective, so an orthographic camera is shown from far behind
//! it, by a narrow view that shows as much at the middle of the scene.

use std::f32::consts::PI;

use cull::Aabb;
use glam::{Affine3A, Vec3};
use gltf::json;
use gltf::json::validation::Checked;

use super::nodes::Tree;
use crate::Source;
use crate::error::quoted;
use crate::gltf_scene::SceneCamera;
use crate::notes::Notes;

/// The narrowest and the widest field of view, in radians.
const ANGLES_RAD: [f32; 2] = [0.01, PI - 0.1];

/// The nearest and the farthest near planeof a view, in metres.
const NEAR_M: [f32; 2] = [1e-6, 1e6];

/// The least and the greatest half height of an orthographic camera's image, in metres.
const HALF_HEIGHTS_M: [f32; 2] = [1e-6, 1e5];

/// The least and the greatest aspect ratio of an image.
const ASPECT_RATIOS: [f32; 2] = [1e-3, 1e3];

/// The size in pixels of an image in which a camera should see something.
const IMAGE: [u32; 2] = [1600, 900];

/// The projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Lens {
    /// A perspective projection.
    Perspective {
        /// The full vertical field of view.
        angle_rad: f32,
    },
    /// An orthographic projection.
    Parallel {
        /// Half of the height of the image, in metres.
        half_height_m: f32,
        /// The distance of the near plane, in metres.
        near_m: f32,
    },
}

/// The faults of projections, which are replaced so that each camera shows something.
mod faults {
    pub(super) const ANGLE: &str =
        "cameras whose yfov is not between 0 and 180 degrees, shown with 60";
    pub(super) const ASPECT: &str =
        "cameras with a width by height that is not between 1/1000 and 1000, ignored";
    pub(super) const BLIND: &str = "cameras that see nothing of the scene at rest";
    pub(super) const HEIGHT: &str = "orthographic cameras without a height, shown as high as wide";
    pub(super) const NEAR: &str = "cameras with a zfar that is not beyond znear or a znear not above 0, shown from the nearer one on";
}

/// Returns all cameras of the scene's nodes in the order of the file's list of cameras, each with
/// its lens.
pub(super) fn cameras(
    source: &Source,
    tree: &Tree,
    notes: &mut Notes,
) -> (Vec<SceneCamera>, Vec<Lens>) {
    let json = source.document.as_json();
    let (mut cameras, mut lenses) = (Vec::new(), Vec::new());
    let mut in_order = tree.cameras.clone();
    in_order.sort_by_key(|(_, camera)| *camera);
    for (node, camera) in in_order {
        let Some(given) = json.cameras.get(camera) else { continue };
        let node_name = tree.node(node).map(|node| node.name.clone());
        let names = [node_name, given.name.clone()].into_iter().flatten();
        let name = names.into_iter().find(|name| !name.is_empty());
        let name = name.unwrap_or_else(|| format!("camera {camera}"));
        let (lens, fov_y_rad, near_m) = lens(given, &name, notes);
        let aspect_ratio = aspect_ratio(given, &name, notes);
        cameras.push(SceneCamera {
            name,
            node,
            fov_y_rad: fov_y_rad.clamp(ANGLES_RAD[0], ANGLES_RAD[1]),
            aspect_ratio,
            near_m: near_m.clamp(NEAR_M[0], NEAR_M[1]),
            behind_m: 0.0,
        });
        lenses.push(lens);
    }
    (cameras, lenses)
}

/// Returns its lens, its vertical field of view in radians, and the distance of the near plane.
fn lens(given: &json::Camera, name: &str, notes: &mut Notes) -> (Lens, f32, f32) {
    let from = |angle_rad: f32, near_m| (Lens::Perspective { angle_rad }, angle_rad, near_m);
    let place = || format!("camera {}", quoted(name));
    if let Some(given) = perspective(given) {
        let is_angle = given.yfov.abs() > 0.0 && given.yfov.abs() < PI;
        notes.count(faults::ANGLE, usize::from(!is_angle), place);
        let angle_rad = if is_angle { given.yfov.abs() } else { scene::FOV_Y_RAD };
        let zfar = given.zfar.unwrap_or(f32::INFINITY);
        let near_m = if given.znear > 0.0 { given.znear.min(zfar) } else { zfar.min(0.0) };
        let is_in_order = given.znear > 0.0 && zfar > given.znear;
        notes.count(faults::NEAR, usize::from(!is_in_order), place);
        return from(angle_rad, if near_m > 0.0 { near_m } else { scene::NEAR_M });
    }
    let Some(parallel) = &given.orthographic else {
        return from(scene::FOV_Y_RAD, scene::NEAR_M);
    };
    notes.count("orthographic cameras, shown by a narrow view from far away", 1, place);
    let has_height = parallel.ymag != 0.0;
    notes.count(faults::HEIGHT, usize::from(!has_height), place);
    let half_height_m = if has_height { parallel.ymag.abs() } else { parallel.xmag.abs() };
    let half_height_m = half_height_m.clamp(HALF_HEIGHTS_M[0], HALF_HEIGHTS_M[1]);
    notes.count(faults::NEAR, usize::from(parallel.zfar <= parallel.znear), place);
    let near_m = parallel.znear.min(parallel.zfar);
    (Lens::Parallel { half_height_m, near_m }, ANGLES_RAD[0], near_m)
}

/// Returns the aspect ratio of a camera's image, where the file gives one.
fn aspect_ratio(given: &json::Camera, name: &str, notes: &mut Notes) -> Option<f32> {
    let ratio = match (perspective(given), &given.orthographic) {
        (Some(perspective), _) => perspective.aspect_ratio,
        // An image without a height is as high as wide.
        (None, Some(parallel)) if parallel.ymag != 0.0 => {
            Some((parallel.xmag / parallel.ymag).abs())
        }
        (None, _) => None,
    }?;
    let is_shape = (ASPECT_RATIOS[0]..=ASPECT_RATIOS[1]).contains(&ratio);
    notes.count(faults::ASPECT, usize::from(!is_shape), || format!("camera {}", quoted(name)));
    is_shape.then_some(ratio)
}

/// Returns the values of a perspective camera, which may have the values of the other type too.
fn perspective(given: &json::Camera) -> Option<&json::camera::Perspective> {
    let is_parallel = given.type_ == Checked::Valid(json::camera::Type::Orthographic);
    given.perspective.as_ref().filter(|_| !is_parallel)
}

/// The place of a camera at rest.
pub(super) struct Place {
    pub(super) world: Affine3A,
    /// True if it is wrong to see nothing from there: there is something, and no clip moves the
    /// camera.
    pub(super) should_see: bool,
}

/// Moves cameras to the places from which they see the scene. Cameras that see nothing of it are
/// noted.
pub(super) fn settle(
    cameras: &mut [SceneCamera],
    lenses: &[Lens],
    places: &[Place],
    scene: &Aabb,
    notes: &mut Notes,
) {
    for ((camera, lens), place) in cameras.iter_mut().zip(lenses).zip(places) {
        step_back(camera, *lens, &place.world, scene);
        let view = cull::View::new(&camera.seen_from(&place.world, IMAGE), IMAGE, 8);
        let (containment, _) = view.frustum.classify(scene, cull::PlaneMask::ALL);
        let is_blind = place.should_see && containment == cull::Containment::Outside;
        let name = || format!("camera {}", quoted(&camera.name));
        notes.count(faults::BLIND, usize::from(is_blind), name);
    }
}

/// Moves the eye of an orthographic camera, which is at a node, as far behind the node as needed.
fn step_back(camera: &mut SceneCamera, lens: Lens, at: &Affine3A, scene: &Aabb) {
    let Lens::Parallel { half_height_m, near_m } = lens else { return };
    let away_m = half_height_m / (ANGLES_RAD[0] * 0.5).tan();
    let forward = Vec3::from(-at.matrix3.z_axis).normalize_or(Vec3::NEG_Z);
    let middle_m = (scene.centre() - Vec3::from(at.translation)).dot(forward).max(near_m);
    let behind_m = away_m - middle_m;
    if behind_m.is_finite() {
        camera.behind_m = behind_m;
        // The eye is before its node where the scene is very far from the node.
        camera.near_m = (behind_m + near_m).max(away_m * 1e-3).clamp(NEAR_M[0], NEAR_M[1]);
    }
}

#[cfg(test)]
mod tests {
    use animation::RigNodeId;

    use super::*;

    #[test]
    fn projections_that_cannot_be_are_replaced_and_noted() {
        let default = scene::FOV_Y_RAD;
        for (projection, angle_rad, near_m, noted) in [
            (r#""yfov": 0.5, "znear": 0.25, "zfar": 9"#, 0.5, 0.25, None),
            (r#""yfov": 0, "znear": 0.25"#, default, 0.25, Some(faults::ANGLE)),
            (r#""yfov": 3.2, "znear": 0.25"#, default, 0.25, Some(faults::ANGLE)),
            (r#""yfov": 0.5, "znear": 100, "zfar": 0.5"#, 0.5, 0.5, Some(faults::NEAR)),
            (r#""yfov": 0.5, "znear": 0"#, 0.5, scene::NEAR_M, Some(faults::NEAR)),
        ] {
            let text = format!(r#"{{"type": "perspective", "perspective": {{{projection}}}}}"#);
            let given = json::deserialize::from_str(&text).expect("a camera");
            let mut notes = Notes::default();
            let (_, angle, near) = lens(&given, "it", &mut notes);
            assert_eq!((angle, near), (angle_rad, near_m), "{projection}");
            let notes = notes.finish();
            let is_noted = |what: &str| matches!(notes.as_slice(), [note] if note.reason == what);
            assert!(noted.map_or(notes.is_empty(), is_noted), "{projection}: {notes:?}");
        }
    }

    #[test]
    fn orthographic_cameras_see_as_much_at_the_middle_of_the_scene_and_nearly_so_elsewhere() {
        let text = r#"{"type": "orthographic", "name": "plan",
            "orthographic": {"xmag": 3, "ymag": 5, "zfar": 19, "znear": 1}}"#;
        let mut notes = Notes::default();
        let given = json::deserialize::from_str(text).expect("a camera");
        let (lens, angle_rad, _) = lens(&given, "plan", &mut notes);
        assert_eq!(aspect_ratio(&given, "plan", &mut notes), Some(0.6));
        let texts: Vec<String> = notes.finish().iter().map(ToString::to_string).collect();
        let note = "camera \"plan\": orthographic cameras, shown by a narrow view from far away";
        assert_eq!(texts, [note]);
        let at = Affine3A::from_translation(Vec3::new(0.0, 2.0, 12.0));
        let scene = Aabb::new(Vec3::splat(-4.0), Vec3::splat(4.0));
        let mut camera = SceneCamera {
            name: String::new(),
            node: RigNodeId(0),
            fov_y_rad: angle_rad,
            aspect_ratio: Some(0.6),
            near_m: 1.0,
            behind_m: 0.0,
        };
        step_back(&mut camera, lens, &at, &scene);
        let half_height = |z: f32| (angle_rad * 0.5).tan() * (12.0 - z + camera.behind_m);
        assert!((half_height(0.0) - 5.0).abs() < 1e-3, "{}", half_height(0.0));
        for z in [-4.0, 4.0] {
            assert!((half_height(z) / 5.0 - 1.0).abs() < 0.005, "{}", half_height(z));
        }
        assert!((camera.near_m - camera.behind_m - 1.0).abs() < 1e-3, "it begins where it did");
    }
}
