//! Clips: the movement of a rig's nodes over time.

use glam::{Quat, Vec3};

use crate::rig::RigNodeId;

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
    /// Its rotation; unit quaternions, except the tangents of cubic tracks.
    Rotation(Vec<Quat>),
    /// Its scale.
    Scale(Vec<Vec3>),
    /// Its morph targets' weights: all targets of the first value, then of the next.
    Weights(Vec<f32>),
}

/// Keys over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// The interpolation from key to key.
    pub interpolation: Interpolation,
    /// The times of the keys, in seconds, strictly ascending. Clips play from 0 on: keys before
    /// that count only for what follows them.
    pub times_s: Vec<f32>,
    /// The values of the keys.
    pub values: Values,
}

/// The movement of one property of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The node.
    pub node: RigNodeId,
    /// The track.
    pub track: Track,
}

/// A named animation of a rig, which lasts until its last key.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// The name, for people.
    pub name: String,
    /// The channels; each property of a node occurs at most once.
    pub channels: Vec<Channel>,
}
