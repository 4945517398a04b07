//! Normals for triangles that have none: smooth except at creases.

use glam::Vec3;

/// The angle between two faces from which on their edge is a crease, in radians: 30 degrees, as in
/// CAD programs.
pub const CREASE_RAD: f32 = std::f32::consts::FRAC_PI_6;

/// Triangles whose vertices have normals. A position has a vertex for each smooth surface that
/// meets there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CreasedTriangles {
    /// The position of each vertex, as an index into the given positions.
    pub origins: Vec<u32>,
    /// The unit normal of each vertex; zero where its triangles have no area.
    pub normals: Vec<Vec3>,
    /// The triangles, in the order in which they were given.
    pub triangles: Vec<[u32; 3]>,
}

/// A directed edge of a triangle, by its ends in ascending order.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    low: u32,
    high: u32,
    /// Three times the index of the triangle, plus the corner where the edge begins.
    corner: u32,
}

/// Computes the normals of triangles that share positions. Faces that meet at less than
/// `crease_rad` (radians) belong to one smooth surface. Its normals are the means of the normals of
/// its faces, weighted by the angles of their corners. An edge is a crease if it has one face, more
/// than two faces, or two faces with opposite windings. The time is proportional to `n log n` for
/// `n` triangles.
///
/// An index beyond the list of positions stands for the origin. Triangles after the first 2^30 are
/// left out.
pub fn creased(positions: &[Vec3], triangles: &[[u32; 3]], crease_rad: f32) -> CreasedTriangles {
    let triangles = triangles.get(..triangles.len().min(1 << 30)).unwrap_or_default();
    let at = |vertex: u32| positions.get(vertex as usize).copied().unwrap_or_default();
    let face_normal = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| at(vertex).as_dvec3());
        (b - a).cross(c - a).normalize_or_zero().as_vec3()
    };
    let faces: Vec<Vec3> = triangles.iter().map(face_normal).collect();
    let mut groups = CornerGroups::of(3 * triangles.len());
    let mut edges = edges(triangles);
    edges.sort_unstable();
    let least_cos = crease_rad.cos();
    for shared in edges.chunk_by(|a, b| a.low == b.low && a.high == b.high) {
        let [first, second] = shared else { continue };
        let normal = |edge: &Edge| faces.get(edge.corner as usize / 3).copied().unwrap_or_default();
        let begin = |edge: &Edge| corner_of(triangles, edge.corner);
        if begin(first) != begin(second) && normal(first).dot(normal(second)) >= least_cos {
            groups.join(first.corner, next_corner(second.corner));
            groups.join(next_corner(first.corner), second.corner);
        }
    }
    let mut made = CreasedTriangles::default();
    let mut vertex_of = vec![u32::MAX; 3 * triangles.len()];
    for (place, triangle) in (0_u32..).zip(triangles) {
        let face = faces.get(place as usize).copied().unwrap_or_default();
        let corners = triangle.map(at);
        made.triangles.push(std::array::from_fn(|corner| {
            let group = groups.root(3 * place + corner as u32);
            let fresh = made.origins.len() as u32;
            let Some(vertex) = vertex_of.get_mut(group as usize) else { return 0 };
            if *vertex == u32::MAX {
                *vertex = fresh;
                made.origins.push(triangle[corner]);
                made.normals.push(Vec3::ZERO);
            }
            let to = |end: usize| corners[(corner + end) % 3] - corners[corner];
            if let Some(normal) = made.normals.get_mut(*vertex as usize) {
                *normal += face * angle_between(to(1), to(2));
            }
            *vertex
        }));
    }
    for normal in &mut made.normals {
        *normal = normal.normalize_or_zero();
    }
    made
}

/// Returns the angle between two vectors of any length; a vector without length counts as
/// perpendicular.
fn angle_between(a: Vec3, b: Vec3) -> f32 {
    a.normalize_or_zero().dot(b.normalize_or_zero()).clamp(-1.0, 1.0).acos()
}

fn edges(triangles: &[[u32; 3]]) -> Vec<Edge> {
    let mut edges = Vec::with_capacity(3 * triangles.len());
    for (place, triangle) in (0_u32..).zip(triangles) {
        for (corner, begin) in (0_u32..).zip(*triangle) {
            let end = triangle[(corner as usize + 1) % 3];
            let corner = 3 * place + corner;
            edges.push(Edge { low: begin.min(end), high: begin.max(end), corner });
        }
    }
    edges
}

