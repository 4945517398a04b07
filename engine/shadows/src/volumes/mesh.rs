//! Meshes from which shadow volumes are extruded: triangles with adjacency, and their kind.

use std::collections::HashSet;

use cull::Aabb;
use glam::{Mat3A, Vec3, Vec4};

use super::adjacency::{Neighbours, neighbours};
use super::weld::weld;

/// The triangles of a mesh, as they are drawn.
#[derive(Clone, Copy, Debug)]
pub struct VolumeSource<'a> {
    /// The places of the vertices, in any unit.
    pub positions: &'a [Vec3],
    /// Three vertices per triangle, counter-clockwise seen from outside; surplus vertices are left
    /// out.
    pub triangles: &'a [u32],
    /// A number per vertex of a mesh that changes its shape. Two vertices at the same position with
    /// the same number always stay together, for example with equal joints, weights and morph
    /// targets. Empty for a rigid mesh.
    pub motions: &'a [u32],
}

/// The algorithm that a mesh needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VolumeKind {
    /// For closed two-manifolds that face outwards: only triangles that face the light are
    /// extruded. The result is right for points that no inside-out fold of the mesh encloses, if
    /// the light is outside.
    Plain,
    /// For any triangles: all are extruded, each as if it faced the light.
    Robust,
}

impl VolumeKind {
    /// Returns the algorithm for a mesh of this kind in a box, for a light in homogeneous
    /// coordinates. Closed meshes need the robust algorithm, too, if the light may be inside.
    #[must_use]
    pub fn towards(self, bounds: &Aabb, light: Vec4) -> Self {
        let bounds = bounds.enlarged(rounding(bounds, light.truncate()));
        if light.w > 0.0 && bounds.contains_point(light.truncate() / light.w) {
            Self::Robust
        } else {
            self
        }
    }
}

/// A mesh that shadow volumes are extruded from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VolumeMesh {
    enclosure: Enclosure,
    triangles: Vec<[u32; 6]>,
}

/// The side of its triangles on which the inside of a mesh lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Enclosure {
    /// At their backs: each part is closed.
    BehindBacks,
    /// At their fronts, as after a transform that mirrors.
    BehindFronts,
    /// On no side: the mesh is not closed, or not consistent.
    #[default]
    None,
}

impl Enclosure {
    /// Returns the algorithm for the mesh under a transform. A mesh must face inwards to face
    /// outwards after a transform that mirrors.
    #[must_use]
    pub fn kind_under(self, transform: &Mat3A) -> VolumeKind {
        let determinant = transform.determinant();
        match self {
            Self::BehindBacks if determinant > 0.0 => VolumeKind::Plain,
            Self::BehindFronts if determinant < 0.0 => VolumeKind::Plain,
            _ => VolumeKind::Robust,
        }
    }
}

/// The error of building a [`VolumeMesh`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum VolumeError {
    /// A triangle has an invalid vertex index.
    #[error("a triangle has vertex {vertex}, but there are {vertices}")]
    NoVertex {
        /// The vertex.
        vertex: u32,
        /// The number of vertices.
        vertices: usize,
    },
    /// The number of motions is neither 0 nor the number of vertices.
    #[error("there are {motions} motions for {vertices} vertices: it must be none or one for each")]
    Motions {
        /// The number of motions.
        motions: usize,
        /// The number of vertices.
        vertices: usize,
    },
}

impl VolumeMesh {
    /// Builds the adjacency of a mesh, and finds which algorithm it needs.
    ///
    /// Triangles with two equal corners cast no shadow and are left out. Of a triangle and its
    /// back, only the first is kept, since each casts the shadow of both.
    ///
    /// # Errors
    /// [`VolumeError`].
    pub fn new(source: &VolumeSource<'_>) -> Result<Self, VolumeError> {
        let VolumeSource { positions, triangles, motions } = *source;
        let vertices = positions.len();
        if ![0, vertices].contains(&motions.len()) {
            return Err(VolumeError::Motions { motions: motions.len(), vertices });
        }
        if let Some(&vertex) = triangles.iter().find(|vertex| **vertex as usize >= vertices) {
            return Err(VolumeError::NoVertex { vertex, vertices });
        }
        let welded = single_triangles(triangles, &weld(positions, motions));
        let neighbours = neighbours(&welded);
        let enclosure = if neighbours.is_manifold {
            enclosure(&welded, &neighbours, positions)
        } else {
            Enclosure::None
        };
        let with_neighbours = welded.iter().zip(&neighbours.of).map(|(&[a, b, c], beside)| {
            let opposite = |place: usize, none: u32| {
                let beside = beside.get(place).copied().flatten();
                beside
                    .and_then(|(triangle, edge)| opposite(&welded, triangle, edge))
                    .unwrap_or(none)
            };
            [a, opposite(0, a), b, opposite(1, b), c, opposite(2, c)]
        });
        Ok(Self { enclosure, triangles: with_neighbours.collect() })
    }

