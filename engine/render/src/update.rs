//! Changes of the scene between frames. They are applied to the hierarchy at once, and to the data
//! on the GPU at the start of the next frame. Nothing waits.

use std::collections::HashSet;
use std::time::Duration;

use cull::{Aabb, LeafRange, ObjectId};
use scene::MeshId;

/// The work of an update.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct UpdateReport {
    /// The CPU time.
    pub cpu: Duration,
    /// The ids of the added objects, in the order of their changes. An id may have belonged to an
    /// object that was removed.
    pub added: Vec<ObjectId>,
    /// The number of meshes whose pose changed.
    pub poses: u32,
    /// The number of inner nodes of the hierarchy whose box was computed again.
    pub refitted_nodes: u64,
    /// The number of leaves below nodes that were rebuilt because movement had degraded them.
    pub rebuilt_leaves: u64,
    /// The number of leaves that the next frame uploads.
    pub dirty_leaves: usize,
    /// True if the whole hierarchy has degraded and is too large to be rebuilt within a frame.
    /// Frames cost more than necessary until
    /// [`Renderer::rebuild_hierarchy`](crate::Renderer::rebuild_hierarchy) is called.
    pub is_degraded: bool,
}

/// The lists of an update in progress, kept to allocate nothing in the steady state.
#[derive(Default)]
pub(crate) struct UpdateScratch {
    /// The box of the object of each change; empty for a removed object.
    pub(crate) bounds: Vec<Aabb>,
    pub(crate) gone: HashSet<ObjectId>,
    /// The skinned meshes that get an object.
    pub(crate) taken: HashSet<MeshId>,
    pub(crate) moves: Vec<(ObjectId, Aabb)>,
    pub(crate) changed: Vec<ObjectId>,
    pub(crate) reordered: Vec<LeafRange>,
}
