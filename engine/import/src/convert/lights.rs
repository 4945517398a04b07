//! Lights: `KHR_lights_punctual`, one per node that has one, and the ambient light.

use std::f32::consts::FRAC_PI_2;

use animation::RigNodeId;
use glam::{Affine3A, Vec3, vec3};
use gltf::json::extensions::scene::khr_lights_punctual as khr;
use gltf::json::validation::Checked;
use scene::{Light, LightKind, PunctualLight};

use super::nodes::Tree;
use super::numbers::{direction, mirrors};
use crate::Source;
use crate::notes::Notes;

/// The brightest light, in lux or candela: a hundred suns.
const LARGEST_INTENSITY: f32 = 1e7;

/// A test of a light, and the note on lights that fail it.
type Fault = (fn(&khr::Light) -> bool, &'static str);

/// The faults of lights, whose values are replaced.
const FAULTS: &[Fault] = &[
    (|light| light.intensity < 0.0, "its light has an intensity below 0, and does not shine"),
    (
        |light| light.intensity > LARGEST_INTENSITY,
        "its light is brighter than a hundred suns, and shown like these",
    ),
    (
        |light| light.color.iter().any(|part| !(0.0..=1.0).contains(part)),
        "its light has a color that is not between 0 and 1, taken as 0 if below",
    ),
    (
        |light| light.range.is_some_and(|range| range <= 0.0),
        "its light has a range that is not above 0, and is shown without one",
    ),
    (
        |light| {
            let is_spot = light.type_ == Checked::Valid(khr::Type::Spot);
            is_spot && light.spot.as_ref().is_some_and(|spot| !is_cone(spot))
        },
        "its light has angles that are not 0 <= inner < outer <= 90 degrees, changed to fit",
    ),
];

fn is_cone(spot: &khr::Spot) -> bool {
    // A right angle in 64 bits may be slightly larger in 32.
    let most_rad = FRAC_PI_2 + 1e-6;
    spot.inner_cone_angle >= 0.0
        && spot.inner_cone_angle < spot.outer_cone_angle
        && spot.outer_cone_angle <= most_rad
}

/// Returns the ambient light of a scene; files do not specify it.
pub(super) fn surroundings() -> Light {
    Light {
        ambient_above: [0.23, 0.25, 0.28],
        ambient_below: [0.15, 0.145, 0.14],
        sky: [0.36, 0.50, 0.68],
        ..Light::afternoon()
    }
}

/// A light of a scene.
pub(super) struct PlacedLight {
    pub(super) light: PunctualLight,
    /// The node of the light; `None` if it is of no node.
    pub(super) node: Option<RigNodeId>,
}

/// Returns all lights of the scene's nodes, with their nodes; if there are none, a light from
/// above.
pub(super) fn lights(source: &Source, tree: &Tree, notes: &mut Notes) -> Vec<PlacedLight> {
    let json = source.document.as_json();
    let given =
        json.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
    let given = given.map(|extension| extension.lights.as_slice()).unwrap_or_default();
    let mut lights = Vec::new();
    for &(node, light) in &tree.lights {
        let Some(light) = given.get(light) else { continue };
        let world = tree.world(node);
        if world.translation.is_finite() {
            for (_, what) in FAULTS.iter().filter(|(is_wrong, _)| is_wrong(light)) {
                notes.count(what, 1, || tree.name(node));
            }
            if let Some(what) = turned(light, &world) {
                notes.count(what, 1, || tree.name(node));
            }
            lights.push(PlacedLight { light: placed(light, &world), node: Some(node) });
        } else {
            notes.count("its light is nowhere, and left out", 1, || tree.name(node));
        }
    }
    if lights.is_empty() {
        lights.push(PlacedLight { light: from_above(), node: None });
    }
    lights
}

/// Returns the note on a light whose direction differs from the rotation of its node, if it does: a
/// node's scale should not affect a light.
fn turned(given: &khr::Light, world: &Affine3A) -> Option<&'static str> {
    if !matches!(given.type_, Checked::Valid(khr::Type::Spot | khr::Type::Directional)) {
        return None;
    }
    if direction(along(world)).is_none() {
        return Some("its light is under a scale of 0 and has no direction: shown along -z");
    }
    mirrors(world)
        .then_some("its light is under a scale that mirrors: shown in the mirrored direction")
}

