//! The checks of a clip, which run once when it is created.

use glam::Quat;

/// The largest number that is accepted: products of a few such numbers must stay finite.
pub(crate) const LARGEST: f32 = 1e9;

/// The reason why keys are not a valid track.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrackError {
    /// A track without a key: it needs at least one.
    #[error("there are no keys")]
    Empty,
    /// A time that is not finite.
    #[error("key {key} is at {time_s} s, which is not a time")]
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

/// The reason why channels are not a valid clip of a rig.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ClipError {
    /// A node that does not exist.
    #[error("channel {channel} moves node {node}, which is not there")]
    NoNode {
        /// The index of the channel.
        channel: usize,
        /// The index of the missing node.
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
    /// A property that another channel already animates.
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
    /// Keys that are not a valid track.
    #[error("channel {channel}: {error}")]
    Track {
        /// The index of the channel.
        channel: usize,
        /// The fault of the track.
        #[source]
        error: TrackError,
    },
}

pub(crate) fn check_times(times_s: &[f32]) -> Result<(), TrackError> {
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

/// Normalises all rotations: every value, or with tangents the middle one of three.
pub(crate) fn normalise(values: &mut [Quat], parts: usize) -> Result<(), TrackError> {
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
