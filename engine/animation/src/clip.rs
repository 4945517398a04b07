//! Clips: the movement of a rig's nodes over time.

use std::collections::HashSet;

use glam::{Quat, Vec3, Vec4};

use crate::check::{ClipError, LARGEST, TrackError, check_times, normalise};
use crate::rig::{Rest, Rig, RigNodeId};
use crate::sample::{Mix, Place, hermite, slerp, unit};

/// The interpolation from one key to the next (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The value stays until the next key.
    Step,
    /// Linear; rotations by the shorter arc.
    Linear,
    /// Cubic Hermite splines: three values per key, the tangent in, the value, the tangent out.
    Cubic,
}

/// The values of a track, one per key, or three with [`Interpolation::Cubic`].
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// The translation of a node in its parent.
    Translation(Vec<Vec3>),
    /// The rotation of a node; unit quaternions, except the tangents of cubic tracks.
    Rotation(Vec<Quat>),
    /// The scale along each of the node's axes, per key.
    Scale(Vec<Vec3>),
    /// The weights of a node's morph targets: all targets of the first value, then of the next.
    Weights(Vec<f32>),
}

/// Keys over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// The interpolation from key to key.
    pub interpolation: Interpolation,
    /// The times of the keys, in seconds, strictly ascending. Clips play from 0 on: an earlier key
    /// only affects the interpolation to the next key.
    pub times_s: Vec<f32>,
    /// The values of the keys.
    pub values: Values,
}

impl Track {
    /// Creates a checked track. Rotations are normalised, except tangents, since quantised
    /// rotations are not exactly of unit length. `targets` is the number of the node's morph
    /// targets and only matters for weights.
    ///
    /// # Errors
    /// No keys; times that are not finite, or not ascending; too few or too many values; values
    /// that are not finite or beyond 10^9; rotations of length 0.
    pub fn new(
        interpolation: Interpolation,
        times_s: Vec<f32>,
        mut values: Values,
        targets: usize,
    ) -> Result<Self, TrackError> {
        check_times(&times_s)?;
        let parts = if interpolation == Interpolation::Cubic { 3 } else { 1 };
        let keys = times_s.len();
        let (count, width) = match &values {
            Values::Translation(values) | Values::Scale(values) => (values.len(), 1),
            Values::Rotation(values) => (values.len(), 1),
            Values::Weights(values) => (values.len(), targets),
        };
        let needed = keys.saturating_mul(parts).saturating_mul(width);
        if count != needed {
            return Err(TrackError::Count { values: count, needed });
        }
        let first = |is_so: fn(f32) -> bool| match &values {
            Values::Translation(values) | Values::Scale(values) => {
                values.iter().position(|value| value.to_array().into_iter().any(is_so))
            }
            Values::Rotation(values) => {
                values.iter().position(|q| q.to_array().into_iter().any(is_so))
            }
            Values::Weights(values) => values.iter().position(|weight| is_so(*weight)),
        };
        if let Some(value) = first(|number| !number.is_finite()) {
            return Err(TrackError::NotFinite { value });
        }
        if let Some(value) = first(|number| number.abs() > LARGEST) {
            return Err(TrackError::TooLarge { value });
        }
        if let Values::Rotation(values) = &mut values {
            normalise(values, parts)?;
        }
        Ok(Self { interpolation, times_s, values })
    }

    /// Returns the position of a time among the keys; `None` without keys.
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

    /// Returns a key's value; for weights, the value of the first target of `stride`.
    pub(crate) fn value<T: Copy>(&self, values: &[T], key: usize, stride: usize) -> Option<T> {
        self.part(values, key, 1, stride, 0)
    }

    /// Returns one of a key's three values (tangent in, value, tangent out), for one of `stride`
    /// targets. Tracks that are not cubic have only the value.
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

    /// Returns the value at a place; rotations are interpolated linearly.
    fn mixed<T: Mix>(&self, values: &[T], place: Place, stride: usize, target: usize) -> Option<T> {
        let at = |key, part| self.part(values, key, part, stride, target);
        let (key, t, interval_s) = match place {
            Place::Key(key) => return at(key, 1),
            Place::Between { key, fraction, interval_s } => (key, fraction, interval_s),
        };
        let from = at(key, 1)?;
        let to = at(key + 1, 1)?;
        Some(match self.interpolation {
            Interpolation::Step => from,
            Interpolation::Linear => from * (1.0 - t) + to * t,
            Interpolation::Cubic => {
                let leaving = at(key, 2)?;
                let arriving = at(key + 1, 0)?;
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

    /// Writes the weights of the morph targets at a time to `weights`, one element per target.
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

/// The movement of one property of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The node of the rig that the track moves.
    pub node: RigNodeId,
    /// The keys of the property, over the time of the clip in seconds.
    pub track: Track,
}

impl Channel {
    /// Returns true if the channel animates the transform of its node, not the weights of morph
    /// targets.
    pub fn is_transform(&self) -> bool {
        !matches!(self.track.values, Values::Weights(_))
    }
}

/// A named animation of a rig, which lasts until its last key.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// The name, for people.
    pub name: String,
    /// The channels; each property of a node occurs at most once.
    pub channels: Vec<Channel>,
}

impl Clip {
    /// Creates a checked clip of a rig. All tracks pass through [`Track::new`] again.
    ///
    /// # Errors
    /// Nodes that do not exist or have a matrix; two channels for one property; weights without
    /// morph targets; the errors of [`Track::new`].
    pub fn new(name: String, channels: Vec<Channel>, rig: &Rig) -> Result<Self, ClipError> {
        let mut moved = HashSet::new();
        let checked = channels.into_iter().enumerate().map(|(channel, Channel { node, track })| {
            let RigNodeId(id) = node;
            let place = rig.nodes().get(id as usize);
            let place = place.ok_or(ClipError::NoNode { channel, node: id })?;
            if !moved.insert((id, std::mem::discriminant(&track.values))) {
                return Err(ClipError::Twice { channel, node: id });
            }
            let is_weights = matches!(track.values, Values::Weights(_));
            if is_weights && place.weights.is_empty() {
                return Err(ClipError::NoTargets { channel, node: id });
            }
            if !is_weights && matches!(place.rest, Rest::Matrix(_)) {
                return Err(ClipError::Matrix { channel, node: id });
            }
            let Track { interpolation, times_s, values } = track;
            let track = Track::new(interpolation, times_s, values, place.weights.len())
                .map_err(|error| ClipError::Track { channel, error })?;
            Ok(Channel { node, track })
        });
        Ok(Self { name, channels: checked.collect::<Result<_, _>>()? })
    }

    /// Returns the time of the last key in seconds, which is the clip's duration. A loop restarts
    /// after this time.
    pub fn duration_s(&self) -> f32 {
        let ends = self.channels.iter().filter_map(|channel| channel.track.times_s.last());
        ends.fold(0.0, |longest, end| longest.max(*end))
    }
}
