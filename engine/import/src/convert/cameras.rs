//! Cameras of the file.

use std::f32::consts::PI;

use animation::NodeId;
use gltf::json;

use super::nodes::Tree;
use super::notes::Notes;
use crate::Source;
use crate::error::quoted;
use crate::imported::Camera;

/// The narrowest and the widest angle of sight, in radians.
const ANGLES_RAD: [f32; 2] = [0.01, PI - 0.1];

/// The nearest and the farthest near plane, in metres.
const NEAR_M: [f32; 2] = [1e-4, 1e6];

/// All cameras of the scene's nodes, in their order.
pub(super) fn cameras(source: &Source, tree: &Tree, notes: &mut Notes) -> Vec<Camera> {
    let json = source.document.as_json();
    let mut cameras = Vec::new();
    for (node, in_file) in (0..).map(NodeId).zip(&tree.in_file) {
        let given = json.nodes.get(*in_file).and_then(|node| node.camera);
        let Some(given) = given.and_then(|camera| json.cameras.get(camera.value())) else {
            continue;
        };
        let (fov_y_rad, near_m) = lens(given, notes);
        let node_name = tree.node(node).map(|node| node.name.clone());
        let names = [node_name, given.name.clone()].into_iter().flatten();
        let name = names.into_iter().find(|name| !name.is_empty());
        cameras.push(Camera {
            name: name.unwrap_or_else(|| format!("camera {}", cameras.len())),
            node,
            fov_y_rad: fov_y_rad.clamp(ANGLES_RAD[0], ANGLES_RAD[1]),
            near_m: near_m.clamp(NEAR_M[0], NEAR_M[1]),
        });
    }
    cameras
}

/// The vertical angle of sight in radians, and the distance of the near plane.
fn lens(given: &json::Camera, notes: &mut Notes) -> (f32, f32) {
    if let Some(perspective) = &given.perspective {
        return (perspective.yfov.abs(), perspective.znear);
    }
    let Some(parallel) = &given.orthographic else {
        return (render::scene::FOV_Y_RAD, render::scene::NEAR_M);
    };
    notes.count("orthographic cameras, shown in perspective", 1, || {
        format!("camera {}", quoted(given.name.as_deref().unwrap_or_default()))
    });
    // As much is seen in the middle of its depth.
    let distance = (parallel.znear * 0.5 + parallel.zfar * 0.5).max(1e-3);
    (2.0 * (parallel.ymag.abs() / distance).atan(), parallel.znear.max(distance * 1e-3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orthographic_cameras_see_as_much_in_the_middle_of_their_depth() {
        let text = r#"{"type": "orthographic", "name": "plan",
            "orthographic": {"xmag": 3, "ymag": 5, "zfar": 19, "znear": 1}}"#;
        let mut notes = Notes::default();
        let (angle, near) = lens(&json::deserialize::from_str(text).expect("a camera"), &mut notes);
        assert!(((angle * 0.5).tan() * 10.0 - 5.0).abs() < 1e-5);
        assert_eq!(near, 1.0);
        assert_eq!(
            notes.finish(),
            ["orthographic cameras, shown in perspective: 1, first in camera \"plan\""]
        );
    }
}
