//! Points and lines as solids, since triangles are all that is drawn: a point is an octahedron, a line a
//! prism with three sides, closed at both ends.
//!
//! Their sizes are relative to the primitive's own extent, the diagonal of the box around it: points reach
//! [`POINT_RADIUS`] of it in all directions, lines [`LINE_RADIUS`]. Where the extent is 0, it counts as 1.
//! All attributes, skins and morph targets go along; where the primitive has normals they are kept, so that
//! it is lit as the file says, else they point outwards.

use glam::{DVec3, Vec3};

use super::geometry::Geometry;
use super::numbers::direction;

/// Half of a point's size, as a part of the primitive's extent.
pub(super) const POINT_RADIUS: f32 = 1.0 / 400.0;

/// The distance of a line's edges from its middle, as a part of the primitive's extent.
pub(super) const LINE_RADIUS: f32 = 1.0 / 1000.0;

/// How many vertices a point gets.
pub(super) const POINT_VERTICES: u64 = 6;

/// How many triangles a point gets.
pub(super) const POINT_TRIANGLES: u64 = 8;

/// How many vertices a line gets.
pub(super) const LINE_VERTICES: u64 = 6;

/// How many triangles a line gets.
pub(super) const LINE_TRIANGLES: u64 = 8;

/// Vertices, each where another is and some way off it.
#[derive(Default)]
struct Growth {
    picks: Vec<u32>,
    outwards: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Growth {
    fn add(&mut self, corners: &[(u32, Vec3)], triangles: &[[u32; 3]]) {
        let start = self.picks.len() as u32;
        self.picks.extend(corners.iter().map(|(vertex, _)| *vertex));
        self.outwards.extend(corners.iter().map(|(_, outward)| *outward));
        self.triangles.extend(triangles.iter().map(|triangle| triangle.map(|at| start + at)));
    }

    fn finish(self, geometry: &Geometry, radius: f32) -> Geometry {
        let mut grown = geometry.gather(&self.picks);
        for (position, outward) in grown.positions.iter_mut().zip(&self.outwards) {
            *position += *outward * radius;
        }
        if grown.normals.is_empty() {
            grown.normals = self.outwards;
        }
        grown.triangles = self.triangles;
        grown
    }
}

fn extent(geometry: &Geometry) -> f32 {
    let low = geometry.positions.iter().fold(DVec3::INFINITY, |low, at| low.min(at.as_dvec3()));
    let high =
        geometry.positions.iter().fold(DVec3::NEG_INFINITY, |high, at| high.max(at.as_dvec3()));
    let extent = (high - low).length() as f32;
    if extent > 0.0 && extent.is_finite() { extent } else { 1.0 }
}

/// An octahedron around each of these vertices.
pub(super) fn points(geometry: &Geometry, points: &[u32]) -> Geometry {
    let directions = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let triangles =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let mut growth = Growth::default();
    for &point in points {
        growth.add(&directions.map(|outward| (point, outward)), &triangles);
    }
    growth.finish(geometry, extent(geometry) * POINT_RADIUS)
}

/// A prism around each of these lines.
pub(super) fn lines(geometry: &Geometry, lines: &[[u32; 2]]) -> Geometry {
    let triangles =
        [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5], [0, 2, 1], [3, 4, 5]];
    let mut growth = Growth::default();
    for &[from, to] in lines {
        let at = |vertex: u32| geometry.positions.get(vertex as usize).copied().unwrap_or_default();
        // A line without length gets some direction: others may go along with its ends, and move them.
        let along = direction(at(to) * 0.5 - at(from) * 0.5).unwrap_or(Vec3::Z);
        let across = along.any_orthonormal_vector();
        let third = along.cross(across);
        let half_root = 0.5 * 3.0_f32.sqrt();
        let around = [across, third * half_root - across * 0.5, third * -half_root - across * 0.5];
        let [a, b, c] = around;
        growth.add(&[(from, a), (from, b), (from, c), (to, a), (to, b), (to, c)], &triangles);
    }
    growth.finish(geometry, extent(geometry) * LINE_RADIUS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convert::numbers::triangle_normal;
    use glam::vec3;

    /// Every triangle faces away from the middle of its solid, and every edge is met from both sides.
    fn assert_closed(solid: &Geometry, vertices: usize) {
        let mut edges = std::collections::HashSet::new();
        for triangle in &solid.triangles {
            let start = triangle[0] as usize / vertices * vertices;
            let own = &solid.positions[start..start + vertices];
            let middle = own.iter().sum::<Vec3>() / vertices as f32;
            let corners = triangle.map(|vertex| solid.positions[vertex as usize]);
            let normal = triangle_normal(corners).expect("an area");
            assert!(normal.dot(corners[0] - middle) > 0.0, "{triangle:?} faces inwards");
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                assert!(edges.insert((triangle[from], triangle[to])), "an edge twice");
            }
        }
        assert!(edges.iter().all(|(from, to)| edges.contains(&(*to, *from))), "a hole");
    }

    fn three() -> Geometry {
        Geometry {
            positions: vec![Vec3::ZERO, vec3(100.0, 0.0, 0.0), vec3(0.0, 0.0, -3.0)],
            colours: vec![[0.25; 4], [0.5; 4], [0.75; 4]],
            ..Geometry::default()
        }
    }

    #[test]
    fn points_are_closed_octahedra_of_a_known_size() {
        let solid = points(&three(), &[2, 1]);
        assert_closed(&solid, POINT_VERTICES as usize);
        assert_eq!(solid.triangles.len() as u64, 2 * POINT_TRIANGLES);
        let radius = vec3(100.0, 0.0, 3.0).length() * POINT_RADIUS;
        assert!(solid.positions[0].distance(vec3(radius, 0.0, -3.0)) < 1e-5);
        assert_eq!(solid.normals[..6].iter().sum::<Vec3>(), Vec3::ZERO);
        assert_eq!((solid.colours[5], solid.colours[6]), ([0.75; 4], [0.5; 4]));
    }

    #[test]
    fn lines_are_closed_prisms_of_a_known_size() {
        let solid = lines(&three(), &[[0, 1], [1, 2], [0, 0]]);
        let proper = Geometry { triangles: solid.triangles[..16].to_vec(), ..solid.clone() };
        assert_closed(&proper, LINE_VERTICES as usize);
        assert_eq!(solid.triangles.len() as u64, 3 * LINE_TRIANGLES);
        let radius = vec3(100.0, 0.0, 3.0).length() * LINE_RADIUS;
        for (place, end) in [(0, Vec3::ZERO), (4, vec3(100.0, 0.0, 0.0))] {
            let off = solid.positions[place] - end;
            assert!((off.length() - radius).abs() < 1e-4 && off.x.abs() < 1e-4, "{off}");
        }
        assert_eq!((solid.colours[2], solid.colours[3]), ([0.25; 4], [0.5; 4]));
        assert!(
            solid.positions.iter().all(|position| position.is_finite()),
            "lines of length 0 too"
        );
    }

    #[test]
    fn one_point_alone_has_a_size_and_the_normals_of_a_file_are_kept() {
        let one = Geometry {
            positions: vec![Vec3::ONE],
            normals: vec![Vec3::NEG_Y],
            ..Geometry::default()
        };
        let solid = points(&one, &[0]);
        assert_eq!(solid.positions[0], vec3(1.0 + POINT_RADIUS, 1.0, 1.0));
        assert_eq!(solid.normals, [Vec3::NEG_Y; 6]);
    }
}
