//! Boxes around skinned meshes, computed from their pose alone.
//!
//! A skinned vertex is a mix of the points to which its joints move it. The weights are not
//! negative and their sum is 1, so the vertex lies in the hull of these points. The union of boxes
//! around these points therefore holds all vertices in any pose: of one clip, of mixed clips, of
//! inverse kinematics, of physics. A joint moves all vertices that follow it by one matrix, so one
//! box per joint is enough. These boxes are computed when the mesh is loaded. A pose then costs a
//! few operations per joint and per morph target, and none per vertex.
//!
//! Morph targets displace a vertex by the weighted sum of their displacements, before joints move
//! it. Each term lies in the box of all displacements of its target, times its weight. So the sum
//! lies in the sum of these boxes, for weights of either sign. This bound is too large for targets
//! that move different vertices, since it adds up displacements that no vertex has in common. So
//! the sum is also bounded by the largest weight times the largest sum of displacements of any
//! vertex, and the box is the intersection of both bounds.
//!
//! # Rounding
//! A GPU computes vertices in single precision, in any order and with or without fused
//! multiplication; this module does, too. Each operation adds at most `u = 2^-24` of its result.
//! Let `S` be the sum of the magnitudes of all terms of a coordinate: `sum over axes of |matrix| *
//! P + |translation|`. `P` is the largest magnitude of a position at rest plus the displacements
//! that targets add to it. No partial sum is larger than `S`. A term goes through `t + 1`
//! operations for `t` targets, `n + 1` for `n` influences, and 5 for the product with the mixed
//! matrix. So the error of a vertex is less than `(t + n + 7) * u * S`, and the error of this box
//! is less than `(t + 7) * u * S`. The margin uses `2 * u` instead of `u`, which covers the terms
//! of higher order and the rounding of the margin. Weights whose sum differs from 1 by at most `e`
//! scale a mix by at most `1 + e`, and move it by at most `e * S`. (Numbers below the least normal
//! one may be flushed to zero: some 1e-38 m, which the margin of proxies exceeds.)

use cull::Aabb;
use glam::{Affine3A, Vec3, Vec3A};

use crate::mesh::{Mesh, bounds_of_transformed};
use crate::surface::{MorphTarget, SkinWeights, SkinnedMesh};

/// A box of no size at the origin.
const NOTHING: Aabb = Aabb::new(Vec3::ZERO, Vec3::ZERO);

/// Twice the largest relative error of one operation in single precision.
const ROUNDING: f32 = f32::EPSILON;

/// The box of a mesh in any pose.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseBounds {
    parts: Vec<Part>,
    /// For each morph target the box of its displacements.
    displacements: Vec<Aabb>,
    /// The largest sums of displacements of any one vertex, along each axis and against it.
    most_added: [Vec3; 2],
    /// The number of operations that round, here and on the GPU.
    roundings: f32,
    /// The largest difference of a vertex's sum of weights from 1.
    weight_error: f32,
}

/// The vertices that one joint moves.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    /// The joint; `None` for a mesh without a skin, which stays in place.
    joint: Option<u16>,
    /// The box of the vertices that follow it, at rest, in the space of the mesh.
    bounds: Aabb,
}

impl PoseBounds {
    /// Returns the boxes of a mesh with its skin and morph targets.
    pub fn of(mesh: &Mesh, skinned_mesh: &SkinnedMesh) -> Self {
        let positions = mesh.vertices.iter().map(|vertex| Vec3::from(vertex.position));
        Self::new(positions, skinned_mesh.skin.as_ref(), &skinned_mesh.targets)
    }

    /// Computes the boxes from all vertices of a mesh at rest, its morph targets and its skin.
    pub fn new(
        positions: impl Iterator<Item = Vec3>,
        skin: Option<&SkinWeights>,
        targets: &[MorphTarget],
    ) -> Self {
        let (parts, weight_error) = match skin {
            Some(skin) => followed(positions, skin),
            None => (vec![Part { joint: None, bounds: around(positions) }], 0.0),
        };
        let displaced =
            |target: &MorphTarget| around(target.positions.iter().copied().map(Vec3::from));
        let influences = skin.map_or(0, |skin| 4 * skin.sets as usize);
        let roundings = (2 * targets.len() + influences + 14) as f32;
        let displacements = targets.iter().map(displaced).collect();
        let most_added = most_added(targets);
        Self { parts, displacements, most_added, roundings, weight_error }
    }

