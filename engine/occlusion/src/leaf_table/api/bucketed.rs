//! Tables whose leaves have any number of draws, in buckets.

use cull::{Hierarchy, LeafIndex, LeafRange};
use gpu::{Buffer, Device, MemoryKind, Predicates, PredicationMode, vk};

use super::super::bucket_cells::{BucketCells, BucketDraw, MAX_BUCKETS};
use super::super::changes::DrawChanges;
use super::super::counts::LeafCounts;
use super::super::dirty_list::DirtyList;
use super::super::draw_layout::DrawLayout;
use super::super::upload_frames::UploadFrames;
use super::super::{LeafTable, LeafTableId};
use crate::error::{BucketError, Error};
use crate::passes::ProxyBox;

/// The parameters of a table with buckets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BucketTableInfo {
    /// The number of buckets, at most [`MAX_BUCKETS`](crate::MAX_BUCKETS).
    pub bucket_count: u32,
    /// The initial room for draws. When it is full, buffers that are half as large again replace
    /// it.
    pub draw_capacity: u32,
    /// The predication mode; `None` takes the device's best.
    pub predication: Option<PredicationMode>,
    /// The number of frames that may be in flight at once.
    pub frames_in_flight: usize,
}

impl BucketTableInfo {
    /// Returns the number of cells of a new table: its draws, and gaps between buckets.
    pub(crate) fn cell_capacity(&self) -> u32 {
        BucketCells::room_for(self.draw_capacity, self.bucket_count)
    }
}

impl LeafTable {
    /// Creates a table for the leaves of `hierarchy`, without draws. [`LeafTable::set_draws`] gives
    /// objects any number of draws. The first frame uploads everything.
    pub(crate) fn bucketed(
        device: &Device,
        hierarchy: &Hierarchy,
        info: BucketTableInfo,
    ) -> Result<Self, Error> {
        let BucketTableInfo { bucket_count, predication, frames_in_flight, .. } = info;
        if bucket_count > MAX_BUCKETS {
            return Err(BucketError::TooMany { bucket_count }.into());
        }
        let leaf_count = hierarchy.leaf_objects().len();
        let [boxes, firsts] = leaf_buffers(device, leaf_count)?;
        let cells = BucketCells::new(bucket_count, hierarchy.leaf_objects());
        let cell_capacity = info.cell_capacity();
        let mut table = Self {
            id: LeafTableId::new(),
            version: 0,
            device: device.clone(),
            boxes,
            firsts: Some(firsts),
            predicates: Predicates::linked(device, predication, cell_capacity, frames_in_flight)?,
            layout: DrawLayout::Bucketed(Box::new(cells)),
            leaf_capacity: leaf_count as u32,
            cell_capacity,
            counts: LeafCounts::default(),
            changes: DrawChanges::new(cell_capacity as usize),
            dirty: DirtyList::new(leaf_count, |leaf| leaf.0),
            dirty_draws: DirtyList::new(0, |leaf| leaf.0),
            dirty_cells: DirtyList::new(cell_capacity as usize, |cell| *cell),
            uploads: UploadFrames::default(),
            uploaded_in: None,
            disorders: device.disorders(),
        };
        table.count_all(leaf_count);
        table.follow_cells();
        Ok(table)
    }

    /// Replaces the draws of the objects in some leaves. One call for many leaves takes much less
    /// time than a call per leaf.
    ///
    /// # Errors
    /// [`BucketError::Unknown`] and [`BucketError::OneDrawPerLeaf`]. Nothing has changed then.
    pub fn set_draws(&mut self, changed: &[(LeafIndex, &[BucketDraw])]) -> Result<(), Error> {
        changed.iter().try_for_each(|(_, draws)| self.check_draws(draws))?;
        let Self { layout: DrawLayout::Bucketed(cells), counts, .. } = self else { return Ok(()) };
        cells.replace(changed);
        recount(counts, cells, changed.iter().map(|(leaf, _)| *leaf));
        self.follow_cells();
        Ok(())
    }

    /// Refuses draws in buckets that the table does not have.
    ///
    /// # Errors
    /// [`BucketError::Unknown`], [`BucketError::OneDrawPerLeaf`].
    pub fn check_draws(&self, draws: &[BucketDraw]) -> Result<(), Error> {
        let DrawLayout::Bucketed(cells) = &self.layout else {
            return Err(BucketError::OneDrawPerLeaf.into());
        };
        let bucket_count = cells.bucket_count();
        match draws.iter().map(|draw| draw.bucket).find(|bucket| bucket.0 >= bucket_count) {
            Some(bucket) => Err(BucketError::Unknown { bucket, bucket_count }.into()),
            None => Ok(()),
        }
    }

