//! Best first refinement: a box for a span of time from boxes of its parts, which are halved where they
//! make the whole larger than it need be.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use cull::Aabb;
use glam::Vec3;

use crate::hull::Span;

/// How much larger than what is reached the box may be along each axis, relative to that axis.
const TOLERANCE: f32 = 0.03;
/// The same relative to the longest axis: what is flat need not be told more exactly.
const FLAT_TOLERANCE: f32 = 0.003;
/// Parts to begin with: enough for most clips to show how far they go.
const FIRST_PARTS: usize = 16;

/// What a part of the span adds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    /// What is reached at its middle, about.
    pub inner: Aabb,
    /// What surely nothing leaves within it.
    pub outer: Aabb,
}

struct Part {
    span: Span,
    outer: Aabb,
    /// By how many tolerances it was too large when it was made.
    excess: f32,
}

impl PartialEq for Part {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Part {}

impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Part {
    fn cmp(&self, other: &Self) -> Ordering {
        self.excess.total_cmp(&other.excess)
    }
}

fn excess(outer: &Aabb, inner: &Aabb) -> f32 {
    let size = (inner.max - inner.min).max(Vec3::ZERO);
    let tolerance = (size * TOLERANCE).max(Vec3::splat(size.max_element() * FLAT_TOLERANCE));
    let beyond = (inner.min - outer.min).max(outer.max - inner.max);
    let tolerances = beyond / tolerance.max(Vec3::splat(f32::MIN_POSITIVE));
    tolerances.max_element()
}

/// A box that holds from 0 to `duration_s`. `steps_s` are the times at which something jumps, ascending:
/// parts are cut there first. At most `most_parts` are looked at; what is left then is as large as it is.
pub(crate) fn refine(
    duration_s: f32,
    steps_s: &[f32],
    most_parts: usize,
    mut estimate: impl FnMut(Span) -> Estimate,
) -> Aabb {
    let mut inner = Aabb::EMPTY;
    let mut outer = Aabb::EMPTY;
    let mut heap = BinaryHeap::new();
    let mut looked_at = 0;
    let mut look = |span: Span, inner: &mut Aabb| {
        let Estimate { inner: reached, outer } = estimate(span);
        *inner = inner.union(&reached);
        Part { span, outer, excess: 0.0 }
    };
    // The last moment is no part of a span before it, if something jumps there.
    outer = outer.union(&look(Span { from_s: duration_s, to_s: duration_s }, &mut inner).outer);
    let mut from_s = 0.0;
    let first_parts = most_parts.clamp(1, FIRST_PARTS);
    let mut first = Vec::with_capacity(first_parts);
    for part in 1..=first_parts {
        let to_s = duration_s * (part as f32 / first_parts as f32);
        if to_s > from_s {
            first.push(look(Span { from_s, to_s }, &mut inner));
            from_s = to_s;
            looked_at += 1;
        }
    }
    heap.extend(first.into_iter().map(|part| Part { excess: excess(&part.outer, &inner), ..part }));
    while let Some(part) = heap.pop() {
        // What was too large once may not be now, that others reached as far.
        let now = excess(&part.outer, &inner);
        if now < part.excess && now > 1.0 {
            heap.push(Part { excess: now, ..part });
            continue;
        }
        let cut_s = cut(part.span, steps_s);
        let is_enough = now <= 1.0 || looked_at >= most_parts;
        let Some(cut_s) = cut_s.filter(|_| !is_enough) else {
            outer = outer.union(&part.outer);
            continue;
        };
        let Span { from_s, to_s } = part.span;
        for span in [Span { from_s, to_s: cut_s }, Span { from_s: cut_s, to_s }] {
            let part = look(span, &mut inner);
            heap.push(Part { excess: excess(&part.outer, &inner), ..part });
            looked_at += 1;
        }
    }
    outer
}

/// Where to cut a span: at the jump nearest to its middle, else in the middle; `None` if it is too short.
fn cut(span: Span, steps_s: &[f32]) -> Option<f32> {
    let middle_s = span.from_s * 0.5 + span.to_s * 0.5;
    let after = steps_s.partition_point(|step_s| *step_s < middle_s);
    let near = [steps_s.get(after), after.checked_sub(1).and_then(|before| steps_s.get(before))];
    let within = near.into_iter().flatten().filter(|s| **s > span.from_s && **s < span.to_s);
    let nearest = within.min_by(|a, b| (**a - middle_s).abs().total_cmp(&(**b - middle_s).abs()));
    let cut_s = nearest.copied().unwrap_or(middle_s);
    (cut_s > span.from_s && cut_s < span.to_s).then_some(cut_s)
}
