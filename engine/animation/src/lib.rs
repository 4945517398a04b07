//! How a scene moves: a rig of nodes, clips that play on it, poses, skins, morph targets, and the boxes
//! that hold while it does. Pure values: time in, poses out.
#![forbid(unsafe_code)]

mod alone;
mod attached;
mod bone_tracks;
mod check;
mod clip;
mod form;
mod hull;
mod morph;
mod pose;
mod reach;
mod refine;
mod rig;
mod rotation_set;
mod sample;
mod skeleton;
mod skin;
mod support;
mod together;
mod world;

pub use check::{ClipError, TrackError};
pub use clip::{Channel, Clip, Interpolation, Track, Values};
pub use form::{Binding, DeformedMesh};
pub use pose::Pose;
pub use reach::{Reach, ReachError};
pub use rig::{Node, NodeId, Rest, Rig, RigError, Trs};
pub use skeleton::{Skeleton, SkinError};
pub use skin::Skin;