    /// Returns the algorithm that the mesh needs without a mirroring transform.
    #[must_use]
    pub fn kind(&self) -> VolumeKind {
        self.kind_under(&Mat3A::IDENTITY)
    }

    /// Returns the algorithm that the mesh needs under a transform.
    #[must_use]
    pub fn kind_under(&self, transform: &Mat3A) -> VolumeKind {
        self.enclosure.kind_under(transform)
    }

    /// Returns the side of the triangles on which the inside lies.
    #[must_use]
    pub fn enclosure(&self) -> Enclosure {
        self.enclosure
    }

    /// Returns the triangles with adjacency: a corner, the far corner of the neighbour at the edge
    /// from it to the next corner, the next corner, and so on. Without a neighbour, the preceding
    /// corner is repeated.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 6]] {
        &self.triangles
    }
}

/// Returns the corner of a triangle that is opposite an edge.
fn opposite(triangles: &[[u32; 3]], triangle: u32, edge: u8) -> Option<u32> {
    let corners = triangles.get(triangle as usize)?;
    corners.get((usize::from(edge) + 2) % 3).copied()
}

/// Returns the triangles of welded vertices, without triangles that have a vertex twice, without
/// backs, and without repetitions.
fn single_triangles(triangles: &[u32], welded: &[u32]) -> Vec<[u32; 3]> {
    let first = |vertex: u32| welded.get(vertex as usize).copied().unwrap_or(vertex);
    let (triangles, _) = triangles.as_chunks::<3>();
    let mut known = HashSet::with_capacity(triangles.len());
    let triangles = triangles.iter().map(|corners| corners.map(first));
    let is_single = |&corners: &[u32; 3]| {
        let [a, b, c] = corners;
        let mut sorted = corners;
        sorted.sort_unstable();
        a != b && b != c && c != a && known.insert(sorted)
    };
    triangles.filter(is_single).collect()
}

/// Returns the side on which all parts of a closed mesh enclose a volume.
fn enclosure(triangles: &[[u32; 3]], neighbours: &Neighbours, positions: &[Vec3]) -> Enclosure {
    let parts = neighbours.parts();
    let count = parts.iter().max().map_or(0, |last| *last as usize + 1);
    // Six times the volume, and the sum of the magnitudes of its terms.
    let mut volumes = vec![(0.0, 0.0); count];
    let Some(origin) = positions.first().map(|first| first.as_dvec3()) else {
        return Enclosure::None;
    };
    for (corners, part) in triangles.iter().zip(parts) {
        let place = |vertex: u32| positions.get(vertex as usize).copied().unwrap_or_default();
        let [a, b, c] = corners.map(|vertex| place(vertex).as_dvec3() - origin);
        let term = a.dot(b.cross(c));
        if let Some((volume, size)) = volumes.get_mut(part as usize) {
            *volume += term;
            *size += term.abs();
        }
    }
    // NaN compares as false, and a flat part may face either way.
    let are_all = |sign: f64| volumes.iter().all(|(volume, size)| sign * volume > 1e-9 * size);
    match (are_all(1.0), are_all(-1.0)) {
        (true, false) => Enclosure::BehindBacks,
        (false, true) => Enclosure::BehindFronts,
        _ => Enclosure::None,
    }
}

