//! Clips: what the nodes of a rig do over time.

use glam::{Quat, Vec3};

use crate::rig::RigNodeId;

/// How a track goes from one key to the next (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// It stays until the next key.
    Step,
    /// Straight; rotations by the shorter arc.
    Linear,
    /// Cubic Hermite splines: three values a key, the tangent in, the value, the tangent out.
    Cubic,
}

/// What a track moves, with one value a key, or three with [`Interpolation::Cubic`].
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Where a node is in its parent.
    Translation(Vec<Vec3>),
    /// How it is turned; unit length, but for the tangents of cubic tracks.
    Rotation(Vec<Quat>),
    /// How it is scaled.
    Scale(Vec<Vec3>),
    /// Its morph targets' weights: all targets of the first value, then of the next.
    Weights(Vec<f32>),
}

/// Keys over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// How to go from key to key.
    pub interpolation: Interpolation,
    /// When each key is, in seconds, strictly ascending. Clips play from 0 on: keys before that
    /// count only for what follows them.
    pub times_s: Vec<f32>,
    /// What they are.
    pub values: Values,
}

/// What one property of one node does.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Whose.
    pub node: RigNodeId,
    /// What.
    pub track: Track,
}

/// Something that a rig can do. It lasts until its last key.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// What it is, for people.
    pub name: String,
    /// What moves; each property of a node at most once.
    pub channels: Vec<Channel>,
}
