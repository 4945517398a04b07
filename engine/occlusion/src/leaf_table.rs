//! The objects as the executor sees them, in the order of the hierarchy's leaves, so that a subtree
//! is a range of each array: a box, an indirect draw and counts per leaf, on the CPU and on the
//! GPU.

mod changes;
mod counts;
mod dirty_list;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use cull::{Aabb, Hierarchy, LeafIndex, LeafRange, ObjectId};
use gpu::{Buffer, BufferSlice, Device, Frame, IndirectDraw, Predicates, Predication, Tick, vk};

use crate::error::Error;
use crate::passes::{ProxyBox, ScatterIo, ScatterPass};
use changes::DrawChanges;
pub use counts::LeafCount;
use counts::LeafCounts;
use dirty_list::DirtyList;

/// A mesh that leaves can draw: its indexed draw and its triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshDraw {
    /// The draw; its first instance is the leaf and need not be set.
    pub draw: IndirectDraw,
    /// The number of triangles.
    pub triangles: u32,
}

/// The place of a [`MeshDraw`] in a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshDrawId(pub u32);

impl MeshDrawId {
    /// The id for a leaf without an object: nothing is drawn.
    pub const NONE: Self = Self(u32::MAX);
}

/// The parameters of a table.
#[derive(Clone, Debug)]
pub struct LeafTableInfo {
    /// The meshes that leaves can draw.
    pub mesh_draws: Arc<[MeshDraw]>,
    /// The way that hidden draws are skipped; `None` takes the device's best.
    pub predication: Option<Predication>,
    /// Frames that may be in flight at once.
    pub frames_in_flight: usize,
}

/// The identity of a table: objects made for one fit no other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct LeafTableId(u64);

impl LeafTableId {
    /// Creates an identity that no other table of the process has.
    fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// The leaves of one scene. Changed leaves are marked; the next frame uploads them.
pub struct LeafTable {
    pub(crate) id: LeafTableId,
    device: Device,
    /// One [`ProxyBox`] per leaf, not enlarged.
    boxes: Buffer,
    pub(crate) predicates: Predicates,
    mesh_draws: Arc<[MeshDraw]>,
    leaf_draws: Vec<MeshDrawId>,
    counts: LeafCounts,
    pub(crate) changes: DrawChanges,
    dirty: DirtyList<LeafIndex>,
    /// The disorders of frames that were seen.
    disorders: u64,
}

/// Elements that the owner of the objects keeps per leaf, and uploads with those of the table.
#[derive(Clone, Copy)]
pub struct LeafElements {
    /// The new elements of the [stale leaves](LeafTable::dirty), in their order.
    pub elements: BufferSlice,
    /// All elements, by leaf.
    pub array: BufferSlice,
    /// Size of an element, whole values.
    pub element_bytes: usize,
}

impl LeafTable {
    /// Uploads the leaves of `hierarchy`. `draw_of` returns the mesh of an object.
    ///
    /// # Errors
    /// [`gpu::Error::Unsupported`] for a way to skip draws that the device lacks;
    /// [`gpu::Error::TooLarge`] for more leaves than it takes; no memory; a failed call.
    pub fn new(
        device: &Device,
        hierarchy: &Hierarchy,
        info: LeafTableInfo,
        draw_of: impl Fn(ObjectId) -> MeshDrawId,
    ) -> Result<Self, Error> {
        let LeafTableInfo { mesh_draws, predication, frames_in_flight } = info;
        let objects = hierarchy.leaf_objects();
        let leaf_draws: Vec<MeshDrawId> = objects.iter().map(|object| draw_of(*object)).collect();
        let counts = || leaf_draws.iter().map(|id| count_of(&mesh_draws, *id));
        let boxes: Vec<ProxyBox> = objects
            .iter()
            .zip(counts())
            .map(|(it, count)| leaf_box(hierarchy, *it, count))
            .collect();
        let draws: Vec<IndirectDraw> =
            (0..).zip(&leaf_draws).map(|(leaf, id)| draw_of_leaf(&mesh_draws, *id, leaf)).collect();
        Ok(Self {
            id: LeafTableId::new(),
            device: device.clone(),
            boxes: device.upload("leaf boxes", &boxes, vk::BufferUsageFlags::STORAGE_BUFFER)?,
            predicates: Predicates::new(device, predication, &draws, frames_in_flight)?,
            counts: LeafCounts::new(counts()),
            changes: DrawChanges::new(objects.len()),
            dirty: DirtyList::new(objects.len(), |leaf| leaf.0),
            disorders: device.disorders(),
            mesh_draws,
            leaf_draws,
        })
    }

    /// Returns the draw of a leaf; an empty one where the leaf is free.
    pub fn draw(&self, leaf: LeafIndex) -> IndirectDraw {
        let id = self.leaf_draws.get(leaf.0 as usize).copied().unwrap_or(MeshDrawId::NONE);
        draw_of_leaf(&self.mesh_draws, id, leaf.0)
    }

