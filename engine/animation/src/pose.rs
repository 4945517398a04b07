//! Poses: the transforms of all nodes of a rig, relative to their parents, at one time.

use glam::{Affine3A, Vec4};

use crate::clip::{Channel, Clip, Values};
use crate::rig::{Rest, Rig, RigNodeId, Trs};
use crate::sample::unit;

/// The transforms of all nodes in parts, and the weights of their morph targets. A pose lists the
/// nodes that have moved, so that work is proportional to their number, not to the size of the rig.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    parts: Vec<Trs>,
    weights: Vec<f32>,
    /// The offset of each node's weights, then the end of the last node's weights.
    first_weight: Vec<usize>,
    moved: Vec<RigNodeId>,
    is_moved: Vec<bool>,
}

impl Pose {
    /// Creates the pose of the rig at rest.
    pub fn new(rig: &Rig) -> Self {
        let nodes = rig.nodes();
        let mut weights = Vec::new();
        let mut first_weight = vec![0];
        for node in nodes {
            weights.extend_from_slice(&node.weights);
            first_weight.push(weights.len());
        }
        let parts = nodes.iter().map(|node| match node.rest {
            Rest::Parts(parts) => parts,
            Rest::Matrix(_) => Trs::IDENTITY,
        });
        Self {
            parts: parts.collect(),
            weights,
            first_weight,
            moved: Vec::new(),
            is_moved: vec![false; nodes.len()],
        }
    }

    /// Resets the moved nodes to rest. `rig` must be the rig that the pose was created for.
    pub fn reset(&mut self, rig: &Rig) {
        let mut moved = std::mem::take(&mut self.moved);
        for id in moved.drain(..) {
            let Some(node) = rig.nodes().get(id.0 as usize) else { continue };
            if let (Rest::Parts(rest), Some(parts)) = (node.rest, self.parts.get_mut(id.0 as usize))
            {
                *parts = rest;
            }
            for (weight, rest) in self.weights_mut(id).iter_mut().zip(&node.weights) {
                *weight = *rest;
            }
            if let Some(is_moved) = self.is_moved.get_mut(id.0 as usize) {
                *is_moved = false;
            }
        }
        self.moved = moved;
    }

    /// Returns the nodes that have moved since the pose was at rest, in any order.
    pub fn moved(&self) -> &[RigNodeId] {
        &self.moved
    }

    /// Returns the transform of a node relative to its parent; `None` for a node that does not
    /// exist. A node with a matrix has the identity here.
    pub fn parts(&self, node: RigNodeId) -> Option<&Trs> {
        self.parts.get(node.0 as usize)
    }

    /// Returns the weights of a node's morph targets; empty if it has none.
    pub fn weights(&self, node: RigNodeId) -> &[f32] {
        self.weight_range(node).and_then(|range| self.weights.get(range)).unwrap_or_default()
    }

    /// Returns the transform from a node's space to its parent's.
    pub fn local(&self, rig: &Rig, node: RigNodeId) -> Affine3A {
        match rig.nodes().get(node.0 as usize).map(|node| node.rest) {
            Some(Rest::Matrix(matrix)) => matrix,
            _ => self.parts(node).copied().unwrap_or(Trs::IDENTITY).to_affine(),
        }
    }

    /// Sets the properties that a clip animates to their values at `time_s`, clamped to the clip's
    /// ends. Other properties are unchanged.
    pub fn sample(&mut self, clip: &Clip, time_s: f32) {
        for Channel { node, track } in &clip.channels {
            self.mark(*node);
            if let Values::Weights(values) = &track.values {
                track.weights_at(values, time_s, self.weights_mut(*node));
                continue;
            }
            let Some(parts) = self.parts.get_mut(node.0 as usize) else { continue };
            match &track.values {
                Values::Translation(values) => {
                    parts.translation =
                        track.vector_at(values, time_s).unwrap_or(parts.translation);
                }
                Values::Rotation(values) => {
                    parts.rotation = track.rotation_at(values, time_s).unwrap_or(parts.rotation);
                }
                Values::Scale(values) => {
                    parts.scale = track.vector_at(values, time_s).unwrap_or(parts.scale);
                }
                Values::Weights(_) => {}
            }
        }
    }

    /// Blends this pose with another pose of the same rig: 0 is this pose, 1 the other one.
    /// Rotations take the shorter arc, along its chord ("nlerp"). Unlike slerp, this keeps every
    /// mix of any number of poses in the cone that their rotations span. The bounds of blends rely
    /// on that.
    pub fn blend(&mut self, other: &Self, weight: f32) {
        let weight = if weight.is_finite() { weight.clamp(0.0, 1.0) } else { 0.0 };
        for node in &other.moved {
            self.mark(*node);
        }
        for index in 0..self.moved.len() {
            let Some(node) = self.moved.get(index).copied() else { return };
            if let (Some(parts), Some(to)) =
                (self.parts.get_mut(node.0 as usize), other.parts(node))
            {
                *parts = mix(parts, to, weight);
            }
            for (from, to) in self.weights_mut(node).iter_mut().zip(other.weights(node)) {
                *from = *from * (1.0 - weight) + to * weight;
            }
        }
    }

    /// Copies the properties that a clip animates from another pose of the same rig.
    pub(crate) fn take(&mut self, other: &Self, clip: &Clip) {
        for Channel { node, track } in &clip.channels {
            self.mark(*node);
            let from = other.parts(*node);
            if let Values::Weights(_) = &track.values {
                for (weight, from) in self.weights_mut(*node).iter_mut().zip(other.weights(*node)) {
                    *weight = *from;
                }
            } else if let (Some(parts), Some(from)) = (self.parts.get_mut(node.0 as usize), from) {
                match &track.values {
                    Values::Translation(_) => parts.translation = from.translation,
                    Values::Rotation(_) => parts.rotation = from.rotation,
                    Values::Scale(_) => parts.scale = from.scale,
                    Values::Weights(_) => {}
                }
            }
        }
    }

    fn mark(&mut self, node: RigNodeId) {
        if let Some(is_moved @ false) = self.is_moved.get_mut(node.0 as usize) {
            *is_moved = true;
            self.moved.push(node);
        }
    }

    fn weight_range(&self, node: RigNodeId) -> Option<std::ops::Range<usize>> {
        let index = node.0 as usize;
        Some(*self.first_weight.get(index)?..*self.first_weight.get(index.checked_add(1)?)?)
    }

    fn weights_mut(&mut self, node: RigNodeId) -> &mut [f32] {
        let range = self.weight_range(node);
        range.and_then(|range| self.weights.get_mut(range)).unwrap_or_default()
    }
}

fn mix(from: &Trs, to: &Trs, weight: f32) -> Trs {
    let away = if from.rotation.dot(to.rotation) < 0.0 { -1.0 } else { 1.0 };
    let turned =
        Vec4::from(from.rotation) * (1.0 - weight) + Vec4::from(to.rotation) * (weight * away);
    Trs {
        translation: from.translation * (1.0 - weight) + to.translation * weight,
        rotation: unit(turned, from.rotation),
        scale: from.scale * (1.0 - weight) + to.scale * weight,
    }
}
