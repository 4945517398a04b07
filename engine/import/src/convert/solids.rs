//! Points and lines as solids. They are used where [sprites](super::sprites) are impossible: with
//! blending, masks, textures, or skins. A point becomes a cube, a line a prism with three sides,
//! closed at both ends.
//!
//! They are a few pixels wide in the initial view
//! ([`InitialView`](super::initial_view::InitialView)), and keep that size in the world: points are
//! [`POINT_SIZE`] of the image's height, lines [`LINE_SIZE`] (6 and 4 pixels of 720). Close to each
//! other they are thinner, down to [`LEAST_SIZE`], so that their pattern stays visible. Most points
//! do not reach the middle between them and their neighbours, and parallel lines fill at most half
//! of their box. All attributes, skins and morph targets are kept. The normals of the primitive are
//! kept, too, for the lighting of the file; without normals, the solids' normals point outwards.

use glam::Vec3;

use super::geometry::Geometry;
use super::numbers::direction;

/// The size of a point, as a part of the image's height.
pub(super) const POINT_SIZE: f32 = 1.0 / 120.0;

/// The thickness of a line, as a part of the image's height.
pub(super) const LINE_SIZE: f32 = 1.0 / 180.0;

/// The least size of points and lines, as a part of the image's height.
pub(super) const LEAST_SIZE: f32 = 1.0 / 720.0;

/// The number of points for which the distance to their nearest neighbour is measured.
const ASKED_POINTS: usize = 32;

/// The number of vertices per point.
pub(super) const POINT_VERTICES: u64 = 8;

/// The number of triangles per point.
pub(super) const POINT_TRIANGLES: u64 = 12;

/// The number of vertices per line.
pub(super) const LINE_VERTICES: u64 = 6;

/// The number of triangles per line.
pub(super) const LINE_TRIANGLES: u64 = 8;

/// New vertices, each at an offset from an existing one.
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

/// Returns the wanted size, limited by the spacing and by the least visible size.
fn size_of(wanted: f32, most: f32, height: f32) -> f32 {
    let least = height * LEAST_SIZE;
    if most.is_finite() { wanted.min(most.max(least)) } else { wanted }
}

/// Returns the distance of points from their nearest neighbours: the median of some points,
/// infinite for a single point.
fn spacing(geometry: &Geometry, points: &[u32]) -> f32 {
    let at = |vertex: u32| geometry.positions.get(vertex as usize).copied().unwrap_or_default();
    let step = points.len().div_ceil(ASKED_POINTS).max(1);
    let nearest = |asked: Vec3| {
        let others = points.iter().map(|&other| at(other).distance_squared(asked));
        // Points at the same place count as one.
        others.filter(|squared| *squared > 0.0).fold(f32::INFINITY, f32::min).sqrt()
    };
    let asked = points.iter().step_by(step);
    let mut distances: Vec<f32> = asked.map(|&point| nearest(at(point))).collect();
    distances.sort_unstable_by(f32::total_cmp);
    distances.get(distances.len() / 2).copied().unwrap_or(f32::INFINITY)
}

/// Returns the width of points in an image of this height.
pub(super) fn point_size(geometry: &Geometry, points: &[u32], height: f32) -> f32 {
    size_of(height * POINT_SIZE, spacing(geometry, points), height)
}

/// Returns the width of lines in an image of this height.
pub(super) fn line_size(geometry: &Geometry, lines: &[[u32; 2]], height: f32) -> f32 {
    let at = |vertex: u32| geometry.positions.get(vertex as usize).copied().unwrap_or_default();
    let lengths = lines.iter().map(|&[from, to]| f64::from(at(from).distance(at(to))));
    let length: f64 = lengths.sum();
    let bounds = geometry.bounds();
    let across = f64::from((bounds.max - bounds.min).length());
    size_of(height * LINE_SIZE, (across * across * 0.5 / length) as f32, height)
}

/// Returns a cube around each of these vertices, for an image of this height.
pub(super) fn points(geometry: &Geometry, points: &[u32], height: f32) -> Geometry {
    // The corners, with the sign of x, y and z in three bits.
    let directions: [Vec3; 8] = std::array::from_fn(|corner| {
        let side = |axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
        Vec3::new(side(0), side(1), side(2)).normalize()
    });
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles: Vec<[u32; 3]> =
        faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mut growth = Growth::default();
    for &point in points {
        growth.add(&directions.map(|outward| (point, outward)), &triangles);
    }
    let size = point_size(geometry, points, height);
    growth.finish(geometry, size * 0.5 * 3.0_f32.sqrt())
}

