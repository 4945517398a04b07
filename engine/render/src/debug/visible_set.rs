//! The exact set of objects that own a pixel, for the strategy `ideal`.
//!
//! The set is found in advance with a wait. The frame is drawn by the exact strategy, its objects
//! are drawn again against the finished depth, and the CPU waits for the result.

use cull::{LeafIndex, ObjectId};
use gpu::{Buffer, Device, MemoryKind, vk};

use crate::error::Error;
use crate::render_view::RendererId;

/// The leaves that own at least one pixel of a frame, nearest first. The holes of masked materials
/// count as covered: the set may contain too many leaves with masked materials, never too few.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VisibleSet {
    pub(crate) leaves: Vec<LeafIndex>,
    /// The objects of these leaves, wherever they are in the hierarchy.
    pub(crate) objects: Vec<ObjectId>,
    /// The revision of the scene that the set was found in.
    pub(crate) revision: SceneRevision,
}

/// The set's name in errors.
pub(crate) const VISIBLE_SET: &str = "a visible set (`VisibleSet`)";

/// The revision of a renderer's scene: the number of its changes. A change makes visible sets
/// invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SceneRevision {
    renderer: RendererId,
    changes: u64,
}

impl SceneRevision {
    pub(crate) fn first(renderer: RendererId) -> Self {
        Self { renderer, changes: 0 }
    }

    /// Returns true if nothing has changed since the renderer was created.
    pub(crate) fn is_first(&self) -> bool {
        self.changes == 0
    }

    pub(crate) fn advance(&mut self) {
        self.changes = self.changes.wrapping_add(1);
    }
}

impl VisibleSet {
    /// Returns the leaves, nearest first.
    pub fn leaves(&self) -> &[LeafIndex] {
        &self.leaves
    }

    /// Returns the renderer that found the set.
    pub(crate) fn renderer(&self) -> RendererId {
        self.revision.renderer
    }

    /// Returns true if the set was found in this revision of the scene.
    pub(crate) fn is_of(&self, revision: SceneRevision) -> bool {
        self.revision == revision
    }
}

/// The GPU objects that the search for the set needs.
pub(crate) struct SeenLeaves {
    pub(crate) values: Buffer,
    pub(crate) readback: Buffer,
}

impl SeenLeaves {
    pub(crate) fn new(device: &Device, leaves: usize) -> Result<Self, Error> {
        let size_bytes = leaves as u64 * 4;
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_DST
            | vk::BufferUsageFlags::TRANSFER_SRC;
        let readback_usage = vk::BufferUsageFlags::TRANSFER_DST;
        Ok(Self {
            values: Buffer::new(device, "seen leaves", size_bytes, usage, MemoryKind::Device)?,
            readback: Buffer::new(
                device,
                "seen leaves read back",
                size_bytes,
                readback_usage,
                MemoryKind::ReadBack,
            )?,
        })
    }

    /// Returns true if a leaf owned a pixel of the frame that was read back last.
    pub(crate) fn is_seen(&self, leaf: LeafIndex) -> bool {
        let place = leaf.0 as usize;
        self.readback.read::<u32>(place..place + 1).first().is_some_and(|value| *value != 0)
    }
}
