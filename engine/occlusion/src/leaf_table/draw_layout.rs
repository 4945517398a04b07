//! The two layouts of draws in the buffer of all indirect commands, with a common interface. A
//! *cell* is the place of a command.

use std::sync::Arc;

use cull::{LeafIndex, LeafRange};
use gpu::{DrawRange, IndirectDraw, LeafDraws};

use super::bucket_cells::{BucketCells, BucketId};
use super::counts::LeafCount;

/// A mesh that leaves can draw: its indexed draw and its triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshDraw {
    /// The draw, with one instance. The table sets its first instance to the leaf.
    pub draw: IndirectDraw,
    /// The number of triangles.
    pub triangles: u32,
}

/// The place of a [`MeshDraw`] in a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshDrawId(pub u32);

impl MeshDrawId {
    /// The id for a leaf without an object, which draws nothing.
    pub const NONE: Self = Self(u32::MAX);
}

/// At most one draw per leaf, all in one bucket: the cell of a leaf has its number.
pub(crate) struct MeshDraws {
    pub(super) meshes: Arc<[MeshDraw]>,
    /// The draw of each leaf.
    pub(super) leaves: Vec<MeshDrawId>,
}

/// The layout of a table.
pub(crate) enum DrawLayout {
    /// Leaf by leaf.
    OnePerLeaf(MeshDraws),
    /// Bucket by bucket.
    Bucketed(Box<BucketCells>),
}

impl MeshDraws {
    pub(super) fn draw(&self, leaf: LeafIndex) -> IndirectDraw {
        let draw = self.mesh(leaf).map(|mesh| mesh.draw).unwrap_or_default();
        IndirectDraw { first_instance: leaf.0, ..draw }
    }

    /// Replaces the mesh of a leaf. Returns the count of the leaf before; `None` if it has this
    /// mesh already or does not exist.
    pub(super) fn replace(&mut self, leaf: LeafIndex, mesh: MeshDrawId) -> Option<LeafCount> {
        let before = self.leaves.get(leaf.0 as usize).filter(|before| **before != mesh)?;
        let before = self.count_of(*before);
        *self.leaves.get_mut(leaf.0 as usize)? = mesh;
        Some(before)
    }

    pub(super) fn count(&self, leaf: LeafIndex) -> LeafCount {
        self.leaves.get(leaf.0 as usize).map(|id| self.count_of(*id)).unwrap_or_default()
    }

    fn count_of(&self, id: MeshDrawId) -> LeafCount {
        let count =
            |mesh_draw: &MeshDraw| LeafCount { draws: 1, triangles: mesh_draw.triangles.into() };
        self.meshes.get(id.0 as usize).map(count).unwrap_or_default()
    }

    fn mesh(&self, leaf: LeafIndex) -> Option<&MeshDraw> {
        self.meshes.get(self.leaves.get(leaf.0 as usize)?.0 as usize)
    }
}

impl DrawLayout {
    /// Returns the number of buckets.
    pub(crate) fn bucket_count(&self) -> u32 {
        match self {
            Self::OnePerLeaf(_) => 1,
            Self::Bucketed(cells) => cells.bucket_count(),
        }
    }

    /// Returns the number of leaves.
    pub(crate) fn leaf_count(&self) -> u32 {
        match self {
            Self::OnePerLeaf(draws) => draws.leaves.len() as u32,
            Self::Bucketed(cells) => cells.leaf_count(),
        }
    }

    /// Counts the draws and triangles of a leaf.
    pub(crate) fn count(&self, leaf: LeafIndex) -> LeafCount {
        match self {
            Self::OnePerLeaf(draws) => draws.count(leaf),
            Self::Bucketed(cells) => cells.count(leaf),
        }
    }

    /// Calls `each` with the cells of a range of leaves, once per bucket with draws of these
    /// leaves, in the order of the buckets. Some of the cells may be empty.
    pub(crate) fn ranges(&self, leaves: LeafRange, mut each: impl FnMut(BucketId, DrawRange)) {
        match self {
            Self::OnePerLeaf(_) if leaves.is_empty() => {}
            Self::OnePerLeaf(_) => each(BucketId(0), draw_range(leaves)),
            Self::Bucketed(cells) => cells.ranges(leaves, each),
        }
    }

    /// Calls `each` with the cells of a leaf, in the order of their buckets.
    pub(crate) fn cells_of(&self, leaf: LeafIndex, mut each: impl FnMut(BucketId, u32)) {
        match self {
            Self::OnePerLeaf(_) => each(BucketId(0), leaf.0),
            Self::Bucketed(cells) => {
                cells.cells_of(leaf).for_each(|(bucket, cell)| each(bucket, cell));
            }
        }
    }

    pub(crate) fn command(&self, cell: u32) -> IndirectDraw {
        match self {
            Self::OnePerLeaf(draws) => draws.draw(LeafIndex(cell)),
            Self::Bucketed(cells) => cells.command(cell),
        }
    }
}

/// The draws of a table, in the form that rings copy.
pub(crate) struct CopiedDraws<'a> {
    pub(super) layout: &'a DrawLayout,
    /// The number of cells that the buffers have room for.
    pub(super) capacity: u32,
}

impl LeafDraws for CopiedDraws<'_> {
    fn count(&self) -> u32 {
        self.capacity
    }

    fn draw(&self, number: u32) -> IndirectDraw {
        self.layout.command(number)
    }

    fn draws_of(&self, leaf: u32, each: &mut dyn FnMut(u32)) {
        self.layout.cells_of(LeafIndex(leaf), |_, cell| each(cell));
    }
}

/// Returns a range of leaves as a range of draws.
pub(crate) fn draw_range(leaves: LeafRange) -> DrawRange {
    DrawRange { first: leaves.first.0, count: leaves.count }
}
