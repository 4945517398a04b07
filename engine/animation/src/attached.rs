//! What hangs on each joint: all vertices that follow it, however little, as a set in its bone's space.
//!
//! A skinned vertex is a mean of where its joints alone would bring it, so it lies in the hull of what hangs
//! on them.

use glam::{Affine3A, Vec3, Vec3A};

use crate::form::{Binding, DeformedMesh};
use crate::morph::{Range, deltas};
use crate::skeleton::Joint;
use crate::support::{Directions, Support};

/// What hangs on a joint.
#[derive(Clone, Debug)]
pub(crate) struct Attached {
    /// Its bone; `None` hangs on the space itself.
    pub bone: Option<usize>,
    /// How far it reaches.
    pub support: Support,
    /// A sphere around it.
    pub centre: Vec3A,
    /// The sphere's radius.
    pub radius: f32,
}

/// The joints of a vertex that move it.
pub(crate) fn joints_of<'a>(
    binding: &Binding<'a>,
    vertex: usize,
) -> impl Iterator<Item = (u16, f32)> + use<'a> {
    let sets = binding.sets as usize;
    let rows = vertex.saturating_mul(sets)..vertex.saturating_mul(sets).saturating_add(sets);
    let joints = binding.joints.get(rows.clone()).unwrap_or_default();
    let weights = binding.weights.get(rows).unwrap_or_default();
    let pairs = joints.iter().flatten().copied().zip(weights.iter().flatten().copied());
    pairs.filter(|(_, weight)| *weight > 0.0)
}

/// What hangs on each joint of a skinned mesh while its targets' weights stay in their ranges.
pub(crate) fn attached(
    mesh: &DeformedMesh,
    binding: &Binding,
    directions: &Directions,
    ranges: &[Range],
) -> Vec<Attached> {
    let joints = &binding.skeleton.joints;
    let mut sets: Vec<Option<Attached>> = vec![None; joints.len()];
    let mut reach = Vec::new();
    for (vertex, position) in mesh.positions.iter().enumerate() {
        for (joint, _) in joints_of(binding, vertex) {
            let place = usize::from(joint);
            let Some(Some(Joint { bone, inverse_bind })) = joints.get(place) else { continue };
            let Some(set) = sets.get_mut(place) else { continue };
            let set = set.get_or_insert_with(|| Attached {
                bone: *bone,
                support: directions.nothing(),
                centre: Vec3A::ZERO,
                radius: 0.0,
            });
            let point = inverse_bind.transform_point3a(Vec3A::from(*position));
            let mut moving = deltas(mesh, ranges, vertex).peekable();
            if moving.peek().is_none() {
                set.support.add(directions, point);
                continue;
            }
            reach.clear();
            reach.extend(directions.all().iter().map(|direction| point.dot(*direction)));
            for (delta, range) in moving {
                let delta = inverse_bind.transform_vector3a(delta);
                for (reach, direction) in reach.iter_mut().zip(directions.all()) {
                    let along = delta.dot(*direction);
                    *reach += (along * range.least).max(along * range.largest);
                }
            }
            for (all, reach) in set.support.0.iter_mut().zip(&reach) {
                *all = all.max(*reach);
            }
        }
    }
    enclose(mesh, binding, directions, ranges, &mut sets);
    sets.into_iter().flatten().collect()
}

/// Puts a sphere around each set.
fn enclose(
    mesh: &DeformedMesh,
    binding: &Binding,
    directions: &Directions,
    ranges: &[Range],
    sets: &mut [Option<Attached>],
) {
    for set in sets.iter_mut().flatten() {
        let along = |axis: Vec3| directions.along(&set.support, axis);
        let middle = |axis: Vec3| 0.5 * (along(axis) - along(-axis));
        set.centre = Vec3A::new(middle(Vec3::X), middle(Vec3::Y), middle(Vec3::Z));
    }
    for (vertex, position) in mesh.positions.iter().enumerate() {
        for (joint, _) in joints_of(binding, vertex) {
            let place = usize::from(joint);
            let Some(Some(Joint { inverse_bind, .. })) = binding.skeleton.joints.get(place) else {
                continue;
            };
            let Some(Some(set)) = sets.get_mut(place) else { continue };
            let mut distance =
                inverse_bind.transform_point3a(Vec3A::from(*position)).distance(set.centre);
            for (delta, range) in deltas(mesh, ranges, vertex) {
                let weight = range.least.abs().max(range.largest.abs());
                distance += inverse_bind.transform_vector3a(delta).length() * weight;
            }
            // What is no number would be lost in the maximum: it may be anywhere.
            let distance = if distance.is_finite() { distance } else { f32::INFINITY };
            set.radius = set.radius.max(distance);
        }
    }
}

/// Along the three axes how far a set reaches when it is where `transform` brings it: least and largest.
pub(crate) fn box_of(
    support: &Support,
    directions: &Directions,
    transform: &Affine3A,
) -> [Vec3; 2] {
    let rows = transform.matrix3.transpose();
    let rows = [rows.x_axis, rows.y_axis, rows.z_axis].map(Vec3::from);
    let largest = Vec3::from(rows.map(|row| directions.along(support, row)));
    let least = Vec3::from(rows.map(|row| -directions.along(support, -row)));
    let origin = Vec3::from(transform.translation);
    [least + origin, largest + origin]
}
