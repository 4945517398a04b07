//! Points whose hull holds all values of a track: the values of keys, and the control points of
//! cubic pieces. A cubic is a mix of its Bernstein control points. The factors are not negative and
//! their sum is 1, so the cubic stays in their hull, however far it overshoots its keys.

use crate::clip::{Interpolation, Track};
use crate::sample::Mix;

/// Visits points whose hull holds a translation, a scale, or one of `stride` weights.
pub(crate) fn hull<T: Mix>(
    track: &Track,
    values: &[T],
    stride: usize,
    target: usize,
    visit: &mut impl FnMut(T),
) {
    const THIRD: f32 = 1.0 / 3.0;
    let at = |key, part| track.part(values, key, part, stride, target);
    for (key, time_s) in track.times_s.iter().enumerate() {
        let Some(value) = at(key, 1) else { continue };
        visit(value);
        let Some(next_s) = track.times_s.get(key + 1) else { continue };
        if track.interpolation != Interpolation::Cubic {
            continue;
        }
        let third_s = (next_s - time_s) * THIRD;
        if let (Some(leaving), Some(next), Some(arriving)) =
            (at(key, 2), at(key + 1, 1), at(key + 1, 0))
        {
            visit(value + leaving * third_s);
            visit(next + arriving * -third_s);
        }
    }
}
