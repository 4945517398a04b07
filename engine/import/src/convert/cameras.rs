//! Cameras of the file.

use std::f32::consts::PI;

use cull::{Aabb, Projection};
use glam::Affine3A;
use gltf::json;
use gltf::json::validation::Checked;

use super::framing::LEAST_DISTANCE_M;
use super::nodes::Tree;
use super::numbers::direction;
use crate::Source;
use crate::error::quoted;
use crate::gltf_scene::SceneCamera;
use crate::notes::Notes;

/// The smallest and the largest field of view, in radians.
const ANGLES_RAD: [f32; 2] = [0.01, PI - 0.1];

/// The nearest and the farthest near plane of a perspective view, in metres.
const NEAR_M: [f32; 2] = [1e-6, 1e6];

/// The least and the greatest height of an orthographic camera's image, and distance between its
/// planes, in metres.
const SIDES_M: [f32; 2] = [1e-6, 1e9];

/// The least and the greatest aspect ratio of an image.
const ASPECT_RATIOS: [f32; 2] = [1e-3, 1e3];

/// The image size, in pixels, for the test whether a camera sees anything.
const IMAGE: [u32; 2] = [1600, 900];

/// The faults of projections. The values are replaced so that each camera shows something.
mod faults {
    pub(super) const ANGLE: &str = "its yfov is not between 0 and 180 degrees: shown with 60";
    pub(super) const EXTREME_ANGLE: &str =
        "its yfov is too near to 0 or 180 degrees: shown with the nearest from 0.6 to 174";
    pub(super) const EXTREME_NEAR: &str =
        "its znear is below 1e-6 or above 1e6: shown with the nearest between";
    pub(super) const EXTREME_SIZE: &str =
        "its height or length is below 1e-6 or above 1e9: shown with the nearest between";
    pub(super) const NOWHERE: &str =
        "it is under a scale of 0 and has no direction: shown along -z";
    pub(super) const ASPECT: &str =
        "its width by height is not between 1/1000 and 1000, and ignored";
    pub(super) const BLIND: &str = "it sees nothing of the scene at rest";
    pub(super) const ORDER: &str = "its zfar is not beyond its znear: shown between the two";
    pub(super) const HEIGHT: &str = "it has no height: shown as high as wide";
    pub(super) const NEAR: &str = "its zfar is not beyond its znear, or its znear is not above 0: shown from the nearer one on";
}

/// Returns all cameras of the scene's nodes in the order of the file's list of cameras.
pub(super) fn cameras(source: &Source, tree: &Tree, notes: &mut Notes) -> Vec<SceneCamera> {
    let json = source.document.as_json();
    let mut cameras = Vec::new();
    let mut in_order = tree.cameras.clone();
    in_order.sort_by_key(|(_, camera)| *camera);
    for (node, camera) in in_order {
        let Some(given) = json.cameras.get(camera) else { continue };
        let node_name = tree.node(node).map(|node| node.name.clone());
        let names = [node_name, given.name.clone()].into_iter().flatten();
        let name = names.into_iter().find(|name| !name.is_empty());
        let name = name.unwrap_or_else(|| format!("camera {camera}"));
        let (projection, near_m) = projection(given, &name, notes);
        let aspect_ratio = aspect_ratio(given, &name, notes);
        cameras.push(SceneCamera { name, node, projection, aspect_ratio, near_m });
    }
    cameras
}

/// Returns the projection, and the distance of the near plane.
fn projection(given: &json::Camera, name: &str, notes: &mut Notes) -> (Projection, f32) {
    let place = || format!("camera {}", quoted(name));
    if let Some(given) = perspective(given) {
        let is_angle = given.yfov.abs() > 0.0 && given.yfov.abs() < PI;
        notes.count(faults::ANGLE, usize::from(!is_angle), place);
        let angle_rad = if is_angle { given.yfov.abs() } else { scene::FOV_Y_RAD };
        let zfar = given.zfar.unwrap_or(f32::INFINITY);
        let near_m = if given.znear > 0.0 { given.znear.min(zfar) } else { zfar.min(0.0) };
        let is_in_order = given.znear > 0.0 && zfar > given.znear;
        notes.count(faults::NEAR, usize::from(!is_in_order), place);
        let near_m = if near_m > 0.0 { near_m } else { scene::NEAR_M };
        let mut within = |number: f32, least: f32, most: f32, what: &'static str| {
            notes.count(what, usize::from(!(least..=most).contains(&number)), place);
            number.clamp(least, most)
        };
        let angle_rad = within(angle_rad, ANGLES_RAD[0], ANGLES_RAD[1], faults::EXTREME_ANGLE);
        let near_m = within(near_m, NEAR_M[0], NEAR_M[1], faults::EXTREME_NEAR);
        return (Projection::perspective(angle_rad), near_m);
    }
    let Some(parallel) = &given.orthographic else {
        return (Projection::perspective(scene::FOV_Y_RAD), scene::NEAR_M);
    };
    let has_height = parallel.ymag != 0.0;
    notes.count(faults::HEIGHT, usize::from(!has_height), place);
    let half_height_m = if has_height { parallel.ymag.abs() } else { parallel.xmag.abs() };
    notes.count(faults::ORDER, usize::from(parallel.zfar <= parallel.znear), place);
    let sides_m = [(parallel.zfar - parallel.znear).abs(), 2.0 * half_height_m];
    let [length_m, height] = sides_m.map(|side_m| side_m.clamp(SIDES_M[0], SIDES_M[1]));
    // Sizes of 0 have notes of their own.
    let is_extreme = (sides_m != [length_m, height]) && !sides_m.contains(&0.0);
    notes.count(faults::EXTREME_SIZE, usize::from(is_extreme), place);
    let near_m = parallel.znear.min(parallel.zfar);
    (Projection::Orthographic { height, far: near_m + length_m }, near_m)
}

