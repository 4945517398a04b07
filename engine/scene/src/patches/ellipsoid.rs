//! An ellipsoid of eight patches that meet in two poles.

use glam::{Vec3, vec3};

use super::surface::{Patch, PatchError, PatchSurface};

/// The length of the tangents of a quarter circle, relative to its radius.
const KAPPA: f32 = 0.552_284_8;

/// The control points of a quarter circle, in units of its two axes.
const ARC: [[f32; 2]; 4] = [[1.0, 0.0], [1.0, KAPPA], [KAPPA, 1.0], [0.0, 1.0]];

/// Returns the ellipsoid around the origin with these half axes, in metres. Cubic curves
/// approximate it within a thousandth. Its poles lie on y; each is an edge of four equal control
/// points.
///
/// # Errors
/// [`PatchError::NotFinite`].
pub fn ellipsoid(half_axes: Vec3) -> Result<PatchSurface, PatchError> {
    let mut points = Vec::new();
    let mut patches = Vec::new();
    for quarter in 0..4 {
        for is_upper in [true, false] {
            let first = points.len() as u32;
            for row in 0..4 {
                // From the equator to the pole above, or from the pole below to the equator.
                let [out, up] = if is_upper { ARC[row] } else { ARC[3 - row] };
                let up = if is_upper { up } else { -up };
                points.extend(ARC.map(|[x, z]| turned(quarter, vec3(out * x, up, -out * z))));
            }
            let mut control_points = [0; 16];
            control_points.iter_mut().zip(first..).for_each(|(place, point)| *place = point);
            patches.push(Patch { control_points });
        }
    }
    points.iter_mut().for_each(|point| *point *= half_axes);
    PatchSurface::new(points, patches)
}

/// Returns a point after quarter turns about y. They are exact, so that equal points have equal
/// bits.
fn turned(quarters: u32, point: Vec3) -> Vec3 {
    let Vec3 { x, y, z } = point;
    match quarters {
        0 => point,
        1 => vec3(z, y, -x),
        2 => vec3(-x, y, -z),
        _ => vec3(-z, y, x),
    }
}
