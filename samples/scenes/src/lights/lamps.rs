//! Lit street lamps: the lamps nearest to the camera's path.

use std::ops::RangeInclusive;

use glam::{Vec3, vec3};
use scene::{LightKind, Mesh, MeshId, Object, PunctualLight, Scene, Surfaces};

use super::super::city::LAMP_NAME;
use super::super::error::GeneratorError;
use super::glow;

/// The position of the light in the space of a lamp: in front of the post and below its globes,
/// where no part of the lamp is between the light and the ground.
const LIGHT_PLACE: Vec3 = vec3(0.0, 4.36, 0.32);

/// The direction of a spot light in this space: down, and slightly away from the post.
const SPOT_ALONG: Vec3 = vec3(0.0, -1.0, 0.22);

/// The half angles of a spot's cone in radians: 35 and 62 degrees.
const INNER_RAD: f32 = 0.61;
const OUTER_RAD: f32 = 1.08;

/// The intensity and the range of a spot light. A white pavement below it is slightly overexposed,
/// and beyond the range its light is not visible.
const SPOT_CD: f32 = 130.0;
const SPOT_RANGE_M: f32 = 24.0;

/// The intensity and the range of a point light, which shines on the walls, too.
const TORCH_CD: f32 = 55.0;
const TORCH_RANGE_M: f32 = 18.0;

/// The colours of sodium lamps and of flames.
const SPOT_COLOUR: [f32; 3] = [1.0, 0.80, 0.52];
const TORCH_COLOUR: [f32; 3] = [1.0, 0.58, 0.26];

/// The distance along the path that counts as much as a metre beside it, in metres.
const METRES_AHEAD: f32 = 4.0;

/// The most places of a path with which lamps are compared.
const MOST_EYES: usize = 256;

/// The kind of light of a lamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LampKind {
    /// A point light.
    Torch,
    /// A spot light that shines down.
    Spot,
}

/// Returns a scene with surfaces whose lamps nearest to the path are lit: as many as it has, within
/// the range of numbers.
pub(super) fn light_lamps(
    mut scene: Scene,
    eyes: &[Vec3],
    kind: LampKind,
    count: RangeInclusive<u32>,
) -> Result<Scene, GeneratorError> {
    let mut lamps = lamps_of(&scene);
    if (lamps.len() as u64) < u64::from(*count.start()) {
        return Err(GeneratorError::TooFewLamps { asked: *count.start(), found: lamps.len() });
    }
    let eyes = way_of(eyes);
    let far = |(_, place): &(usize, Vec3)| {
        let far = |(eye, walked_m): &(Vec3, f32)| eye.distance(*place) + walked_m / METRES_AHEAD;
        eyes.iter().map(far).fold(f32::INFINITY, f32::min)
    };
    // The sort is stable: lamps at equal distances stay in the scene's order.
    lamps.sort_by(|a, b| far(a).total_cmp(&far(b)));
    lamps.truncate(*count.end() as usize);
    let lit = glow::add_lit_lamp(&mut scene);
    glow::light_windows(&mut scene);
    let mut lights = Vec::with_capacity(lamps.len());
    for (index, _) in lamps {
        if let Some(object) = scene.objects.get_mut(index) {
            lights.push(light_of(object, kind));
            object.mesh = lit.unwrap_or(object.mesh);
        }
    }
    if let Some(Surfaces { lights: of_scene, .. }) = &mut scene.surfaces {
        of_scene.extend(lights);
    }
    Ok(scene)
}

/// Returns true if a mesh is a street lamp.
pub(super) fn is_lamp(mesh: &Mesh) -> bool {
    mesh.name == LAMP_NAME
}

pub(super) fn lamp_mesh(scene: &Scene) -> Option<MeshId> {
    scene.meshes.iter().position(is_lamp).map(|mesh| MeshId(mesh as u32))
}

/// Returns the lamps of a scene: their object indices and their positions in the world.
fn lamps_of(scene: &Scene) -> Vec<(usize, Vec3)> {
    let objects = scene.objects.iter().enumerate();
    let lamps = objects.filter(|(_, object)| scene.mesh_of(object).is_some_and(is_lamp));
    lamps.map(|(index, object)| (index, object.transform.translation.into())).collect()
}

/// Returns some places of a path, with the distance walked to each.
fn way_of(eyes: &[Vec3]) -> Vec<(Vec3, f32)> {
    let Some(first) = eyes.first() else { return vec![(Vec3::ZERO, 0.0)] };
    let mut before = *first;
    let mut walked_m = 0.0;
    let eyes = eyes.iter().step_by(eyes.len().div_ceil(MOST_EYES).max(1));
    let walk = |eye: &Vec3| {
        walked_m += eye.distance(before);
        before = *eye;
        (*eye, walked_m)
    };
    eyes.map(walk).collect()
}

fn light_of(lamp: &Object, kind: LampKind) -> PunctualLight {
    let (light_kind, colour, intensity, range_m) = match kind {
        LampKind::Torch => (LightKind::Point, TORCH_COLOUR, TORCH_CD, TORCH_RANGE_M),
        LampKind::Spot => {
            let spot = LightKind::Spot { inner_rad: INNER_RAD, outer_rad: OUTER_RAD };
            (spot, SPOT_COLOUR, SPOT_CD, SPOT_RANGE_M)
        }
    };
    let along = lamp.transform.transform_vector3(SPOT_ALONG);
    PunctualLight {
        kind: light_kind,
        colour,
        intensity,
        range_m: Some(range_m),
        position: lamp.transform.transform_point3(LIGHT_PLACE),
        direction: along.normalize_or(Vec3::NEG_Y),
        cookie: None,
    }
}