    /// Notes that the object of a leaf was moved: the next frame uploads its box.
    pub fn mark_moved(&mut self, leaf: LeafIndex) {
        self.uploaded_in = None;
        self.version += 1;
        self.dirty.push(leaf);
    }

    /// Notes that the objects in some ranges of leaves, which may be nested, are in another order
    /// now. Additional leaves must lie in these ranges. Objects keep their draws.
    ///
    /// # Errors
    /// The errors of [`LeafTable::set_draws`].
    pub fn reorder(&mut self, hierarchy: &Hierarchy, ranges: &[LeafRange]) -> Result<(), Error> {
        let Self { layout: DrawLayout::Bucketed(cells), counts, dirty, .. } = self else {
            return Err(BucketError::OneDrawPerLeaf.into());
        };
        let objects = hierarchy.leaf_objects();
        counts.grow(objects.len());
        dirty.grow(objects.len());
        cells.reorder(ranges, objects);
        recount(counts, cells, ranges.iter().flat_map(|range| range.iter()));
        self.follow_cells();
        Ok(())
    }

    /// Creates larger buffers if the present ones have no room for the leaves or draws. Replaces
    /// either all buffers or, after an error, none. New buffers are uploaded as a whole.
    pub(crate) fn make_room(&mut self) -> Result<(), Error> {
        let DrawLayout::Bucketed(cells) = &self.layout else { return Ok(()) };
        let leaf_count = cells.leaf_count();
        let cell_count = cells.cell_count();
        let buffers = if leaf_count > self.leaf_capacity {
            Some(leaf_buffers(&self.device, leaf_count as usize)?)
        } else {
            None
        };
        if cell_count > self.cell_capacity {
            let half_more = self.cell_capacity.saturating_add(self.cell_capacity / 2);
            let capacity = cell_count.max(half_more);
            self.predicates.grow(capacity)?;
            self.cell_capacity = capacity;
            self.dirty_cells.grow(capacity as usize);
            self.dirty_cells.push_all(0..cell_count);
            self.changes.forget();
        }
        if let Some([boxes, firsts]) = buffers {
            (self.boxes, self.firsts) = (boxes, Some(firsts));
            self.leaf_capacity = leaf_count;
            self.dirty.push_all((0..leaf_count).map(LeafIndex));
        }
        Ok(())
    }

    fn count_all(&mut self, leaf_count: usize) {
        let Self { layout, counts, .. } = self;
        *counts =
            LeafCounts::new((0..leaf_count as u32).map(|index| layout.count(LeafIndex(index))));
    }

    /// Marks the leaves and cells that changed in the layout.
    fn follow_cells(&mut self) {
        let Self { layout, dirty, dirty_cells, changes, .. } = self;
        let DrawLayout::Bucketed(cells) = layout else { return };
        dirty_cells.grow(cells.cell_count() as usize);
        let mut noted = std::mem::take(&mut cells.changes);
        let mut is_changed = false;
        let mut mark = |cell: u32| {
            is_changed = true;
            dirty_cells.push(cell);
            changes.push(cell);
        };
        noted.take_emptied(&mut mark);
        noted.take_leaves(|leaf| {
            dirty.push(leaf);
            cells.cells_of(leaf).for_each(|(_, cell)| mark(cell));
        });
        cells.changes = noted;
        self.version += u64::from(is_changed);
        if is_changed {
            self.uploaded_in = None;
        }
    }
}

/// Counts the draws of leaves again.
fn recount(counts: &mut LeafCounts, cells: &BucketCells, leaves: impl Iterator<Item = LeafIndex>) {
    for leaf in leaves {
        let before = counts.of(LeafRange { first: leaf, count: 1 });
        counts.replace(leaf.0 as usize, before, cells.count(leaf));
    }
}

/// Creates the buffers of `leaf_count` leaves: their boxes and their first cells.
fn leaf_buffers(device: &Device, leaf_count: usize) -> Result<[Buffer; 2], Error> {
    let wanted = leaf_count as u64 * size_of::<ProxyBox>() as u64;
    let limit = u64::from(device.adapter().limits.max_storage_buffer_range);
    if wanted > limit {
        let what = "the bytes of the boxes of all objects".to_owned();
        return Err(gpu::Error::TooLarge { what, wanted, limit }.into());
    }
    let buffer = |name, element_bytes: usize| {
        let bytes = leaf_count * element_bytes;
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        Buffer::new(device, name, bytes as u64, usage, MemoryKind::Device)
    };
    Ok([
        buffer("leaf boxes", size_of::<ProxyBox>())?,
        buffer("first draws of leaves", size_of::<u32>())?,
    ])
}
