//! Exposure: files specify lights in lux and candela, but no camera exposure. If the lights would
//! make nearly everything white, all lights are dimmed by one factor.
//!
//! The factor depends only on the scene at rest, so all frames use the same factor. The lights are
//! dimmed instead of the whole image, since emission and ambient light need no exposure.

use std::collections::HashMap;
use std::f32::consts::PI;

use cull::Aabb;
use glam::Vec3;
use scene::{LightKind, MeshId, PunctualLight, Scene, Surfaces};

use crate::notes::Notes;

/// The greatest median of the light that lit objects reflect for which lights are not dimmed:
/// brighter objects are white in the image.
const MOST_RADIANCE: f32 = 1.0;

/// The median of the light that objects reflect after dimming.
const DIMMED_RADIANCE: f32 = 0.5;

/// The assumed albedo of a texture.
const TEXTURE_ALBEDO: f32 = 1.0 / 3.0;

/// The most vertices of an object whose colours are sampled.
const MOST_VERTICES: usize = 64;

/// The most objects that are sampled.
const MOST_OBJECTS: usize = 512;

/// The most pairs of an object and a light that are sampled.
const MOST_PAIRS: usize = 1 << 22;

/// Sets the exposure of a scene to `wanted`, or to 1 with dimmed lights if necessary.
pub(super) fn set(wanted: Option<f32>, scene: &Scene, surfaces: &mut Surfaces, notes: &mut Notes) {
    match wanted {
        Some(exposure) => surfaces.exposure = exposure,
        None => dim(scene, surfaces, notes),
    }
}

/// Dims the lights of a scene if most of the lit objects would be white, and notes it.
fn dim(scene: &Scene, surfaces: &mut Surfaces, notes: &mut Notes) {
    let objects = scene.objects.iter().chain(&surfaces.transparent);
    let count = scene.objects.len() + surfaces.transparent.len();
    let most = (MOST_PAIRS / surfaces.lights.len().max(1)).clamp(1, MOST_OBJECTS);
    let mut albedos = HashMap::new();
    let receivers: Vec<Receiver> = objects
        .step_by(count.div_ceil(most).max(1))
        .filter_map(|object| {
            let known = albedos.entry(object.mesh);
            let albedo = (*known.or_insert_with(|| albedo(surfaces, object.mesh)))?;
            Some(Receiver::new(scene.bounds_of(object)?, albedo))
        })
        .collect();
    let Some(factor) = factor(&surfaces.lights, &receivers) else { return };
    for light in &mut surfaces.lights {
        light.intensity *= factor;
    }
    notes.say(format!(
        "the lights are too bright for an exposure of 1: dimmed to {factor:.3e} of what the file says, \
         unless an exposure is given"
    ));
}

/// An object that receives light.
struct Receiver {
    bounds: Aabb,
    centre: Vec3,
    half_extent: Vec3,
    /// The albedo of the brightest channel.
    albedo: f32,
}

impl Receiver {
    fn new(bounds: Aabb, albedo: f32) -> Self {
        Self { bounds, centre: bounds.centre(), half_extent: bounds.half_extent(), albedo }
    }
}

/// Returns the albedo of a mesh; `None` if its material is unlit.
fn albedo(surfaces: &Surfaces, mesh: MeshId) -> Option<f32> {
    let mesh = surfaces.meshes.get(mesh.0 as usize)?;
    let material = surfaces.materials.get(mesh.material.0 as usize)?;
    if material.is_unlit {
        return None;
    }
    let step = mesh.vertices.len().div_ceil(MOST_VERTICES).max(1);
    let colours = mesh.vertices.iter().step_by(step).map(|vertex| vertex.colour);
    let count = colours.len().max(1) as f32;
    let mut means = [0.0_f32; 3];
    for colour in colours {
        let parts = colour.map(|part| f32::from(part) / f32::from(u16::MAX));
        means.iter_mut().zip(parts).for_each(|(mean, part)| *mean += part / count);
    }
    let sent = means.into_iter().zip(material.base_colour).map(|(mean, factor)| mean * factor);
    let of_texture = material.base_colour_texture.map_or(1.0, |_| TEXTURE_ALBEDO);
    Some(sent.fold(0.0, f32::max) * of_texture)
}

