//! The objects as the executor sees them, in the order of the hierarchy's leaves, so that a subtree
//! is a range of each array: a box, indirect draws and counts per leaf, on the CPU and on the GPU.

mod api;
mod bucket_cells;
mod changes;
mod counts;
mod dirty_list;
mod draw_layout;
mod upload_frames;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use cull::{Aabb, Hierarchy, LeafIndex, LeafRange, ObjectId, SceneCosts};
use gpu::{
    Buffer, BufferSlice, Device, DrawLink, Frame, IndirectDraw, Predicates, PredicationMode,
    RecordingId, Tick, vk,
};

use crate::error::{Error, NotUploaded};
use crate::passes::{LeafLinks, ProxyBox, ScatterIo, ScatterPass};
pub(crate) use api::bucketed::BucketTableInfo;
pub use bucket_cells::{BucketDraw, BucketId, MAX_BUCKETS};
use changes::DrawChanges;
pub use counts::LeafCount;
use counts::LeafCounts;
use dirty_list::DirtyList;
use draw_layout::{CopiedDraws, MeshDraws};
pub(crate) use draw_layout::{DrawLayout, draw_range};
pub use draw_layout::{MeshDraw, MeshDrawId};
use upload_frames::UploadFrames;

/// The parameters of a table.
#[derive(Clone, Debug)]
pub struct LeafTableInfo {
    /// The meshes that leaves can draw.
    pub mesh_draws: Arc<[MeshDraw]>,
    /// The predication mode; `None` takes the device's best.
    pub predication: Option<PredicationMode>,
    /// The number of frames that may be in flight at once.
    pub frames_in_flight: usize,
}

/// The identity of a table. Objects that were made for one table do not fit another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct LeafTableId(u64);

impl LeafTableId {
    /// Creates an identity that no other table of the process has.
    fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// The leaves of one scene. Changes mark leaves, and the next frame uploads the marked leaves.
pub struct LeafTable {
    pub(crate) id: LeafTableId,
    /// The number of changes. A plan can only be executed as long as it does not change.
    pub(crate) version: u64,
    device: Device,
    /// One [`ProxyBox`] per leaf, not enlarged.
    boxes: Buffer,
    /// The first cell of each leaf, where leaves have any number of draws.
    firsts: Option<Buffer>,
    pub(crate) predicates: Predicates,
    pub(crate) layout: DrawLayout,
    /// The numbers of leaves and of cells that the buffers have room for.
    leaf_capacity: u32,
    cell_capacity: u32,
    counts: LeafCounts,
    pub(crate) changes: DrawChanges,
    dirty: DirtyList<LeafIndex>,
    /// The dirty leaves with another draw, where leaves have one draw each: most changes are moves.
    dirty_draws: DirtyList<LeafIndex>,
    /// The cells whose command or link changed, where leaves have any number of draws.
    dirty_cells: DirtyList<u32>,
    uploads: UploadFrames,
    /// The frame that uploads everything marked, until it is submitted.
    uploaded_in: Option<RecordingId>,
    /// The device's count of disorders of frames when it was last read.
    disorders: u64,
}

/// Elements that the owner of the objects keeps per leaf and uploads together with the table.
#[derive(Clone, Copy)]
pub struct LeafElements {
    /// The new elements of the [stale leaves](LeafTable::dirty), in the order of these leaves.
    pub elements: BufferSlice,
    /// All elements, by leaf.
    pub array: BufferSlice,
    /// The size of an element in bytes, a multiple of 4.
    pub element_bytes: usize,
}

impl LeafTable {
    /// Uploads the leaves of `hierarchy`, each with at most one draw. `draw_of` returns the mesh of
    /// an object.
    ///
    /// # Errors
    /// [`gpu::Error::Unsupported`] for a predication mode that the device lacks;
    /// [`gpu::Error::TooLarge`] for more leaves than the device takes; no memory; a failed call.
    pub fn new(
        device: &Device,
        hierarchy: &Hierarchy,
        info: LeafTableInfo,
        draw_of: impl Fn(ObjectId) -> MeshDrawId,
    ) -> Result<Self, Error> {
        let LeafTableInfo { mesh_draws, predication, frames_in_flight } = info;
        let objects = hierarchy.leaf_objects();
        let leaves = objects.iter().map(|object| draw_of(*object)).collect();
        let draws = MeshDraws { meshes: mesh_draws, leaves };
        let count = objects.len() as u32;
        let counts = || (0..count).map(|leaf| draws.count(LeafIndex(leaf)));
        let boxes: Vec<ProxyBox> = objects
            .iter()
            .zip(counts())
            .map(|(leaf, count)| leaf_box(hierarchy, *leaf, count))
            .collect();
        let commands: Vec<IndirectDraw> =
            (0..count).map(|leaf| draws.draw(LeafIndex(leaf))).collect();
        Ok(Self {
            id: LeafTableId::new(),
            version: 0,
            device: device.clone(),
            boxes: device.upload("leaf boxes", &boxes, vk::BufferUsageFlags::STORAGE_BUFFER)?,
            firsts: None,
            predicates: Predicates::new(device, predication, &commands, frames_in_flight)?,
            counts: LeafCounts::new(counts()),
            leaf_capacity: count,
            cell_capacity: count,
            layout: DrawLayout::OnePerLeaf(draws),
            changes: DrawChanges::new(objects.len()),
            dirty: DirtyList::new(objects.len(), |leaf| leaf.0),
            dirty_draws: DirtyList::new(objects.len(), |leaf| leaf.0),
            dirty_cells: DirtyList::new(0, |cell| *cell),
            uploads: UploadFrames::default(),
            uploaded_in: None,
            disorders: device.disorders(),
        })
    }

