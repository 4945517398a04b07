//! Exposure: files give lights in lux and candela, but no exposure of a camera. Where lights of
//! physical strength would leave nothing but white, all of them are dimmed by one factor.
//!
//! The factor is a function of the scene at rest, so that every frame has the same. Lights are
//! dimmed and not the whole image: emission and ambient light need no camera.

use std::f32::consts::PI;

use cull::Aabb;
use scene::{LightKind, PunctualLight, Scene, Surfaces};

use crate::notes::Notes;

/// The illuminance up to which lights stay as they are, over most of the lit objects, in lux: four
/// times the illuminance under which a white surface is white.
const MOST_LX: f32 = 4.0 * PI;

/// The illuminance to which brighter lights are dimmed, in lux.
const DIMMED_LX: f32 = 1.5 * PI;

/// The most objects that are sampled.
const MOST_OBJECTS: usize = 512;

/// The most pairs of an object and a light that are sampled.
const MOST_PAIRS: usize = 1 << 22;

/// Sets the exposure of a scene: the `wanted` one, or 1, with the lights dimmed where needed.
pub(super) fn set(wanted: Option<f32>, scene: &Scene, surfaces: &mut Surfaces, notes: &mut Notes) {
    match wanted {
        Some(exposure) => surfaces.exposure = exposure,
        None => dim(scene, surfaces, notes),
    }
}

/// Dims the lights of a scene where most of the lit objects would be white, and notes it.
fn dim(scene: &Scene, surfaces: &mut Surfaces, notes: &mut Notes) {
    let objects = scene.objects.iter().chain(&surfaces.transparent);
    let count = scene.objects.len() + surfaces.transparent.len();
    let most = (MOST_PAIRS / surfaces.lights.len().max(1)).clamp(1, MOST_OBJECTS);
    let boxes: Vec<Aabb> = objects
        .step_by(count.div_ceil(most).max(1))
        .filter_map(|object| scene.bounds_of(object))
        .collect();
    let Some(factor) = factor(&surfaces.lights, &boxes) else { return };
    for light in &mut surfaces.lights {
        light.intensity *= factor;
    }
    notes.say(format!(
        "the lights are too bright for an exposure of 1: dimmed to {factor:.3e} of what the file says, \
         unless an exposure is given"
    ));
}

/// Returns the factor for lights that shine on boxes; `None` if they stay as they are.
fn factor(lights: &[PunctualLight], boxes: &[Aabb]) -> Option<f32> {
    let of_box = |bounds: &Aabb| lights.iter().map(|light| illuminance_lx(light, bounds)).sum();
    let mut lit: Vec<f32> = boxes.iter().map(of_box).filter(|lux: &f32| *lux > 0.0).collect();
    lit.sort_unstable_by(f32::total_cmp);
    let median_lx = *lit.get(lit.len() / 2)?;
    (median_lx > MOST_LX).then_some(DIMMED_LX / median_lx)
}

/// Returns the illuminance by one light at the mean distance of a box's inside, on a surface that
/// faces the light.
fn illuminance_lx(light: &PunctualLight, bounds: &Aabb) -> f32 {
    let strongest = light.colour.into_iter().fold(0.0, f32::max) * light.intensity;
    let to = bounds.centre() - light.position;
    let half = bounds.half_extent();
    let nearest = (light.position.clamp(bounds.min, bounds.max) - light.position).length();
    let is_reached = light.range_m.is_none_or(|range_m| nearest < range_m);
    let is_lit = match light.kind {
        LightKind::Directional => return strongest,
        LightKind::Point => is_reached,
        LightKind::Spot { outer_rad, .. } => {
            let radius = half.length();
            let beside_rad = (radius / to.length()).min(1.0).asin();
            is_reached
                && (to.length() <= radius
                    || light.direction.angle_between(to) < outer_rad + beside_rad)
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
            picture: None,
        }
    }

    fn around(centre: Vec3) -> Aabb {
        Aabb::new(centre - 0.01, centre + 0.01)
    }

    #[test]
    fn lights_of_plain_numbers_stay_and_those_of_the_physical_world_are_dimmed_to_one_brightness() {
        let boxes = [around(Vec3::ZERO)];
        let sun = |lux| light(LightKind::Directional, lux);
        assert_eq!(factor(&[sun(3.0), sun(3.0)], &boxes), None);
        for lux in [500.0, 100_000.0] {
            let factor = factor(&[sun(lux)], &boxes).expect("too bright");
            assert!((factor * lux / DIMMED_LX - 1.0).abs() < 1e-5, "{factor}");
        }
        assert_eq!(factor(&[sun(1e5)], &[]), None, "there is nothing to be too bright");
    }

    #[test]
    fn lamps_count_by_their_distance_their_range_and_their_cone() {
        let lamp = light(LightKind::Point, 800.0);
        let below = around(Vec3::ZERO);
        assert!((illuminance_lx(&lamp, &below) - 8.0).abs() < 0.01);
        let near = PunctualLight { range_m: Some(5.0), ..lamp };
        assert_eq!(illuminance_lx(&near, &below), 0.0);
        let spot = light(LightKind::Spot { inner_rad: 0.1, outer_rad: 0.2 }, 800.0);
        assert!(illuminance_lx(&spot, &below) > 7.0);
        assert_eq!(illuminance_lx(&spot, &around(Vec3::X * 10.0)), 0.0);
        let room = Aabb::new(Vec3::splat(-20.0), Vec3::splat(20.0));
        assert!(
            illuminance_lx(&lamp, &room) < 2.0,
            "a room is larger than its lamp's surroundings"
        );
        let bright = PunctualLight { intensity: 8000.0, ..lamp };
        assert!(factor(&[bright], &[below; 9]).is_some());
        // One shop window does not darken the street.
        let mut street = vec![around(Vec3::X * 100.0); 99];
        street.push(below);
        assert_eq!(factor(&[bright], &street), None);
    }
}