/// Returns a prism around each of these lines, for an image of this height.
pub(super) fn lines(geometry: &Geometry, lines: &[[u32; 2]], height: f32) -> Geometry {
    let triangles =
        [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5], [0, 2, 1], [3, 4, 5]];
    let mut growth = Growth::default();
    let at = |vertex: u32| geometry.positions.get(vertex as usize).copied().unwrap_or_default();
    for &[from, to] in lines {
        // A line without length gets an arbitrary direction, since targets and joints may move its
        // ends apart.
        let along = direction(at(to) * 0.5 - at(from) * 0.5).unwrap_or(Vec3::Z);
        let across = along.any_orthonormal_vector();
        let third = along.cross(across);
        let half_root = 0.5 * 3.0_f32.sqrt();
        let around = [across, third * half_root - across * 0.5, third * -half_root - across * 0.5];
        let [a, b, c] = around;
        growth.add(&[(from, a), (from, b), (from, c), (to, a), (to, b), (to, c)], &triangles);
    }
    let size = line_size(geometry, lines, height);
    // The width of a prism is somewhat more than 1.5 times its radius from any side.
    growth.finish(geometry, size / 1.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convert::numbers::triangle_normal;
    use glam::vec3;

    /// Checks that every triangle faces away from the middle of its solid, and that every edge has
    /// a triangle on each side.
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
    fn points_are_closed_cubes_of_a_known_size() {
        let solid = points(&three(), &[2, 1], 120.0);
        assert_closed(&solid, POINT_VERTICES as usize);
        assert_eq!(solid.triangles.len() as u64, 2 * POINT_TRIANGLES);
        assert!(solid.positions[0].distance(vec3(-0.5, -0.5, -3.5)) < 1e-5);
        assert!(solid.normals[..8].iter().sum::<Vec3>().length() < 1e-6);
        assert_eq!((solid.colours[7], solid.colours[8]), ([0.75; 4], [0.5; 4]));
    }

    #[test]
    fn lines_are_closed_prisms_of_a_known_size() {
        let solid = lines(&three(), &[[0, 1], [1, 2], [0, 0]], 180.0);
        let proper = Geometry { triangles: solid.triangles[..16].to_vec(), ..solid.clone() };
        assert_closed(&proper, LINE_VERTICES as usize);
        assert_eq!(solid.triangles.len() as u64, 3 * LINE_TRIANGLES);
        for (place, end) in [(0, Vec3::ZERO), (4, vec3(100.0, 0.0, 0.0))] {
            let off = solid.positions[place] - end;
            assert!((off.length() - 1.0 / 1.5).abs() < 1e-4 && off.x.abs() < 1e-4, "{off}");
        }
        assert_eq!((solid.colours[2], solid.colours[3]), ([0.25; 4], [0.5; 4]));
        assert!(
            solid.positions.iter().all(|position| position.is_finite()),
            "lines of length 0 too"
        );
    }

    /// Returns points on a grid of 100 x 100 metres, a metre apart, and lines along its rows.
    fn grid() -> (Geometry, Vec<[u32; 2]>) {
        let at = |number: u32| vec3((number % 101) as f32, (number / 101) as f32, 0.0);
        let rows = (0..101).map(|row| [row * 101, row * 101 + 100]).collect();
        (Geometry { positions: (0..101 * 101).map(at).collect(), ..Geometry::default() }, rows)
    }

    fn reach(solid: &Geometry) -> f32 {
        solid.positions.iter().fold(0.0, |most, at| at.z.max(most))
    }

    #[test]
    fn what_is_crowded_is_thin_but_not_too_thin_to_be_seen() {
        let (geometry, rows) = grid();
        let all: Vec<u32> = (0..geometry.positions.len() as u32).collect();
        for (height, radius) in [(60.0, 0.25), (240.0, 0.5), (7200.0, 5.0)] {
            let found = reach(&points(&geometry, &all, height));
            assert!((found - radius).abs() < 1e-3, "{height}: {found}");
        }
        for (height, most) in [(90.0, 0.5), (900.0, 1.25), (7200.0, 10.0)] {
            let found = reach(&lines(&geometry, &rows, height)) * 1.5;
            assert!(found <= most * 1.01 && found > most * 0.4, "{height}: {found}");
        }
    }

    #[test]
    fn one_point_alone_has_a_size_and_the_normals_of_a_file_are_kept() {
        let one = Geometry {
            positions: vec![Vec3::ONE],
            normals: vec![Vec3::NEG_Y],
            ..Geometry::default()
        };
        let solid = points(&one, &[0], 120.0);
        assert!(solid.positions[7].distance(Vec3::splat(1.5)) < 1e-6);
        assert_eq!(solid.normals, [Vec3::NEG_Y; 8]);
    }
}