    /// Replaces a mesh that is not drawn by any leaf at present. Leaves that are
    /// [marked](LeafTable::mark_dirty) with this id from now on have the new draw. Does nothing in
    /// a table with buckets, which has no meshes.
    pub fn set_mesh_draw(&mut self, id: MeshDrawId, draw: MeshDraw) {
        if let DrawLayout::OnePerLeaf(draws) = &mut self.layout
            && let Some(there) = Arc::make_mut(&mut draws.meshes).get_mut(id.0 as usize)
        {
            *there = draw;
        }
    }

    /// Returns the draw of a leaf in a table with one draw per leaf; an empty draw for a free leaf.
    pub fn draw(&self, leaf: LeafIndex) -> IndirectDraw {
        match &self.layout {
            DrawLayout::OnePerLeaf(draws) => draws.draw(leaf),
            DrawLayout::Bucketed(_) => IndirectDraw::default(),
        }
    }

    /// Returns true if each leaf has one draw, in the cell of the leaf's number and with one
    /// instance.
    pub fn has_one_draw_per_leaf(&self) -> bool {
        matches!(self.layout, DrawLayout::OnePerLeaf(_))
    }

    /// Counts the draws and triangles of a range of leaves.
    pub fn count(&self, leaves: LeafRange) -> LeafCount {
        match leaves.count {
            1 => self.layout.count(leaves.first),
            _ => self.counts.of(leaves),
        }
    }

