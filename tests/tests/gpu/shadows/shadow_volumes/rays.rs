//! Rays that find the pixels in shadow, and the pixels too near to an edge for a comparison.

use cull::CullView;
use glam::{DVec3, Vec2, Vec3, Vec4};

use super::world::World;

/// The surface that a pixel shows.
#[derive(Clone, Copy, PartialEq)]
enum Seen {
    /// Nothing.
    Sky,
    /// A triangle of an object, and true if the light is hidden from it.
    Surface { triangle: [usize; 2], is_shaded: bool },
    /// A surface that faces away from the light and is hidden only by itself.
    Away,
}

/// Returns the distance to a triangle in units of the direction, and the hit side: above 0 for the
/// front.
fn hit(from: DVec3, along: DVec3, corners: &[Vec3; 3]) -> Option<(f64, f64)> {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let u = b - a;
    let v = c - a;
    let across = along.cross(v);
    let volume = u.dot(across);
    if volume.abs() < 1e-15 {
        return None;
    }
    let offset = from - a;
    let x = offset.dot(across) / volume;
    let y = along.dot(offset.cross(u)) / volume;
    let distance = v.dot(offset.cross(u)) / volume;
    (x >= 0.0 && y >= 0.0 && x + y <= 1.0).then_some((distance, volume))
}

/// Returns the surface at the middle of a pixel.
fn look(world: &World, view: &CullView, light: Vec4, pixel: [u32; 2]) -> Seen {
    let ndc = |side: usize| (2.0 * pixel[side] as f32 + 1.0) / view.size[side] as f32 - 1.0;
    let place = Vec2::new(ndc(0), ndc(1));
    let near = view.rays.point(place, view.rays.near).as_dvec3();
    let along = view.rays.point(place, view.rays.near + 1.0).as_dvec3() - near;
    let mut nearest: Option<(f64, [usize; 2], [Vec3; 3])> = None;
    for (thing, object) in world.things.iter().enumerate() {
        for (place, triangle) in object.triangles.iter().enumerate() {
            if let Some((distance, side)) = hit(near, along, triangle)
                && distance > 0.0
                && side > 0.0
                && nearest.is_none_or(|(before, ..)| distance < before)
            {
                nearest = Some((distance, [thing, place], *triangle));
            }
        }
    }
    let Some((distance, triangle, [a, b, c])) = nearest else { return Seen::Sky };
    let point = near + along * distance;
    let to_light = World::to_light(light, point.as_vec3()).as_dvec3();
    let normal = (b - a).cross(c - a).as_dvec3().normalize();
    let facing = normal.dot(to_light.normalize());
    // Hits within a thousandth of a metre belong to the surface itself.
    let least = 1e-3 / to_light.length();
    let mut triangles = world.things.iter().flat_map(|object| &object.triangles);
    let is_shaded = triangles.any(|triangle| {
        hit(point, to_light, triangle).is_some_and(|(at, _)| at > least && at < 1.0)
    });
    if facing < 1e-3 && !is_shaded {
        return Seen::Away;
    }
    Seen::Surface { triangle, is_shaded }
}

/// Compares the masks of lights with rays at each pixel that is farther than one pixel from an edge
/// of a shadow or a triangle. Returns the numbers of lit and shaded pixels.
pub fn judge(world: &World, view: &CullView, lights: &[Vec4], mask: &[u32]) -> [u32; 2] {
    let [width, height] = view.size;
    let mut judged = [0; 2];
    for (bit, light) in lights.iter().enumerate() {
        let pixels =
            (0..width * height).map(|at| look(world, view, *light, [at % width, at / width]));
        let seen: Vec<Seen> = pixels.collect();
        let mut wrong = Vec::new();
        for y in 1..height - 1 {
            for x in 1..width - 1 {
                let at = |x: u32, y: u32| seen[(y * width + x) as usize];
                let here = at(x, y);
                let around = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y)));
                let is_even = around.into_iter().all(|(x, y)| at(x, y) == here);
                let Seen::Surface { is_shaded, triangle } = here else { continue };
                if !is_even {
                    continue;
                }
                judged[usize::from(is_shaded)] += 1;
                let found = mask[(y * width + x) as usize] >> bit & 1 == 1;
                if found != is_shaded {
                    wrong.push((x, y, triangle, is_shaded));
                }
            }
        }
        let eye = view.rays.origin;
        assert!(
            wrong.is_empty(),
            "{} pixels, light {light}, eye {eye}: {:?}",
            wrong.len(),
            &wrong[..wrong.len().min(12)]
        );
    }
    judged
}