/// Returns the distance in metres by which a box is enlarged against the rounding of positions,
/// transforms and these tests.
pub(super) fn rounding(bounds: &Aabb, reach: Vec3) -> f32 {
    let largest = bounds.min.abs().max(bounds.max.abs()).max(reach.abs()).max_element();
    1e-5 * largest.max(1e-3)
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;

    /// Returns a box of 24 vertices: each face has its own corners, as for flat normals.
    fn cube() -> (Vec<Vec3>, Vec<u32>) {
        let mut positions = Vec::new();
        let mut indices = Vec::new();
        for axis in 0..3 {
            for side in [-1.0_f32, 1.0] {
                let first = positions.len() as u32;
                for [u, v] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
                    let mut at = [0.0; 3];
                    (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (side, u, v);
                    positions.push(Vec3::from_array(at));
                }
                let order = if side > 0.0 { [0, 1, 2, 0, 2, 3] } else { [0, 2, 1, 0, 3, 2] };
                indices.extend(order.map(|corner: u32| first + corner));
            }
        }
        (positions, indices)
    }

    fn build(positions: &[Vec3], triangles: &[u32]) -> VolumeMesh {
        VolumeMesh::new(&VolumeSource { positions, triangles, motions: &[] }).unwrap()
    }

    #[test]
    fn seams_are_closed_and_a_cube_is_plain() {
        let (positions, indices) = cube();
        let mesh = build(&positions, &indices);
        assert_eq!((mesh.kind(), mesh.triangles().len()), (VolumeKind::Plain, 12));
        for [a, ab, b, bc, c, ca] in mesh.triangles() {
            assert!(ab != a && bc != b && ca != c, "each edge has a neighbour");
        }
    }

    #[test]
    fn what_is_inside_out_open_or_flat_is_robust() {
        let (positions, indices) = cube();
        let turned: Vec<u32> = indices.chunks(3).flat_map(|at| [at[0], at[2], at[1]]).collect();
        let inwards = build(&positions, &turned);
        assert_eq!(inwards.kind(), VolumeKind::Robust);
        let mirror = Mat3A::from_diagonal(vec3(-1.0, 1.0, 1.0));
        assert_eq!(inwards.kind_under(&mirror), VolumeKind::Plain);
        assert_eq!(build(&positions, &indices).kind_under(&mirror), VolumeKind::Robust);
        assert_eq!(build(&positions, &indices[3..]).kind(), VolumeKind::Robust);
        let flat: Vec<Vec3> = positions.iter().map(|at| vec3(at.x, 0.0, at.z)).collect();
        assert_eq!(build(&flat, &indices).kind(), VolumeKind::Robust);
        let mut odd = positions.clone();
        odd[0].x = f32::NAN;
        assert_eq!(build(&odd, &indices).kind(), VolumeKind::Robust);
        let second = positions.iter().map(|at| *at + Vec3::X * 5.0);
        let two: Vec<Vec3> = positions.iter().copied().chain(second).collect();
        let of_two: Vec<u32> =
            indices.iter().copied().chain(turned.iter().map(|at| at + 24)).collect();
        assert_eq!(build(&two, &of_two).kind(), VolumeKind::Robust, "one part is inside out");
    }

    #[test]
    fn backs_and_points_are_left_out() {
        let (positions, mut indices) = cube();
        let backs: Vec<u32> = indices.chunks(3).flat_map(|at| [at[0], at[2], at[1]]).collect();
        indices.extend(backs);
        indices.extend([0, 0, 1, 5, 6, 5]);
        let mesh = build(&positions, &indices);
        assert_eq!((mesh.kind(), mesh.triangles().len()), (VolumeKind::Plain, 12));
    }

    #[test]
    fn parts_that_move_apart_are_open_between_them() {
        let (positions, indices) = cube();
        let motions: Vec<u32> = (0..24).map(|vertex| u32::from(vertex < 4)).collect();
        let source = VolumeSource { positions: &positions, triangles: &indices, motions: &motions };
        let mesh = VolumeMesh::new(&source).unwrap();
        assert_eq!(mesh.kind(), VolumeKind::Robust);
        let open = |at: &[u32; 6]| {
            [0, 2, 4].iter().filter(|corner| at[**corner] == at[**corner + 1]).count()
        };
        assert_eq!(mesh.triangles().iter().map(open).sum::<usize>(), 8);
    }

    #[test]
    fn bad_input_is_refused_by_a_sentence() {
        let positions = [Vec3::ZERO; 3];
        let make = |triangles: &[u32], motions: &[u32]| {
            let source = VolumeSource { positions: &positions, triangles, motions };
            VolumeMesh::new(&source).map_err(|error| error.to_string())
        };
        let said = make(&[0, 1, 3], &[]).unwrap_err();
        assert_eq!(said, "a triangle has vertex 3, but there are 3");
        let said = make(&[0, 1, 2], &[1]).unwrap_err();
        assert!(said.starts_with("there are 1 motions for 3 vertices"), "{said}");
        assert!(make(&[], &[]).unwrap().triangles().is_empty());
    }
}