    /// Returns the box of the mesh in a pose, in the space to which `joints` transform it. No
    /// vertex lies outside, including the rounding of any GPU. `None` if the box reaches beyond the
    /// coordinates that can be drawn, or if a joint is missing.
    pub fn bounds(&self, joints: &[Affine3A], weights: &[f32]) -> Option<Aabb> {
        let (added, added_size) = self.added(weights.iter().map(|weight| [*weight; 2]));
        let mut all = if self.parts.is_empty() { NOTHING } else { Aabb::EMPTY };
        let mut size = Vec3A::ZERO;
        for Part { joint, bounds } in &self.parts {
            let matrix = match joint {
                Some(joint) => joints.get(usize::from(*joint))?,
                None => &Affine3A::IDENTITY,
            };
            let moved = bounds_of_transformed(&sum(bounds, &added), matrix);
            // The union would lose a NaN.
            if !moved.is_finite() {
                return None;
            }
            all = all.union(&moved);
            let largest = bounds.min.abs().max(bounds.max.abs()) + added_size;
            let terms = matrix.matrix3.x_axis.abs() * largest.x
                + matrix.matrix3.y_axis.abs() * largest.y
                + matrix.matrix3.z_axis.abs() * largest.z
                + matrix.translation.abs();
            size = size.max(terms);
        }
        let margin = Vec3::from(size * (self.roundings * ROUNDING + self.weight_error));
        let bounds = Aabb::new(all.min - margin, all.max + margin);
        bounds.is_usable().then_some(bounds)
    }

    /// Returns each joint that vertices follow, with the box of these vertices before the joint
    /// moves them, in the space of the mesh, for all weights of morph targets within the given
    /// ranges. A mesh without a skin has one box without a joint.
    pub fn parts(&self, weights: &[[f32; 2]]) -> impl Iterator<Item = (Option<u16>, Aabb)> {
        let (added, _) = self.added(weights.iter().copied());
        self.parts.iter().map(move |part| (part.joint, sum(&part.bounds, &added)))
    }

    /// Returns the box of the summed displacements of all targets, and the sum of their magnitudes.
    fn added(&self, weights: impl Iterator<Item = [f32; 2]>) -> (Aabb, Vec3) {
        let mut all = NOTHING;
        let mut size = Vec3::ZERO;
        // The largest positive and the largest negative weight.
        let mut plus = 0.0_f32;
        let mut minus = 0.0_f32;
        for (displacements, weights) in self.displacements.iter().zip(weights) {
            let [[a, b], [c, d]] =
                weights.map(|weight| [displacements.min * weight, displacements.max * weight]);
            let one = Aabb::new(a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
            all = sum(&all, &one);
            size += one.min.abs().max(one.max.abs());
            let [least, largest] = weights;
            (plus, minus) = (plus.max(largest), minus.max(-least));
        }
        let [along, against] = self.most_added;
        all.max = all.max.min(along * plus + against * minus);
        all.min = all.min.max(-(against * plus + along * minus));
        (all, size)
    }
}

/// Returns the largest sums of displacements of one vertex, along each axis and against it.
fn most_added(targets: &[MorphTarget]) -> [Vec3; 2] {
    let vertices = targets.iter().map(|target| target.positions.len()).max().unwrap_or_default();
    let mut most = [Vec3::ZERO; 2];
    for vertex in 0..vertices {
        let added = targets.iter().filter_map(|target| target.positions.get(vertex));
        let (along, against) = added.copied().map(Vec3::from).fold(
            (Vec3::ZERO, Vec3::ZERO),
            |(along, against), reach| {
                (along + reach.max(Vec3::ZERO), against - reach.min(Vec3::ZERO))
            },
        );
        most = [most[0].max(along), most[1].max(against)];
    }
    most
}

/// Returns the box of all sums of a point of `a` and a point of `b`.
fn sum(a: &Aabb, b: &Aabb) -> Aabb {
    Aabb::new(a.min + b.min, a.max + b.max)
}

/// Returns the box around points; without points, a box of no size at the origin.
fn around(points: impl Iterator<Item = Vec3>) -> Aabb {
    let all = points.fold(Aabb::EMPTY, |all, point| all.union(&Aabb::new(point, point)));
    if all.is_empty() { NOTHING } else { all }
}

/// Returns for each joint the box of the vertices that follow it, and the largest difference of a
/// sum of weights from 1.
fn followed(positions: impl Iterator<Item = Vec3>, skin: &SkinWeights) -> (Vec<Part>, f32) {
    let mut boxes = vec![Aabb::EMPTY; skin.joint_count as usize];
    let mut weight_error = 0.0_f64;
    let sets = (skin.sets as usize).max(1);
    let followed = skin.joints.chunks(sets).zip(skin.weights.chunks(sets));
    for (at, (joints, weights)) in positions.zip(followed) {
        let mut together = 0.0;
        for (joint, weight) in joints.as_flattened().iter().zip(weights.as_flattened()) {
            together += f64::from(*weight);
            // The GPU skips joints of weight 0, too.
            if let Some(bounds) = boxes.get_mut(usize::from(*joint)).filter(|_| *weight != 0.0) {
                *bounds = bounds.union(&Aabb::new(at, at));
            }
        }
        weight_error = weight_error.max((together - 1.0).abs());
    }
    let parts = (0..=u16::MAX).zip(boxes).filter(|(_, bounds)| !bounds.is_empty());
    let parts = parts.map(|(joint, bounds)| Part { joint: Some(joint), bounds });
    (parts.collect(), weight_error as f32)
}
