//! What a file becomes: a scene, the rig it hangs on, and what plays on that.

use animation::{Clip, NodeId, Rig, Skin};
use cull::{Aabb, ObjectId};
use glam::Affine3A;
use render::scene::{BlendedId, DeformerId, LightId, Scene};

/// A camera of the file. It looks along its node's -z, up is y.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Its node's name, or its own.
    pub name: String,
    /// Where it is.
    pub node: NodeId,
    /// The full vertical angle of sight, in radians.
    pub fov_y_rad: f32,
    /// Distance of the near plane, in metres.
    pub near_m: f32,
}

/// What hangs on a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placed {
    /// An object of [`Scene::objects`].
    Object(ObjectId),
    /// An object of [`Surfaces::blended`](render::scene::Surfaces::blended).
    Blended(BlendedId),
    /// A light.
    Light(LightId),
}

/// Something that hangs on a node and goes where it goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// On which node.
    pub node: NodeId,
    /// What.
    pub placed: Placed,
    /// From its own space to its node's.
    pub local: Affine3A,
    /// What changes its form, with the index of its skin in [`Imported::skins`].
    pub deformer: Option<(DeformerId, Option<usize>)>,
    /// For each clip a box, in its own space, that it stays in while that clip plays; empty where it does
    /// not change its form.
    pub clip_bounds: Vec<Aabb>,
    /// A box, in its own space, that it stays in whatever clips play, together or one after the other;
    /// empty where it does not change its form.
    pub blend_bounds: Aabb,
}

/// A scene and its life.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The scene at rest.
    pub scene: Scene,
    /// Its nodes.
    pub rig: Rig,
    /// What plays on them.
    pub clips: Vec<Clip>,
    /// The joints of skinned meshes.
    pub skins: Vec<Skin>,
    /// What hangs on which node.
    pub placements: Vec<Placement>,
    /// Its cameras.
    pub cameras: Vec<Camera>,
    /// What was in the file that is not shown, for people.
    pub notes: Vec<String>,
}
