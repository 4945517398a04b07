//! How a scene moves: a rig of nodes, clips that play on it, poses, skins, morph targets, and the boxes
//! that hold while it does. Pure values: time in, poses out.
#![forbid(unsafe_code)]

mod clip;
mod rig;
mod skin;

pub use clip::{Channel, Clip, Interpolation, Track, Values};
pub use rig::{Node, NodeId, Rest, Rig, RigError, Trs};
pub use skin::Skin;
