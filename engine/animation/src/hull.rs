//! Points whose hull holds what a track does in a span of time: the ends of straight pieces, and the control
//! points of cubic ones (a cubic is a mix of its Bernstein control points with factors that are not
//! negative and 1 together, so it does not leave their hull, however far it overshoots its keys).

use glam::{Quat, Vec4};

use crate::clip::{Interpolation, Track};
use crate::sample::{Mix, slerp, unit};

/// A span of time. Steps belong to the span they begin in: a key of a step track at the end of a span is
/// not part of it, unless the span is that moment alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    pub from_s: f32,
    pub to_s: f32,
}

/// A piece of a track within a span: from `key` to the next one.
#[derive(Clone, Copy)]
struct Piece {
    key: usize,
    /// From where to where of it, each 0 to 1.
    from: f32,
    to: f32,
    interval_s: f32,
}

/// Calls `key` for keys that stand for all before or after, or for a step, and `piece` for the pieces between.
fn walk(
    track: &Track,
    span: Span,
    mut visit_key: impl FnMut(usize),
    mut visit_piece: impl FnMut(Piece),
) {
    let Span { from_s, to_s } = span;
    let times_s = &track.times_s;
    let (Some(first_s), Some(last_s)) = (times_s.first(), times_s.last()) else { return };
    if from_s <= *first_s {
        visit_key(0);
    }
    let is_step = track.interpolation == Interpolation::Step;
    let is_moment = from_s >= to_s;
    if to_s > *last_s || (to_s == *last_s && (!is_step || is_moment)) {
        visit_key(times_s.len() - 1);
    }
    let key = times_s.partition_point(|key_s| *key_s <= from_s).saturating_sub(1);
    let pairs = times_s.iter().zip(times_s.iter().skip(1)).enumerate().skip(key);
    for (key, (start_s, end_s)) in pairs {
        if *start_s > to_s || (is_step && !is_moment && *start_s >= to_s) {
            break;
        }
        if is_step {
            visit_key(key);
            continue;
        }
        let interval_s = end_s - start_s;
        let within = |time_s: f32| ((time_s - start_s) / interval_s).clamp(0.0, 1.0);
        visit_piece(Piece { key, from: within(from_s), to: within(to_s), interval_s });
    }
}

/// The control points of the part of a cubic between two places.
fn control_points<T: Mix>(ends: [T; 2], tangents: [T; 2], from: f32, to: f32) -> [T; 4] {
    let third = 1.0 / 3.0;
    let inner = [ends[0] + tangents[0] * third, ends[1] + tangents[1] * -third];
    let lerp = |a: T, b: T, t: f32| a * (1.0 - t) + b * t;
    let blossom = |r: f32, s: f32, t: f32| {
        let first =
            [lerp(ends[0], inner[0], r), lerp(inner[0], inner[1], r), lerp(inner[1], ends[1], r)];
        lerp(lerp(first[0], first[1], s), lerp(first[1], first[2], s), t)
    };
    [blossom(from, from, from), blossom(from, from, to), blossom(from, to, to), blossom(to, to, to)]
}

/// Visits points whose hull holds a place, a scale, or one of `stride` weights.
pub(crate) fn hull<T: Mix>(
    track: &Track,
    values: &[T],
    (stride, target): (usize, usize),
    span: Span,
    visit: &mut impl FnMut(T),
) {
    let at = |key, part| track.part(values, key, part, stride, target);
    let visit = std::cell::RefCell::new(visit);
    let pass = |point: T| (*visit.borrow_mut())(point);
    walk(
        track,
        span,
        |key| {
            if let Some(value) = at(key, 1) {
                pass(value);
            }
        },
        |Piece { key, from, to, interval_s }| {
            let (Some(first), Some(last)) = (at(key, 1), at(key + 1, 1)) else { return };
            if track.interpolation != Interpolation::Cubic {
                pass(first * (1.0 - from) + last * from);
                pass(first * (1.0 - to) + last * to);
            } else if let (Some(leaving), Some(arriving)) = (at(key, 2), at(key + 1, 0)) {
                let tangents = [leaving * interval_s, arriving * interval_s];
                for point in control_points([first, last], tangents, from, to) {
                    pass(point);
                }
            }
        },
    );
}

/// Visits groups of points whose **cone** holds a rotation: each rotation of a piece is a sum of the points
/// of its group with factors that are not negative, brought to unit length. Arcs of great circles are
/// such sums of their ends. The points of one group have signs that fit each other.
pub(crate) fn cones(track: &Track, values: &[Quat], span: Span, visit: &mut impl FnMut(&[Vec4])) {
    let value = |key| track.value(values, key, 1);
    let visit = std::cell::RefCell::new(visit);
    let pass = |points: &[Vec4]| (*visit.borrow_mut())(points);
    walk(
        track,
        span,
        |key| {
            if let Some(value) = value(key) {
                pass(&[unit(value.into(), Quat::IDENTITY).into()]);
            }
        },
        |Piece { key, from, to, interval_s }| {
            let (Some(first), Some(last)) = (value(key), value(key + 1)) else { return };
            if track.interpolation != Interpolation::Cubic {
                pass(&[slerp(first, last, from).into(), slerp(first, last, to).into()]);
                return;
            }
            let leaving = track.part(values, key, 2, 1, 0);
            let arriving = track.part(values, key + 1, 0, 1, 0);
            if let (Some(leaving), Some(arriving)) = (leaving, arriving) {
                let tangents =
                    [Vec4::from(leaving) * interval_s, Vec4::from(arriving) * interval_s];
                pass(&control_points([first.into(), last.into()], tangents, from, to));
            }
        },
    );
}
