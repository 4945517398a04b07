//! Sampling of tracks: glTF 2.0, appendix C.

use glam::{Quat, Vec3, Vec4};

use crate::clip::{Channel, Clip, Interpolation, Track, Values};

/// The position of a time among the keys of a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    /// A time at a key, or beyond the first or the last.
    Key(usize),
    /// A time between this key and the next.
    Between {
        /// The key before.
        key: usize,
        /// The fraction of the interval that has passed, 0 to 1.
        fraction: f32,
        /// The length of the interval in seconds.
        interval_s: f32,
    },
}

/// A value that can be mixed: all values of tracks, rotations as their four numbers.
pub(crate) trait Mix:
    Copy + std::ops::Add<Output = Self> + std::ops::Mul<f32, Output = Self>
{
}

impl Mix for f32 {}
impl Mix for Vec3 {}
impl Mix for Vec4 {}

/// Returns a cubic Hermite spline with its tangents scaled by the length of its interval.
pub(crate) fn hermite<T: Mix>(from: T, leaving: T, arriving: T, to: T, t: f32) -> T {
    let (t2, t3) = (t * t, t * t * t);
    from * (2.0 * t3 - 3.0 * t2 + 1.0)
        + leaving * (t3 - 2.0 * t2 + t)
        + to * (3.0 * t2 - 2.0 * t3)
        + arriving * (t3 - t2)
}

/// Returns the rotation between two by the shorter arc, at constant speed.
pub(crate) fn slerp(from: Quat, to: Quat, t: f32) -> Quat {
    /// The cosine beyond which the sine of the angle is too small to divide by, and arc and chord
    /// are the same.
    const NEARLY_SAME: f32 = 0.9995;
    let cosine = from.dot(to);
    let to = if cosine < 0.0 { -to } else { to };
    let cosine = cosine.abs();
    if cosine > NEARLY_SAME {
        return unit(Vec4::from(from) * (1.0 - t) + Vec4::from(to) * t, from);
    }
    let angle = cosine.acos();
    let mixed = Vec4::from(from) * ((1.0 - t) * angle).sin() + Vec4::from(to) * (t * angle).sin();
    unit(mixed, from)
}

/// Returns the rotation along these four numbers, or `otherwise` where they have no direction.
pub(crate) fn unit(value: Vec4, otherwise: Quat) -> Quat {
    let length = value.length();
    if length > 1e-6 && length.is_finite() { Quat::from_vec4(value / length) } else { otherwise }
}

impl Track {
    /// Returns the position of a time among its keys; `None` without keys.
    pub(crate) fn place(&self, time_s: f32) -> Option<Place> {
        let next = self.times_s.partition_point(|key_s| *key_s <= time_s);
        let (Some(key), Some(to_s)) = (next.checked_sub(1), self.times_s.get(next)) else {
            return (!self.times_s.is_empty()).then(|| Place::Key(next.saturating_sub(1)));
        };
        let from_s = *self.times_s.get(key)?;
        let interval_s = to_s - from_s;
        let fraction = ((time_s - from_s) / interval_s).clamp(0.0, 1.0);
        Some(Place::Between { key, fraction, interval_s })
    }

    /// Returns a key's value among all values; for weights, the first of one per target.
    pub(crate) fn value<T: Copy>(&self, values: &[T], key: usize, stride: usize) -> Option<T> {
        self.part(values, key, 1, stride, 0)
    }

    /// Returns one of a key's three values (tangent in, value, tangent out), of one of `stride`
    /// targets. Tracks that are not cubic have values alone.
    pub(crate) fn part<T: Copy>(
        &self,
        values: &[T],
        key: usize,
        part: usize,
        stride: usize,
        target: usize,
    ) -> Option<T> {
        let row = if self.interpolation == Interpolation::Cubic { key * 3 + part } else { key };
        values.get(row * stride + target).copied()
    }

    /// Returns its value at a place, with rotations interpolated linearly.
    fn mixed<T: Mix>(&self, values: &[T], place: Place, stride: usize, target: usize) -> Option<T> {
        let at = |key, part| self.part(values, key, part, stride, target);
        let (key, t, interval_s) = match place {
            Place::Key(key) => return at(key, 1),
            Place::Between { key, fraction, interval_s } => (key, fraction, interval_s),
        };
        let (from, to) = (at(key, 1)?, at(key + 1, 1)?);
        Some(match self.interpolation {
            Interpolation::Step => from,
            Interpolation::Linear => from * (1.0 - t) + to * t,
            Interpolation::Cubic => {
                let (leaving, arriving) = (at(key, 2)?, at(key + 1, 0)?);
                hermite(from, leaving * interval_s, arriving * interval_s, to, t)
            }
        })
    }

    /// Returns a translation or a scale at a time.
    pub(crate) fn vector_at(&self, values: &[Vec3], time_s: f32) -> Option<Vec3> {
        self.mixed(values, self.place(time_s)?, 1, 0)
    }

    /// Returns a rotation at a time, of unit length.
    pub(crate) fn rotation_at(&self, values: &[Quat], time_s: f32) -> Option<Quat> {
        let place = self.place(time_s)?;
        let (key, t, interval_s) = match place {
            Place::Key(key) => {
                return Some(unit(self.value(values, key, 1)?.into(), Quat::IDENTITY));
            }
            Place::Between { key, fraction, interval_s } => (key, fraction, interval_s),
        };
        let from = self.value(values, key, 1)?;
        let to = self.value(values, key + 1, 1)?;
        Some(match self.interpolation {
            Interpolation::Step => unit(from.into(), Quat::IDENTITY),
            Interpolation::Linear => slerp(from, to, t),
            Interpolation::Cubic => {
                let leaving = Vec4::from(self.part(values, key, 2, 1, 0)?) * interval_s;
                let arriving = Vec4::from(self.part(values, key + 1, 0, 1, 0)?) * interval_s;
                unit(hermite(from.into(), leaving, arriving, to.into(), t), from)
            }
        })
    }

    /// Writes the morph targets' weights at a time to `weights`, one each.
    pub(crate) fn weights_at(&self, values: &[f32], time_s: f32, weights: &mut [f32]) {
        let Some(place) = self.place(time_s) else { return };
        let stride = weights.len();
        for (target, weight) in weights.iter_mut().enumerate() {
            if let Some(value) = self.mixed(values, place, stride, target) {
                *weight = value;
            }
        }
    }
}

impl Channel {
    /// Returns true if it animates the transform of its node rather than the weights of its morph
    /// targets.
    pub fn is_transform(&self) -> bool {
        !matches!(self.track.values, Values::Weights(_))
    }
}

impl Clip {
    /// Returns the time of its last key in seconds, which is its duration. A loop starts again
    /// after it.
    pub fn duration_s(&self) -> f32 {
        let ends = self.channels.iter().filter_map(|channel| channel.track.times_s.last());
        ends.fold(0.0, |longest, end| longest.max(*end))
    }
}