/// Returns the aspect ratio of a camera's image, if the file specifies it.
fn aspect_ratio(given: &json::Camera, name: &str, notes: &mut Notes) -> Option<f32> {
    let ratio = match (perspective(given), &given.orthographic) {
        (Some(perspective), _) => perspective.aspect_ratio,
        // An image of height 0 gets the height of its width.
        (None, Some(parallel)) if parallel.ymag != 0.0 => {
            Some((parallel.xmag / parallel.ymag).abs())
        }
        (None, _) => None,
    }?;
    let is_shape = (ASPECT_RATIOS[0]..=ASPECT_RATIOS[1]).contains(&ratio);
    notes.count(faults::ASPECT, usize::from(!is_shape), || format!("camera {}", quoted(name)));
    is_shape.then_some(ratio)
}

/// Returns the values of a perspective camera, which may also have the values of the other type.
fn perspective(given: &json::Camera) -> Option<&json::camera::Perspective> {
    let is_parallel = given.type_ == Checked::Valid(json::camera::Type::Orthographic);
    given.perspective.as_ref().filter(|_| !is_parallel)
}

/// The place of a camera at rest.
pub(super) struct Place {
    pub(super) world: Affine3A,
    /// True if the camera should see something at rest: the scene is not empty, and no clip moves
    /// the camera.
    pub(super) should_see: bool,
}

/// Notes a scene that is too small for any camera, and cameras that see nothing of the scene.
pub(super) fn check(cameras: &[SceneCamera], places: &[Place], scene: &Aabb, notes: &mut Notes) {
    let size_m = (scene.max - scene.min).max_element();
    if size_m > 0.0 && size_m < LEAST_DISTANCE_M {
        notes.say(format!(
            "it is {size_m:.1e} m large, and shown from no nearer than {LEAST_DISTANCE_M:e} m: little or nothing of it is seen"
        ));
    }
    for (camera, place) in cameras.iter().zip(places) {
        let name = || format!("camera {}", quoted(&camera.name));
        let has_direction = direction(place.world.matrix3.z_axis.into()).is_some();
        notes.count(faults::NOWHERE, usize::from(!has_direction), name);
        let view = cull::CullView::new(&camera.seen_from(&place.world, IMAGE), IMAGE, 8);
        let (containment, _) = view.frustum.classify(scene, cull::PlaneMask::ALL);
        let is_blind = place.should_see && containment == cull::Containment::Outside;
        notes.count(faults::BLIND, usize::from(is_blind), name);
    }
}

#[cfg(test)]
mod tests {
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
            (r#""yfov": 3.14159, "znear": 1"#, PI - 0.1, 1.0, Some(faults::EXTREME_ANGLE)),
            (r#""yfov": 0.001, "znear": 1"#, 0.01, 1.0, Some(faults::EXTREME_ANGLE)),
            (r#""yfov": 0.5, "znear": 1e-9"#, 0.5, 1e-6, Some(faults::EXTREME_NEAR)),
        ] {
            let text = format!(r#"{{"type": "perspective", "perspective": {{{projection}}}}}"#);
            let given = json::deserialize::from_str(&text).expect("a camera");
            let mut notes = Notes::default();
            let expected = (Projection::perspective(angle_rad), near_m);
            assert_eq!(super::projection(&given, "it", &mut notes), expected, "{projection}");
            let notes = notes.finish();
            let is_noted = |what: &str| matches!(notes.as_slice(), [note] if note.reason == what);
            assert!(noted.map_or(notes.is_empty(), is_noted), "{projection}: {notes:?}");
        }
    }

    #[test]
    fn orthographic_cameras_see_what_the_file_says() {
        for (values, height, near_m, far, noted) in [
            (r#""xmag": 3, "ymag": 5, "zfar": 19, "znear": 1"#, 10.0, 1.0, 19.0, None),
            (r#""xmag": 3, "ymag": -5, "zfar": 19, "znear": 0"#, 10.0, 0.0, 19.0, None),
            (r#""xmag": 3, "ymag": 0, "zfar": 9, "znear": 1"#, 6.0, 1.0, 9.0, Some(faults::HEIGHT)),
            (r#""xmag": 3, "ymag": 5, "zfar": 1, "znear": 4"#, 10.0, 1.0, 4.0, Some(faults::ORDER)),
            (
                r#""xmag": 3, "ymag": 1e-9, "zfar": 9, "znear": 1"#,
                1e-6,
                1.0,
                9.0,
                Some(faults::EXTREME_SIZE),
            ),
        ] {
            let text = format!(r#"{{"type": "orthographic", "orthographic": {{{values}}}}}"#);
            let given = json::deserialize::from_str(&text).expect("a camera");
            let mut notes = Notes::default();
            let expected = (Projection::Orthographic { height, far }, near_m);
            assert_eq!(super::projection(&given, "it", &mut notes), expected, "{values}");
            let notes = notes.finish();
            let is_noted = |what: &str| matches!(notes.as_slice(), [note] if note.reason == what);
            assert!(noted.map_or(notes.is_empty(), is_noted), "{values}: {notes:?}");
        }
    }
}
