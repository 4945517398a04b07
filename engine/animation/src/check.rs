//! The checks of a clip, made once when it is created.

use std::collections::HashSet;

use glam::Quat;

use crate::clip::{Channel, Clip, Interpolation, Track, Values};
use crate::rig::{Rest, Rig, RigNodeId};

/// The largest number that is accepted: products of a few of them must stay finite.
const LARGEST: f32 = 1e9;

/// The reason why keys make no track.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrackError {
    /// No keys.
    #[error("there are no keys")]
    Empty,
    /// A time that is not finite.
    #[error("key {key} is at {time_s} s, which is no time")]
    NoTime {
        /// The index of the key.
        key: usize,
        /// The time of the key.
        time_s: f32,
    },
    /// A key that is not later than the one before.
    #[error("key {key} is at {time_s} s, not later than the one before")]
    NotLater {
        /// The index of the key.
        key: usize,
        /// The time of the key.
        time_s: f32,
    },
    /// A number of values that does not fit the keys.
    #[error("there are {values} values where the keys need {needed}")]
    Count {
        /// The number of values.
        values: usize,
        /// The number of values needed.
        needed: usize,
    },
    /// A value that is not finite.
    #[error("value {value} is not finite")]
    NotFinite {
        /// The index of the value.
        value: usize,
    },
    /// A value beyond 10^9.
    #[error("value {value} is beyond {LARGEST}, which is more than can be played")]
    TooLarge {
        /// The index of the value.
        value: usize,
    },
    /// A time beyond 10^9 s.
    #[error("key {key} is at {time_s} s, which is later than can be played")]
    TooLate {
        /// The index of the key.
        key: usize,
        /// The time of the key.
        time_s: f32,
    },
    /// A rotation of length 0.
    #[error("value {value} is a rotation of length 0")]
    NoRotation {
        /// The index of the value.
        value: usize,
    },
}

/// The reason why channels make no clip of a rig.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ClipError {
    /// A node that does not exist.
    #[error("channel {channel} moves node {node}, which is not there")]
    NoNode {
        /// The index of the channel.
        channel: usize,
        /// The node that it names.
        node: u32,
    },
    /// A node with a matrix as its transform.
    #[error("channel {channel} moves node {node}, which is placed by a matrix")]
    Matrix {
        /// The index of the channel.
        channel: usize,
        /// The node with the matrix.
        node: u32,
    },
    /// A property that another channel animates.
    #[error("channel {channel} moves what another channel of node {node} moves")]
    Twice {
        /// The index of the channel.
        channel: usize,
        /// The node of the property.
        node: u32,
    },
    /// Weights of a node that has no morph targets.
    #[error("channel {channel} moves weights of node {node}, which has no morph targets")]
    NoTargets {
        /// The index of the channel.
        channel: usize,
        /// The node of the weights.
        node: u32,
    },
    /// Keys that make no track.
    #[error("channel {channel}: {error}")]
    Track {
        /// The index of the channel.
        channel: usize,
        /// The fault of the track.
        #[source]
        error: TrackError,
    },
}

impl Track {
    /// Creates a checked track. Rotations are normalised (quantised ones are a little off), except
    /// tangents. `targets` is the number of the node's morph targets; it counts for weights only.
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
                values.iter().position(|it| it.to_array().into_iter().any(is_so))
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
}

fn check_times(times_s: &[f32]) -> Result<(), TrackError> {
    if times_s.is_empty() {
        return Err(TrackError::Empty);
    }
    let mut last_s = f32::NEG_INFINITY;
    for (key, time_s) in times_s.iter().copied().enumerate() {
        if !time_s.is_finite() || time_s < -LARGEST {
            return Err(TrackError::NoTime { key, time_s });
        }
        if time_s > LARGEST {
            return Err(TrackError::TooLate { key, time_s });
        }
        if time_s <= last_s {
            return Err(TrackError::NotLater { key, time_s });
        }
        last_s = time_s;
    }
    Ok(())
}

/// Normalises all rotations: every value, or the middle one of three.
fn normalise(values: &mut [Quat], parts: usize) -> Result<(), TrackError> {
    for (index, value) in values.iter_mut().enumerate() {
        if parts == 3 && index % 3 != 1 {
            continue;
        }
        let length = value.length();
        if length < 1e-6 {
            return Err(TrackError::NoRotation { value: index });
        }
        *value /= length;
    }
    Ok(())
}

impl Clip {
    /// Creates a checked clip of a rig: all its tracks go through [`Track::new`].
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
}
