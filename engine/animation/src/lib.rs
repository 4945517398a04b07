//! The animation of a scene: a rig of nodes, clips that play on it, poses, skins and morph targets.
//! All are pure values: the pose is a function of time. The crate reads no clock, is independent of
//! file formats and GPUs, never panics, and does not allocate per frame once its vectors have
//! grown.
//!
//! When a scene is loaded, [`Track::new`] and [`Clip::new`] check the clips, [`Skeleton::new`]
//! checks the skins, and [`Extents`] bounds the distance of every node. In each frame,
//! [`Player::pose_at`] computes the pose, [`Rig::update_world`] the world transforms of moving
//! nodes, [`Skeleton::joint_matrices`] the matrices of skinned vertices, and [`Pose::weights`]
//! returns the weights of morph targets.
//!
//! ```
//! use antumbra_animation::*;
//! use glam::{Affine3A, Quat, Vec3};
//!
//! // An arm of two bones: the upper one on the ground, the lower one a metre above.
//! let rest = |y| Rest::Parts(Trs { translation: Vec3::Y * y, ..Trs::IDENTITY });
//! let node = |name: &str, parent, y| {
//!     RigNode { name: name.into(), parent, rest: rest(y), weights: Vec::new() }
//! };
//! let rig = Rig::new(vec![node("upper", None, 0.0), node("lower", Some(RigNodeId(0)), 1.0)])?;
//!
//! // In one clip it bends to the left within a second, in another it jumps up.
//! let bent = Quat::from_rotation_z(1.5);
//! let bend = Track::new(
//!     Interpolation::Linear,
//!     vec![0.0, 1.0],
//!     Values::Rotation(vec![Quat::IDENTITY, bent]),
//!     0,
//! )?;
//! let jump = Track::new(
//!     Interpolation::Linear,
//!     vec![0.0, 1.0],
//!     Values::Translation(vec![Vec3::ZERO, Vec3::Y * 9.0]),
//!     0,
//! )?;
//! let clips = [
//!     Clip::new("bend".into(), vec![Channel { node: RigNodeId(1), track: bend }], &rig)?,
//!     Clip::new("jump".into(), vec![Channel { node: RigNodeId(0), track: jump }], &rig)?,
//! ];
//!
//! // A skin of one vertex at its tip. Its object moves with the upper bone, so a jump is in the
//! // object's transform and not in its box.
//! let skin = Skin {
//!     joints: vec![RigNodeId(0), RigNodeId(1)],
//!     inverse_bind: vec![Affine3A::IDENTITY, Affine3A::from_translation(Vec3::NEG_Y)],
//! };
//! let skeleton = Skeleton::new(&rig, &skin, &[])?;
//! assert_eq!(skeleton.space(), Some(RigNodeId(0)));
//! assert!(skeleton.is_moved_by(&clips[0]) && !skeleton.is_moved_by(&clips[1]));
//! let tip = Vec3::new(0.0, 2.0, 0.0);
//! let reach = Extents::new(&rig, &clips).reach(&skeleton, [(1, cull::Aabb::new(tip, tip))]);
//!
//! // Half a second into a fade of two seconds, the pose is a quarter of the other clip.
//! let mut player = Player::new();
//! let once = Playback { repeat: Repeat::Once, ..Playback::looped(ClipId(0), 0.0) };
//! let layer = player.play(once);
//! player.cross_fade(layer, Playback::looped(ClipId(1), 1.0), 1.0, 2.0);
//! let (mut workspace, mut pose) = (Workspace::new(&rig), Pose::new(&rig));
//! player.pose_at(&rig, &clips, 1.5, &mut workspace, &mut pose);
//!
//! let (mut world, mut matrices) = (Vec::new(), Vec::new());
//! rig.world(&pose, &mut world);
//! rig.update_world(&rig.moved_by(&clips), &pose, &mut world); // what all later frames do instead
//! skeleton.joint_matrices(&rig, &pose, &mut matrices);
//! let tip = matrices[1].transform_point3(tip);
//! assert!((world[0].translation.y - 9.0 * 0.5 * 0.25).abs() < 1e-5);
//! assert!(tip.x < -0.9 && tip.y > 1.0);
//! assert!(reach.contains_point(tip) && reach.max.x < 2.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]
#![forbid(unsafe_code)]

mod check;
mod clip;
mod extents;
mod hull;
mod player;
mod pose;
mod rig;
mod sample;
mod skeleton;
mod skin;

pub use check::{ClipError, TrackError};
pub use clip::{Channel, Clip, Interpolation, Track, Values};
pub use extents::{Extents, WeightRanges};
pub use player::{ClipId, LayerId, Playback, Player, Repeat, Workspace};
pub use pose::Pose;
pub use rig::{Rest, Rig, RigError, RigNode, RigNodeId, Trs};
pub use skeleton::{Skeleton, SkinError};
pub use skin::Skin;
