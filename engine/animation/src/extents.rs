//! The distances of nodes from their parents in any clip and any mix of clips, for a whole rig. One
//! pass over all keys computes them. The bound is coarse but cheap. It shows which objects can be
//! skipped whichever of the clips play. Poses from other sources are not bounded.

use std::borrow::Cow;
use std::collections::HashMap;

use cull::Aabb;
use glam::{Affine3A, DVec3, Vec3};

use crate::clip::{Clip, Values};
use crate::hull::hull;
use crate::rig::{Rest, Rig, RigNodeId};
use crate::skeleton::Skeleton;

/// The extent of a node. A mix lies between the poses that it mixes, so the ranges of all clips and
/// of the rest pose hold all mixes.
#[derive(Clone, Copy, Debug)]
struct Extent {
    /// The greatest distance of the node's origin from its parent's.
    farthest: f32,
    /// The greatest factor by which the node's transform lengthens a vector.
    lengthens: f32,
}

/// The extents of nodes in all poses that a set of clips can produce, alone or mixed.
#[derive(Clone, Debug)]
pub struct Extents {
    nodes: Vec<Extent>,
    /// The ranges of scales of the nodes that clips scale, usually a few.
    scales: HashMap<RigNodeId, [Vec3; 2]>,
}

/// The factor for rounding errors of single precision.
const ROUNDING: f32 = 1.001;

/// Returns an upper bound for the factor by which a matrix lengthens a vector, exact for rotated
/// and scaled axes: the square root of the largest row sum of its product with its transpose.
fn lengthens(matrix: &Affine3A) -> f32 {
    let axes = [matrix.matrix3.x_axis, matrix.matrix3.y_axis, matrix.matrix3.z_axis];
    // The entries may be large enough to overflow when squared.
    let axes = axes.map(|axis| Vec3::from(axis).as_dvec3());
    let row = |axis: DVec3| axes.iter().map(|other| axis.dot(*other).abs()).sum::<f64>();
    axes.iter().map(|axis| row(*axis)).fold(0.0, f64::max).sqrt() as f32
}

fn turns_inside_out(ends: &[Vec3; 2]) -> bool {
    let [least, largest] = ends;
    (least.cmplt(Vec3::ZERO) & largest.cmpgt(Vec3::ZERO)).any()
}