/// Returns the -z axis of a node in the world.
fn along(world: &Affine3A) -> Vec3 {
    Vec3::from(world.matrix3 * glam::Vec3A::NEG_Z)
}

/// Returns the light of scenes without lights.
pub(super) fn from_above() -> PunctualLight {
    PunctualLight {
        kind: LightKind::Directional,
        colour: [1.0, 0.97, 0.92],
        intensity: 3.0,
        range_m: None,
        position: Vec3::ZERO,
        direction: direction(vec3(-0.45, -0.75, -0.5)).unwrap_or(Vec3::NEG_Y),
        cookie: None,
    }
}

/// Returns a light at its node. It shines along the node's -z; other effects of the node's scale
/// are ignored.
fn placed(given: &khr::Light, world: &Affine3A) -> PunctualLight {
    let kind = match (&given.type_, &given.spot) {
        (Checked::Valid(khr::Type::Spot), Some(spot)) => {
            let outer_rad = spot.outer_cone_angle.clamp(1e-3, FRAC_PI_2);
            // Strictly less, otherwise the shader would divide by 0.
            let inner_rad = spot.inner_cone_angle.clamp(0.0, outer_rad - 5e-4);
            LightKind::Spot { inner_rad, outer_rad }
        }
        (Checked::Valid(khr::Type::Directional), _) => LightKind::Directional,
        _ => LightKind::Point,
    };
    PunctualLight {
        kind,
        colour: given.color.map(|part| part.clamp(0.0, 1e3)),
        intensity: given.intensity.clamp(0.0, LARGEST_INTENSITY),
        range_m: given.range.filter(|range| range.is_finite() && *range > 0.0),
        position: world.translation.into(),
        direction: direction(along(world)).unwrap_or(Vec3::NEG_Z),
        cookie: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(text: &str) -> khr::Light {
        gltf::json::deserialize::from_str(text).expect("a light")
    }

    #[test]
    fn lights_shine_along_minus_z_of_their_nodes() {
        let world = Affine3A::from_scale_rotation_translation(
            Vec3::splat(5.0),
            glam::Quat::from_rotation_y(FRAC_PI_2),
            vec3(1.0, 2.0, 3.0),
        );
        let spot = r#"{"type": "spot", "intensity": 7, "range": 4, "color": [1, 0.5, 0],
            "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}}"#;
        let placed = placed(&light(spot), &world);
        assert_eq!(placed.kind, LightKind::Spot { inner_rad: 0.25, outer_rad: 0.5 });
        assert_eq!((placed.intensity, placed.range_m), (7.0, Some(4.0)));
        assert_eq!((placed.colour, placed.position), ([1.0, 0.5, 0.0], vec3(1.0, 2.0, 3.0)));
        assert!(placed.direction.distance(Vec3::NEG_X) < 1e-6);
    }

    #[test]
    fn a_scale_that_turns_a_light_is_told() {
        let spot = light(r#"{"type": "spot", "spot": {}}"#);
        let note = |scale: Vec3| turned(&spot, &Affine3A::from_scale(scale));
        assert!(note(Vec3::ZERO).is_some_and(|note| note.contains("scale of 0")));
        assert!(note(Vec3::NEG_ONE).is_some_and(|note| note.contains("mirrors")));
        assert!(note(vec3(1.0, 1.0, 0.0)).is_some_and(|note| note.contains("scale of 0")));
        assert_eq!((note(Vec3::splat(0.1)), note(vec3(0.0, 0.0, 2.0))), (None, None));
        let point = light(r#"{"type": "point"}"#);
        assert_eq!(turned(&point, &Affine3A::from_scale(Vec3::ZERO)), None);
    }

    #[test]
    fn impossible_lights_become_possible() {
        let spot = r#"{"type": "spot", "intensity": -1, "range": -2,
            "spot": {"innerConeAngle": 3, "outerConeAngle": 2}}"#;
        let placed = placed(&light(spot), &Affine3A::from_scale(Vec3::ZERO));
        let LightKind::Spot { inner_rad, outer_rad } = placed.kind else {
            panic!("a spot is a spot");
        };
        assert!(0.0 < inner_rad && inner_rad < outer_rad && outer_rad <= FRAC_PI_2);
        assert_eq!((placed.intensity, placed.range_m), (0.0, None));
        assert_eq!(placed.direction, Vec3::NEG_Z);
    }
}