/// Returns the factor for lights that shine on objects; `None` if they are not dimmed.
fn factor(lights: &[PunctualLight], receivers: &[Receiver]) -> Option<f32> {
    let sent = |receiver: &Receiver| {
        let lux = lights.iter().map(|light| illuminance_lx(light, receiver)).sum::<f32>();
        lux * receiver.albedo / PI
    };
    let mut sent: Vec<f32> = receivers.iter().map(sent).filter(|sent| *sent > 0.0).collect();
    sent.sort_unstable_by(f32::total_cmp);
    let median = *sent.get(sent.len() / 2)?;
    (median > MOST_RADIANCE).then_some(DIMMED_RADIANCE / median)
}

/// Returns the illuminance by a light on a surface that faces it, at the mean distance of points in
/// a box. There are up to [`MOST_PAIRS`] calls.
fn illuminance_lx(light: &PunctualLight, receiver: &Receiver) -> f32 {
    let &Receiver { bounds, centre, half_extent: half, .. } = receiver;
    let strongest = light.colour.into_iter().fold(0.0, f32::max) * light.intensity;
    if light.kind == LightKind::Directional {
        return strongest;
    }
    let nearest = (light.position.clamp(bounds.min, bounds.max) - light.position).length();
    let is_reached = light.range_m.is_none_or(|range_m| nearest < range_m);
    if !is_reached {
        return 0.0;
    }
    let to = centre - light.position;
    let is_lit = match light.kind {
        LightKind::Directional | LightKind::Point => true,
        LightKind::Spot { outer_rad, .. } => {
            let radius = half.length();
            let beside_rad = || (radius / to.length()).min(1.0).asin();
            to.length() <= radius || light.direction.angle_between(to) < outer_rad + beside_rad()
        }
    };
    let squared = to.length_squared() + half.length_squared() / 3.0;
    let lux = strongest / squared.max(1e-6);
    if is_lit && lux.is_finite() { lux } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn light(kind: LightKind, intensity: f32) -> PunctualLight {
        PunctualLight {
            kind,
            colour: [1.0, 0.5, 0.25],
            intensity,
            range_m: None,
            position: Vec3::Y * 10.0,
            direction: Vec3::NEG_Y,
            cookie: None,
        }
    }

    fn around(centre: Vec3) -> Aabb {
        Aabb::new(centre - 0.01, centre + 0.01)
    }

    fn receiver(centre: Vec3, albedo: f32) -> Receiver {
        Receiver::new(around(centre), albedo)
    }

    #[test]
    fn lights_of_plain_numbers_stay_and_those_of_the_physical_world_are_dimmed_to_one_brightness() {
        let boxes = [receiver(Vec3::ZERO, 0.5)];
        let sun = |lux| light(LightKind::Directional, lux);
        assert_eq!(factor(&[sun(3.0), sun(3.0)], &boxes), None);
        for lux in [7.0, 500.0, 100_000.0] {
            let factor = factor(&[sun(lux)], &boxes).expect("too bright");
            assert!((factor * lux * 0.5 / PI - DIMMED_RADIANCE).abs() < 1e-5, "{factor}");
        }
        assert_eq!(factor(&[sun(7.0)], &[receiver(Vec3::ZERO, 0.4)]), None, "a dark surface");
        assert_eq!(factor(&[sun(1e5)], &[]), None, "there is nothing to be too bright");
    }

    #[test]
    fn lamps_count_by_their_distance_their_range_and_their_cone() {
        let lamp = light(LightKind::Point, 800.0);
        let below = receiver(Vec3::ZERO, 1.0);
        assert!((illuminance_lx(&lamp, &below) - 8.0).abs() < 0.01);
        let near = PunctualLight { range_m: Some(5.0), ..lamp };
        assert_eq!(illuminance_lx(&near, &below), 0.0);
        let spot = light(LightKind::Spot { inner_rad: 0.1, outer_rad: 0.2 }, 800.0);
        assert!(illuminance_lx(&spot, &below) > 7.0);
        assert_eq!(illuminance_lx(&spot, &receiver(Vec3::X * 10.0, 1.0)), 0.0);
        let room = Receiver::new(Aabb::new(Vec3::splat(-20.0), Vec3::splat(20.0)), 1.0);
        assert!(
            illuminance_lx(&lamp, &room) < 2.0,
            "a room is larger than its lamp's surroundings"
        );
        let bright = PunctualLight { intensity: 8000.0, ..lamp };
        let below = || receiver(Vec3::ZERO, 1.0);
        assert!(factor(&[bright], &[below(), below(), below()]).is_some());
        // A single bright shop window does not darken the street.
        let mut street: Vec<_> = (0..99).map(|_| receiver(Vec3::X * 100.0, 1.0)).collect();
        street.push(below());
        assert_eq!(factor(&[bright], &street), None);
    }
}