impl Extents {
    /// Creates the extents of a rig in these clips and at rest. The time is proportional to the
    /// number of nodes and keys.
    pub fn new<'a>(rig: &Rig, clips: impl IntoIterator<Item = &'a Clip>) -> Self {
        let at_rest = |rest: &Rest| match rest {
            Rest::Matrix(matrix) => {
                Extent { farthest: matrix.translation.length(), lengthens: lengthens(matrix) }
            }
            Rest::Parts(parts) => Extent {
                farthest: parts.translation.length(),
                lengthens: parts.scale.abs().max_element(),
            },
        };
        let nodes = rig.nodes().iter().map(|node| at_rest(&node.rest)).collect();
        let mut extents = Self { nodes, scales: HashMap::new() };
        for clip in clips {
            extents.add(rig, clip);
        }
        extents
    }

    /// Adds a clip of the same rig.
    pub fn add(&mut self, rig: &Rig, clip: &Clip) {
        for channel in &clip.channels {
            let Some(extent) = self.nodes.get_mut(channel.node.0 as usize) else { continue };
            match &channel.track.values {
                Values::Translation(values) => {
                    hull(&channel.track, values, 1, 0, &mut |at: Vec3| {
                        extent.farthest = extent.farthest.max(at.length());
                    });
                }
                Values::Scale(values) => {
                    let rest = rig.nodes().get(channel.node.0 as usize).map(|node| &node.rest);
                    let rest = match rest {
                        Some(Rest::Parts(parts)) => parts.scale,
                        _ => Vec3::ONE,
                    };
                    let range = self.scales.entry(channel.node).or_insert([rest; 2]);
                    hull(&channel.track, values, 1, 0, &mut |scale: Vec3| {
                        extent.lengthens = extent.lengthens.max(scale.abs().max_element());
                        let [least, largest] = range;
                        (*least, *largest) = (least.min(scale), largest.max(scale));
                    });
                }
                Values::Rotation(_) | Values::Weights(_) => {}
            }
        }
    }

    /// Returns true if the scale of a node may be mirrored at some times and not at others.
    pub fn may_turn_inside_out(&self, node: RigNodeId) -> bool {
        self.scales.get(&node).is_some_and(turns_inside_out)
    }

    /// Returns true if [`Self::may_turn_inside_out`] is true for any node.
    pub fn may_any_turn_inside_out(&self) -> bool {
        self.scales.values().any(turns_inside_out)
    }

    /// Returns the greatest distance of a point from the parent's origin, if the point is at most
    /// `distance` from the node's origin.
    fn lifted(&self, node: RigNodeId, distance: f32) -> f32 {
        let extent = self.nodes.get(node.0 as usize);
        let lifted =
            extent.map_or(distance, |extent| extent.farthest + extent.lengthens * distance);
        // A maximum would lose a NaN.
        if lifted.is_nan() { f32::INFINITY } else { lifted }
    }

    /// Returns the greatest distance of any point from the origin of the world, and the node to
    /// which the point belongs. For each node, `distances` holds the greatest distance of its own
    /// points from its origin, which may be infinite. It is negative for a node without points. The
    /// time is proportional to the size of the rig.
    pub fn farthest(&self, rig: &Rig, distances: &[f32]) -> Option<(RigNodeId, f32)> {
        // The farthest point at or below each node, in the node's space, and the node to which it
        // belongs.
        let mut hanging: Vec<Option<(f32, RigNodeId)>> = (0..rig.nodes().len() as u32)
            .map(|id| {
                let distance = distances.get(id as usize).filter(|distance| **distance >= 0.0)?;
                Some((*distance, RigNodeId(id)))
            })
            .collect();
        let mut farthest: Option<(f32, RigNodeId)> = None;
        for node in rig.order().iter().rev() {
            let Some((distance, whose)) = hanging.get(node.0 as usize).copied().flatten() else {
                continue;
            };
            let lifted = self.lifted(*node, distance);
            let parent = rig.nodes().get(node.0 as usize).and_then(|node| node.parent);
            let above = match parent.and_then(|parent| hanging.get_mut(parent.0 as usize)) {
                Some(above) => above,
                None => &mut farthest,
            };
            if above.is_none_or(|(other, _)| other < lifted) {
                *above = Some((lifted, whose));
            }
        }
        farthest.map(|(distance, whose)| (whose, distance * ROUNDING))
    }

    /// Returns a box that no vertex of a skeleton leaves while the clips play. Its size is the sum
    /// of the lengths of the bone chains. `boxes` holds for each joint, by its number in the skin,
    /// the box of the vertices that follow the joint, in the space of the mesh. The returned box is
    /// centred on the origin of the [skeleton's space](Skeleton::space). If vertices reach too far,
    /// it is infinite or larger than any scene. The time is proportional to the number of boxes and
    /// bones.
    pub fn reach(&self, skeleton: &Skeleton, boxes: impl IntoIterator<Item = (u16, Aabb)>) -> Aabb {
        let mut hanging = vec![f32::NEG_INFINITY; skeleton.bones.len()];
        let mut farthest = 0.0_f32;
        for (joint, bounds) in boxes {
            let joint = skeleton.joints.get(usize::from(joint)).copied().flatten();
            let Some(joint) = joint else { continue };
            let bind = joint.inverse_bind;
            let lengthens = lengthens(&bind);
            let offset = bind.translation.length();
            let entry = joint.bone.and_then(|bone| hanging.get_mut(bone));
            let entry = entry.unwrap_or(&mut farthest);
            for corner in bounds.corners() {
                // Terms may cancel, but their rounding errors do not.
                let terms = lengthens * corner.length() + offset;
                let distance = bind.transform_point3(corner).length() + terms * (ROUNDING - 1.0);
                // A maximum would lose a NaN.
                *entry = entry.max(if distance.is_nan() { f32::INFINITY } else { distance });
            }
        }
        for (index, bone) in skeleton.bones.iter().enumerate().rev() {
            let distance = hanging.get(index).copied().unwrap_or_default();
            if distance < 0.0 {
                continue;
            }
            let lifted = self.lifted(bone.node, distance);
            let above = bone.parent.and_then(|parent| hanging.get_mut(parent));
            let above = above.unwrap_or(&mut farthest);
            *above = above.max(lifted);
        }
        let farthest = Vec3::splat(farthest * ROUNDING);
        Aabb::new(-farthest, farthest)
    }
}

/// The least and the greatest weight of each morph target of nodes, in any clip, any mix of clips,
/// and at rest.
#[derive(Clone, Debug, Default)]
pub struct WeightRanges {
    /// The ranges of the nodes whose weights clips change.
    nodes: HashMap<RigNodeId, Vec<[f32; 2]>>,
}

impl WeightRanges {
    /// Finds the ranges of a rig in these clips. The time is proportional to the number of keys.
    pub fn new<'a>(rig: &Rig, clips: impl IntoIterator<Item = &'a Clip>) -> Self {
        let mut ranges = Self::default();
        for channel in clips.into_iter().flat_map(|clip| &clip.channels) {
            let Values::Weights(values) = &channel.track.values else { continue };
            let node = ranges.nodes.entry(channel.node);
            let list = node.or_insert_with(|| at_rest(rig, channel.node));
            let count = list.len();
            for (target, [least, largest]) in list.iter_mut().enumerate() {
                hull(&channel.track, values, count, target, &mut |weight: f32| {
                    (*least, *largest) = (least.min(weight), largest.max(weight));
                });
            }
        }
        ranges
    }

    /// Returns the ranges of the morph targets of a node.
    pub fn of(&self, rig: &Rig, node: RigNodeId) -> Cow<'_, [[f32; 2]]> {
        match self.nodes.get(&node) {
            Some(ranges) => ranges.into(),
            None => at_rest(rig, node).into(),
        }
    }
}

fn at_rest(rig: &Rig, node: RigNodeId) -> Vec<[f32; 2]> {
    let weights = rig.nodes().get(node.0 as usize).map(|node| node.weights.as_slice());
    weights.unwrap_or_default().iter().map(|weight| [*weight; 2]).collect()
}
