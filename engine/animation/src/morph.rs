//! Morph targets: how far their weights go, and where that brings vertices.

use cull::Aabb;
use glam::{Vec3, Vec3A};

use crate::clip::{Excerpt, Values};
use crate::form::DeformedMesh;
use crate::hull::{Span, hull};
use crate::rig::Rig;

/// The least and the largest weight of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    pub least: f32,
    pub largest: f32,
}

impl Range {
    const NONE: Self = Self { least: f32::INFINITY, largest: f32::NEG_INFINITY };

    fn include(&mut self, weight: f32) {
        self.least = self.least.min(weight);
        self.largest = self.largest.max(weight);
    }
}

/// The weights of all targets of a mesh within a span, whichever of the clips play, mixed or not. Where a
/// clip leaves them alone they are at rest.
pub(crate) fn ranges(
    rig: &Rig,
    mesh: &DeformedMesh,
    clips: &[Excerpt<'_>],
    span: Span,
) -> Vec<Range> {
    let mut ranges = vec![Range::NONE; mesh.targets.len()];
    if ranges.is_empty() {
        return ranges;
    }
    let rest = rig.nodes().get(mesh.node.0 as usize).map(|node| node.weights.as_slice());
    let rest = rest.unwrap_or_default();
    let mut is_at_rest = clips.is_empty();
    for clip in clips {
        let mut is_moved = false;
        for channel in clip.channels.iter().filter(|channel| channel.node == mesh.node) {
            let Values::Weights(values) = &channel.track.values else { continue };
            is_moved = true;
            for (target, range) in ranges.iter_mut().enumerate().take(rest.len()) {
                let mut include = |weight| range.include(weight);
                hull(&channel.track, values, (rest.len(), target), span, &mut include);
            }
        }
        is_at_rest |= !is_moved;
    }
    for (target, range) in ranges.iter_mut().enumerate() {
        // A target beyond those of the node has no weight that anything could change.
        if is_at_rest || target >= rest.len() {
            range.include(rest.get(target).copied().unwrap_or(0.0));
        }
    }
    ranges
}

/// What the targets add to a vertex: each delta that is not zero, with its weight's range.
pub(crate) fn deltas<'a>(
    mesh: &DeformedMesh<'a>,
    ranges: &'a [Range],
    vertex: usize,
) -> impl Iterator<Item = (Vec3A, Range)> + use<'a> {
    let targets = mesh.targets.iter().zip(ranges);
    targets.filter_map(move |(target, range)| {
        let delta = Vec3A::from(*target.get(vertex)?);
        (delta != Vec3A::ZERO).then_some((delta, *range))
    })
}

/// The box of a mesh that is morphed and not skinned: at the middle of all ranges, and anywhere in them.
pub(crate) fn morph_box(mesh: &DeformedMesh, ranges: &[Range]) -> [Aabb; 2] {
    let mut boxes = [Aabb::EMPTY; 2];
    for (vertex, position) in mesh.positions.iter().enumerate() {
        let position = Vec3A::from(*position);
        let (mut middle, mut least, mut largest) = (position, position, position);
        for (delta, range) in deltas(mesh, ranges, vertex) {
            let (one, other) = (delta * range.least, delta * range.largest);
            middle += one * 0.5 + other * 0.5;
            least += one.min(other);
            largest += one.max(other);
        }
        if !(least.is_finite() && largest.is_finite()) {
            // What is no number would be lost in unions: it may be anywhere.
            (least, largest) = (Vec3A::NEG_INFINITY, Vec3A::INFINITY);
        }
        let [inner, outer] = &mut boxes;
        *inner = inner.union(&Aabb::new(Vec3::from(middle), Vec3::from(middle)));
        *outer = outer.union(&Aabb::new(Vec3::from(least), Vec3::from(largest)));
    }
    boxes
}