    /// Returns the properties of the present scene that costs depend on; default values for a scene
    /// without draws.
    pub fn scene_costs(&self, hierarchy: &Hierarchy) -> SceneCosts {
        let all = hierarchy.root().map(|root| self.count(hierarchy.leaves(root)));
        match all.filter(|all| all.draws > 0) {
            Some(all) => SceneCosts { triangles_per_leaf: all.triangles as f32 / all.draws as f32 },
            None => SceneCosts::default(),
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

    /// Changes the number of frames that may be in flight at once.
    pub fn set_frames_in_flight(&mut self, frames_in_flight: usize) {
        self.predicates.set_frames_in_flight(frames_in_flight);
    }

    /// Returns the lists of draws per leaf on the GPU, where leaves have any number of draws.
    pub fn links(&self) -> Option<LeafLinks> {
        let firsts = self.firsts.as_ref()?.whole();
        Some(LeafLinks { firsts, links: self.predicates.links()? })
    }

    /// Returns the draws in the form that rings copy.
    pub(crate) fn copied_draws(&self) -> CopiedDraws<'_> {
        CopiedDraws { layout: &self.layout, capacity: self.cell_capacity }
    }

    /// Notes that the object of a leaf was replaced or moved, or now has the mesh `now`: the next
    /// frame uploads it. The mesh is ignored in a table with buckets.
    pub fn mark_dirty(&mut self, leaf: LeafIndex, now: MeshDrawId) {
        if let DrawLayout::OnePerLeaf(draws) = &mut self.layout
            && let Some(before) = draws.replace(leaf, now)
        {
            self.counts.replace(leaf.0 as usize, before, draws.count(leaf));
            self.changes.push(leaf.0);
            self.dirty_draws.push(leaf);
        }
        self.uploaded_in = None;
        self.version += 1;
        self.dirty.push(leaf);
    }

    /// Returns the leaves that the next frame uploads, once it is [begun](LeafTable::begin).
    pub fn dirty(&self) -> &[LeafIndex] {
        self.dirty.items()
    }

    /// Begins the uploads of a frame. Makes room for new leaves and draws, and forgets the changes
    /// that frames are known to have written to GPU memory in their order. After frames in another
    /// order, which a host may cause, every leaf is uploaded again.
    ///
    /// # Errors
    /// [`gpu::Error::TooLarge`] for more draws than the device takes; no memory; a failed call.
    /// Nothing is lost: the next call tries again.
    pub fn begin(&mut self) -> Result<(), Error> {
        self.uploaded_in = None;
        self.make_room()?;
        let disorders = self.device.disorders();
        if std::mem::replace(&mut self.disorders, disorders) != disorders {
            self.dirty.push_all((0..self.layout.leaf_count()).map(LeafIndex));
            self.dirty_draws.push_all((0..self.layout.leaf_count()).map(LeafIndex));
            if !self.has_one_draw_per_leaf() {
                self.dirty_cells.push_all(0..self.cell_capacity);
            }
            self.changes.forget();
        }
        self.forget_uploaded();
        self.dirty.sort();
        Ok(())
    }

    fn forget_uploaded(&mut self) {
        let Self { device, uploads, .. } = self;
        let ran = uploads.newest_run(device.settled(), |frame| device.is_lost(frame));
        self.dirty.forget(ran);
        self.dirty_draws.forget(ran);
        self.dirty_cells.forget(ran);
    }

    /// Records the upload of the stale leaves, before anything of `frame` reads them. They stay
    /// stale until a frame that was [submitted](LeafTable::submitted) is known to have run. Plans
    /// cannot be executed in a frame without this upload.
    ///
    /// # Errors
    /// No memory.
    pub fn upload(
        &mut self,
        frame: &mut Frame<'_>,
        hierarchy: &Hierarchy,
        scatter: &ScatterPass,
        beside: Option<LeafElements>,
    ) -> Result<(), Error> {
        self.upload_leaves(frame, hierarchy, scatter, beside)?;
        self.uploaded_in = Some(frame.commands().recording());
        Ok(())
    }

    /// Refuses a frame that reads changed leaves and does not upload them.
    pub(crate) fn check_uploaded(&self, frame: &Frame<'_>) -> Result<(), Error> {
        let is_changed = !self.dirty().is_empty() || !self.dirty_cells.items().is_empty();
        if is_changed && self.uploaded_in != Some(frame.commands().recording()) {
            Err(NotUploaded.into())
        } else {
            Ok(())
        }
    }

    fn upload_leaves(
        &self,
        frame: &mut Frame<'_>,
        hierarchy: &Hierarchy,
        scatter: &ScatterPass,
        beside: Option<LeafElements>,
    ) -> Result<(), Error> {
        if self.dirty().is_empty() {
            return Ok(());
        }
        let bounds = |leaf: &LeafIndex| {
            let object = hierarchy.leaf_objects().get(leaf.0 as usize);
            let object = object.copied().unwrap_or(ObjectId(u32::MAX));
            leaf_box(hierarchy, object, self.layout.count(*leaf))
        };
        let uploads = frame.uploads();
        let leaves = uploads.push_iter(self.dirty().iter().map(|leaf| leaf.0))?;
        let boxes = uploads.push_iter(self.dirty().iter().map(bounds))?;
        let io =
            |elements, array, element_bytes| ScatterIo { leaves, elements, array, element_bytes };
        let beside = beside.map(|beside| io(beside.elements, beside.array, beside.element_bytes));
        let boxes = io(boxes, self.boxes(), size_of::<ProxyBox>());
        let firsts = match (&self.layout, self.links()) {
            (DrawLayout::Bucketed(cells), Some(to)) => {
                let firsts = self.dirty().iter().map(|leaf| cells.first(*leaf));
                Some(io(uploads.push_iter(firsts)?, to.firsts, size_of::<u32>()))
            }
            _ => None,
        };
        let arrays = beside.into_iter().chain(firsts).chain([boxes]);
        scatter.record(frame.commands(), self.dirty().len() as u32, arrays);
        self.upload_draws(frame, scatter)?;
        self.upload_cells(frame, scatter)
    }

    /// Records the upload of changed draws, where leaves have one draw each.
    fn upload_draws(&self, frame: &mut Frame<'_>, scatter: &ScatterPass) -> Result<(), Error> {
        let changed = self.dirty_draws.items();
        if changed.is_empty() || !self.has_one_draw_per_leaf() {
            return Ok(());
        }
        let uploads = frame.uploads();
        let leaves = uploads.push_iter(changed.iter().map(|leaf| leaf.0))?;
        let elements = uploads.push_iter(changed.iter().map(|leaf| self.draw(*leaf)))?;
        let array = self.predicates.draws();
        let element_bytes = size_of::<IndirectDraw>();
        let draws = ScatterIo { leaves, elements, array, element_bytes };
        scatter.record(frame.commands(), changed.len() as u32, [draws]);
        Ok(())
    }

    /// Records the upload of changed cells, where leaves have any number of draws.
    fn upload_cells(&self, frame: &mut Frame<'_>, scatter: &ScatterPass) -> Result<(), Error> {
        let (DrawLayout::Bucketed(cells), Some(to)) = (&self.layout, self.links()) else {
            return Ok(());
        };
        let changed = self.dirty_cells.items();
        if changed.is_empty() {
            return Ok(());
        }
        let uploads = frame.uploads();
        let leaves = uploads.push_iter(changed.iter().copied())?;
        let draws = uploads.push_iter(changed.iter().map(|cell| cells.command(*cell)))?;
        let links = uploads.push_iter(changed.iter().map(|cell| cells.link(*cell)))?;
        let io =
            |elements, array, element_bytes| ScatterIo { leaves, elements, array, element_bytes };
        let arrays = [
            io(draws, self.predicates.draws(), size_of::<IndirectDraw>()),
            io(links, to.links, size_of::<DrawLink>()),
        ];
        scatter.record(frame.commands(), changed.len() as u32, arrays);
        Ok(())
    }

    /// Notes that the frame of the last [`LeafTable::upload`] was submitted. If the upload failed,
    /// all marks stay.
    pub fn submitted(&mut self, tick: Tick) {
        if self.uploaded_in.take().is_some() {
            self.dirty.sent(tick);
            self.dirty_draws.sent(tick);
            self.dirty_cells.sent(tick);
            self.uploads.sent(tick);
        }
        self.forget_uploaded();
    }
}

/// Returns the box of an object, not enlarged; an inverted box if the object does not exist.
fn leaf_box(hierarchy: &Hierarchy, object: ObjectId, count: LeafCount) -> ProxyBox {
    let node = hierarchy.node_of(object);
    let bounds = node.map_or(Aabb::EMPTY, |node| hierarchy.bounds(node));
    ProxyBox::from(bounds).counting(count.triangles as u32)
}
