//! Computes points of a surface. The shader `patch_points.comp` does the same in the same order.
//!
//! A point of an edge is computed from the edge's own four control points, in its canonical
//! direction, so both patches get the same bits. Each step is `a + (b - a) * t`, where `t` is a
//! multiple of 1/64 below 1. So the result stays between `a` and `b`, rounding included.

use glam::Vec3;

use super::grid::{EvaluatedPoint, SurfaceGrid, SurfacePoint};
use super::levels::TessellationLevels;
use super::surface::PatchSurface;
use crate::{Mesh, pack_normal};

/// The area below which tangents span no plane, relative to the square of the patch's size.
const LEAST_AREA: f32 = 1e-6;

/// The shares of the way to the middle of the patch at which a normal is computed, in this order:
/// at a pole itself the tangents span no plane.
const NUDGES: [f32; 3] = [0.0, 1.0 / 64.0, 0.25];

/// Returns a surface at its levels as a mesh in one colour; see [`Vertex::colour`].
///
/// [`Vertex::colour`]: crate::Vertex::colour
pub fn tessellated(
    surface: &PatchSurface,
    levels: &TessellationLevels,
    name: &str,
    colour: u32,
) -> Mesh {
    let grid = SurfaceGrid::new(surface, levels);
    let points = grid.points().iter().map(|point| evaluated(surface, point));
    grid.mesh(&points.collect::<Vec<_>>(), name, colour)
}

/// Returns a point of a surface; the origin if the surface does not have the patch.
pub fn evaluated(surface: &PatchSurface, point: &SurfacePoint) -> EvaluatedPoint {
    let Some(patch) = surface.patches().get(point.patch as usize) else {
        return EvaluatedPoint { position: [0.0; 3], normal: pack_normal(Vec3::Y) };
    };
    let places = patch.control_points.map(|point| surface.control_points()[point as usize]);
    let position = if point.side == 0 {
        let rows = rows_of(&places).map(|row| curve(row, point.u).place);
        curve(rows, point.v).place
    } else {
        let side = (point.side - 1) / 2;
        let along = if side.is_multiple_of(2) { point.u } else { point.v };
        let edge = surface.sides()[point.patch as usize][side as usize % 4];
        let edge = surface.places_of(surface.edges()[edge as usize]);
        if point.side.is_multiple_of(2) { on_edge(edge, 1.0 - along) } else { on_edge(edge, along) }
    };
    let normal = pack_normal(normal(&places, point.u, point.v));
    EvaluatedPoint { position: position.to_array(), normal }
}

/// A point of a cubic Bezier curve.
#[derive(Clone, Copy)]
struct CurvePoint {
    place: Vec3,
    /// A third of the derivative.
    tangent: Vec3,
}

/// Returns the point of a curve by de Casteljau's algorithm.
fn curve(points: [Vec3; 4], t: f32) -> CurvePoint {
    let between = |a: Vec3, b: Vec3| a + (b - a) * t;
    let [a, b, c, d] = points;
    let middle = between(b, c);
    let low = between(between(a, b), middle);
    let high = between(middle, between(c, d));
    CurvePoint { place: between(low, high), tangent: high - low }
}

/// Returns a point of an edge. The ends of an edge are its end control points, to the bit.
fn on_edge(points: [Vec3; 4], t: f32) -> Vec3 {
    if t >= 1.0 { points[3] } else { curve(points, t).place }
}

fn rows_of(places: &[Vec3; 16]) -> [[Vec3; 4]; 4] {
    [0, 4, 8, 12].map(|first| [0, 1, 2, 3].map(|column| places[first + column]))
}

/// Returns the unit normal of a patch.
fn normal(places: &[Vec3; 16], u: f32, v: f32) -> Vec3 {
    let origin = places[0];
    let relative = places.map(|place| place - origin);
    let reach = relative.iter().map(|place| place.abs().max_element()).fold(0.0, f32::max);
    if reach > 0.0 {
        let rows = rows_of(&relative.map(|place| place / reach));
        for nudge in NUDGES {
            let u = u + (0.5 - u) * nudge;
            let v = v + (0.5 - v) * nudge;
            let along_u = rows.map(|row| curve(row, u));
            let tangent_u = curve(along_u.map(|point| point.tangent), v).place;
            let tangent_v = curve(along_u.map(|point| point.place), v).tangent;
            let across = tangent_u.cross(tangent_v);
            if across.length() > LEAST_AREA {
                return across.normalize_or(Vec3::Y);
            }
        }
    }
    Vec3::Y
}
