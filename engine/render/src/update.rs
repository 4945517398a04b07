//! Changes of the scene between frames: applied to the hierarchy at once, and to the data on the
//! GPU at the start of the next frame, in its order. Nothing waits.

use std::collections::HashSet;
use std::time::Duration;

use cull::{Aabb, LeafRange, ObjectId};
use scene::MeshId;

/// The work of an update.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct UpdateReport {
    /// Time the CPU spent.
    pub cpu: Duration,
    /// The ids of the objects that were added, in the order of their changes. An id may have
    /// belonged to an object that is gone.
    pub added: Vec<ObjectId>,
    /// Meshes that took another pose.
    pub poses: u32,
    /// Inner nodes of the hierarchy whose box was computed again.
    pub refitted_nodes: u64,
    /// Leaves under nodes that were rebuilt because moving had worn them.
    pub rebuilt_leaves: u64,
    /// Leaves that the next frame uploads.
    pub dirty_leaves: usize,
    /// True if the hierarchy is worn as a whole and too large to be rebuilt within a frame: frames
    /// cost more than necessary until
    /// [`Renderer::rebuild_hierarchy`](crate::Renderer::rebuild_hierarchy) was called.
    pub is_degraded: bool,
}

/// Lists of an update in the making, kept to allocate nothing.
#[derive(Default)]
pub(crate) struct UpdateScratch {
    /// The box of the object of each change; empty where it is removed.
    pub(crate) bounds: Vec<Aabb>,
    pub(crate) gone: HashSet<ObjectId>,
    /// The skinned meshes that get an object.
    pub(crate) taken: HashSet<MeshId>,
    pub(crate) moves: Vec<(ObjectId, Aabb)>,
    pub(crate) changed: Vec<ObjectId>,
    pub(crate) reordered: Vec<LeafRange>,
}