/// Returns the corner after this one in the same triangle.
fn next_corner(corner: u32) -> u32 {
    if corner % 3 == 2 { corner - 2 } else { corner + 1 }
}

fn corner_of(triangles: &[[u32; 3]], corner: u32) -> u32 {
    let triangle = triangles.get(corner as usize / 3).copied().unwrap_or_default();
    triangle[corner as usize % 3]
}

/// Corners of triangles in groups that share a normal: a union-find forest.
struct CornerGroups {
    parents: Vec<u32>,
}

impl CornerGroups {
    fn of(corners: usize) -> Self {
        Self { parents: (0..corners as u32).collect() }
    }

    fn root(&mut self, corner: u32) -> u32 {
        let mut corner = corner;
        while let Some(&parent) = self.parents.get(corner as usize) {
            if parent == corner {
                break;
            }
            let above = self.parents.get(parent as usize).copied().unwrap_or(parent);
            if let Some(link) = self.parents.get_mut(corner as usize) {
                *link = above;
            }
            corner = parent;
        }
        corner
    }

    fn join(&mut self, a: u32, b: u32) {
        let low = self.root(a).min(self.root(b));
        let high = self.root(a).max(self.root(b));
        if let Some(link) = self.parents.get_mut(high as usize) {
            *link = low;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;

    /// Returns two squares that meet at an edge along x, the second turned up by `turn_rad`.
    fn bent(turn_rad: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let (sin, cos) = turn_rad.sin_cos();
        let positions = vec![
            vec3(0.0, 0.0, 1.0),
            vec3(1.0, 0.0, 1.0),
            vec3(0.0, 0.0, 0.0),
            vec3(1.0, 0.0, 0.0),
            vec3(0.0, sin, -cos),
            vec3(1.0, sin, -cos),
        ];
        (positions, vec![[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4]])
    }

    #[test]
    fn faces_are_smooth_up_to_the_angle_of_a_crease() {
        let (positions, triangles) = bent(0.5);
        let smooth = creased(&positions, &triangles, CREASE_RAD);
        assert_eq!(smooth.origins.len(), 6, "all positions are shared");
        assert!((smooth.normals[0] - Vec3::Y).length() < 1e-6, "away from the bend");
        let on_edge = smooth.origins.iter().position(|origin| *origin == 3).unwrap();
        let tilt = smooth.normals[on_edge].angle_between(Vec3::Y);
        assert!(tilt > 0.1 && tilt < 0.4, "{tilt}");

        let (positions, triangles) = bent(0.6);
        let sharp = creased(&positions, &triangles, CREASE_RAD);
        assert_eq!(sharp.origins.len(), 8, "the edge has a vertex for each face");
        assert_eq!(sharp.triangles.len(), 4);
        assert!(sharp.normals.iter().all(|normal| normal.is_normalized()));
        let of_first = sharp.triangles[0].map(|vertex| sharp.normals[vertex as usize]);
        assert!(of_first.iter().all(|normal| normal.distance(Vec3::Y) < 1e-6));
    }

    #[test]
    fn windings_that_differ_and_edges_of_three_faces_are_creases() {
        let (positions, mut triangles) = bent(0.0);
        triangles[2] = [3, 2, 5];
        triangles.pop();
        assert_eq!(creased(&positions, &triangles, CREASE_RAD).origins.len(), 4 + 3);
        let (mut positions, mut triangles) = bent(0.0);
        positions.push(vec3(0.5, -1.0, 0.0));
        triangles.push([3, 2, 6]);
        let fin = creased(&positions, &triangles, CREASE_RAD);
        assert_eq!(fin.origins.len(), 4 + 4 + 3);
    }

    #[test]
    fn faces_without_area_and_wrong_indices_are_no_fault() {
        let made = creased(&[Vec3::ZERO, Vec3::X], &[[0, 1, 0], [7, 8, 9], [1, 1, 1]], CREASE_RAD);
        assert_eq!(made.triangles.len(), 3);
        assert!(made.normals.iter().all(|normal| normal.is_finite()));
        assert_eq!(creased(&[], &[], CREASE_RAD), CreasedTriangles::default());
    }
}