    /// Counts the objects and triangles of a range of leaves.
    pub fn count(&self, leaves: LeafRange) -> LeafCount {
        match (leaves.count, self.leaf_draws.get(leaves.first.0 as usize)) {
            (1, Some(id)) => count_of(&self.mesh_draws, *id),
            _ => self.counts.of(leaves),
        }
    }

    /// Returns the boxes on the GPU: one [`ProxyBox`] per leaf, not enlarged.
    pub fn boxes(&self) -> BufferSlice {
        self.boxes.whole()
    }

    /// Returns the predicates over the draws of all leaves.
    pub fn predicates(&self) -> &Predicates {
        &self.predicates
    }

    /// Makes room for another number of frames in flight.
    pub fn set_frames_in_flight(&mut self, frames_in_flight: usize) {
        self.predicates.set_frames_in_flight(frames_in_flight);
    }

    /// Notes that the object of a leaf was replaced or moved, or has the mesh `now`: the next frame
    /// uploads it.
    pub fn mark_dirty(&mut self, leaf: LeafIndex, now: MeshDrawId) {
        let place = leaf.0 as usize;
        let Some(id) = self.leaf_draws.get_mut(place) else { return };
        let before = std::mem::replace(id, now);
        if before != now {
            let [before, now] = [before, now].map(|id| count_of(&self.mesh_draws, id));
            self.counts.replace(place, before, now);
            self.changes.push(leaf);
        }
        self.dirty.push(leaf);
    }

    /// Returns the leaves that the next frame uploads, once it is [begun](LeafTable::begin).
    pub fn dirty(&self) -> &[LeafIndex] {
        self.dirty.items()
    }

    /// Forgets the changes that are known to be in GPU memory: those of frames that ran in their
    /// order. After frames in another order, which a host may cause, every leaf is uploaded again.
    pub fn begin(&mut self) {
        let disorders = self.device.disorders();
        if std::mem::replace(&mut self.disorders, disorders) != disorders {
            self.dirty.push_all((0..self.leaf_draws.len() as u32).map(LeafIndex));
            self.changes.forget();
        }
        self.dirty.forget(self.device.confirmed());
    }

    /// Records the upload of the stale leaves, before anything of `frame` reads them. They stay
    /// stale until a frame that was [submitted](LeafTable::submitted) is known to have run.
    ///
    /// # Errors
    /// No memory.
    pub fn upload(
        &self,
        frame: &mut Frame<'_>,
        hierarchy: &Hierarchy,
        scatter: &ScatterPass,
        beside: LeafElements,
    ) -> Result<(), Error> {
        if self.dirty().is_empty() {
            return Ok(());
        }
        let bounds = |leaf: &LeafIndex| {
            let object = hierarchy.leaf_objects().get(leaf.0 as usize);
            let object = object.copied().unwrap_or(ObjectId(u32::MAX));
            leaf_box(hierarchy, object, self.count(LeafRange { first: *leaf, count: 1 }))
        };
        let uploads = frame.uploads();
        let leaves = uploads.push_iter(self.dirty().iter().map(|leaf| leaf.0))?;
        let draws = uploads.push_iter(self.dirty().iter().map(|leaf| self.draw(*leaf)))?;
        let boxes = uploads.push_iter(self.dirty().iter().map(bounds))?;
        let io = |elements, array| ScatterIo { leaves, elements, array };
        let arrays = [
            (io(beside.elements, beside.array), beside.element_bytes),
            (io(draws, self.predicates.draws()), size_of::<IndirectDraw>()),
            (io(boxes, self.boxes()), size_of::<ProxyBox>()),
        ];
        scatter.record(frame.commands(), self.dirty().len() as u32, &arrays);
        Ok(())
    }

    /// Notes that the frame of the last [`LeafTable::upload`] was submitted.
    pub fn submitted(&mut self, tick: Tick) {
        self.dirty.sent(tick);
        self.dirty.forget(self.device.confirmed());
    }
}

fn count_of(mesh_draws: &[MeshDraw], id: MeshDrawId) -> LeafCount {
    let mesh = mesh_draws.get(id.0 as usize);
    mesh.map_or(LeafCount::default(), |it| LeafCount { draws: 1, triangles: it.triangles.into() })
}

fn draw_of_leaf(mesh_draws: &[MeshDraw], id: MeshDrawId, leaf: u32) -> IndirectDraw {
    let draw = mesh_draws.get(id.0 as usize).map(|it| it.draw).unwrap_or_default();
    IndirectDraw { first_instance: leaf, ..draw }
}

/// Returns the box of an object, not enlarged; an inverted one if it is not there.
fn leaf_box(hierarchy: &Hierarchy, object: ObjectId, count: LeafCount) -> ProxyBox {
    let node = hierarchy.node_of(object);
    let bounds = node.map_or(Aabb::EMPTY, |node| hierarchy.bounds(node));
    ProxyBox::from(bounds).counting(count.triangles as u32)
}
