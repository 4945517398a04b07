//! The draws of leaves that have any number of them, each in a bucket: a pipeline in a pass.
//!
//! A *cell* is the place of one indirect command. The cells of a bucket are in the order of the
//! leaves of their draws, so the draws of a subtree are one contiguous range per bucket. Empty
//! cells between them leave room for more draws: leaves are grouped in blocks, and each block has a
//! span of cells in every bucket that it uses. A change shifts only the cells of its span. A full
//! span takes room from its neighbours, as in a packed-memory array (Bender, Demaine and
//! Farach-Colton 2000, "Cache-Oblivious B-Trees").

mod bucket;
mod cell_changes;
mod placed_draws;
mod regions;

#[cfg(test)]
mod tests;

use std::mem::{replace, take};
use std::ops::Range;

use cull::{LeafIndex, LeafRange, ObjectId};
use gpu::{DrawLink, DrawRange, IndirectDraw};

use crate::leaf_table::LeafCount;
use bucket::Bucket;
use cell_changes::CellChanges;
use placed_draws::{PlacedDraw, PlacedDraws};
use regions::Regions;

/// A pipeline in a pass, with which draws of objects are drawn together. Buckets are drawn in the
/// order of their numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BucketId(pub u32);

/// The highest number of buckets in a table.
pub const MAX_BUCKETS: u32 = 1 << 16;

/// A draw of an object. A draw without indices or instances draws nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BucketDraw {
    /// The bucket that it is drawn in.
    pub bucket: BucketId,
    /// The command, of any number of instances.
    pub draw: IndirectDraw,
    /// The total number of triangles of all instances.
    pub triangles: u32,
}

/// The number of leaves that share a span per bucket.
const BLOCK_LEAVES: u32 = 64;

/// The end of a list, and the content of an empty cell.
const NONE: u32 = u32::MAX;

/// The draws of all leaves in cells.
pub(crate) struct BucketCells {
    draws: PlacedDraws,
    buckets: Vec<Bucket>,
    /// A bit per block and bucket: set if the block has a draw in the bucket.
    present: Vec<u64>,
    /// The draw in each cell.
    cells: Vec<u32>,
    regions: Regions,
    pub(crate) changes: CellChanges,
    /// Draws that move from old cells to new ones; kept to allocate nothing in the steady state.
    moving: Vec<u32>,
    spread: Vec<u32>,
    listed: Vec<(BucketId, u32)>,
}

impl BucketCells {
    /// Creates the layout for leaves with these objects, without draws.
    pub(crate) fn new(bucket_count: u32, objects: &[ObjectId]) -> Self {
        let mut cells = Self {
            draws: PlacedDraws::EMPTY,
            buckets: (0..bucket_count).map(|_| Bucket::default()).collect(),
            present: Vec::new(),
            cells: Vec::new(),
            regions: Regions::default(),
            changes: CellChanges::default(),
            moving: Vec::new(),
            spread: Vec::new(),
            listed: Vec::new(),
        };
        let all = LeafRange { first: LeafIndex(0), count: objects.len() as u32 };
        cells.reorder(&[all], objects);
        cells
    }

    /// Returns a number of cells that is enough for `draws` draws in any buckets.
    pub(crate) fn room_for(draws: u32, bucket_count: u32) -> u32 {
        let wanted = bucket::wanted_cells(draws.saturating_add(bucket_count));
        wanted.saturating_add(bucket_count.saturating_mul(bucket::LEAST_CELLS))
    }

    /// Returns the number of buckets.
    pub(crate) fn bucket_count(&self) -> u32 {
        self.buckets.len() as u32
    }

    /// Returns the number of leaves.
    pub(crate) fn leaf_count(&self) -> u32 {
        self.draws.leaf_count()
    }

    /// Returns the number of cells, empty ones included.
    pub(crate) fn cell_count(&self) -> u32 {
        self.cells.len() as u32
    }

    /// Returns the command in a cell; an empty command for an empty cell.
    pub(crate) fn command(&self, cell: u32) -> IndirectDraw {
        self.placed_in(cell).map(|placed| placed.draw.draw).unwrap_or_default()
    }

    /// Returns the link from a cell to the next cell of the same leaf.
    pub(crate) fn link(&self, cell: u32) -> DrawLink {
        let link = |placed: &PlacedDraw| DrawLink {
            next: self.place_of(placed.next),
            instance_count: placed.draw.draw.instance_count,
        };
        self.placed_in(cell).map_or(DrawLink::EMPTY, link)
    }

    /// Returns one more than the first cell of a leaf, or [`DrawLink::NO_DRAW`].
    pub(crate) fn first(&self, leaf: LeafIndex) -> u32 {
        self.place_of(self.draws.first(leaf))
    }

    /// Returns the cells of a leaf, in the order of their buckets.
    pub(crate) fn cells_of(&self, leaf: LeafIndex) -> impl Iterator<Item = (BucketId, u32)> {
        self.draws.of(leaf).map(|placed| (placed.draw.bucket, placed.cell))
    }

    pub(crate) fn count(&self, leaf: LeafIndex) -> LeafCount {
        self.draws.of(leaf).fold(LeafCount::default(), |sum, placed| LeafCount {
            draws: sum.draws + 1,
            triangles: sum.triangles + u64::from(placed.draw.triangles),
        })
    }

    /// Calls `each` with the cells of a range of leaves, once per bucket with draws of these
    /// leaves, in the order of the buckets. Some of the cells may be empty.
    pub(crate) fn ranges(&self, leaves: LeafRange, mut each: impl FnMut(BucketId, DrawRange)) {
        if leaves.is_empty() {
            return;
        }
        let last = leaves.first.0 + (leaves.count - 1);
        let blocks = leaves.first.0 / BLOCK_LEAVES..last / BLOCK_LEAVES + 1;
        let words = self.words();
        for word in 0..words {
            let bits = |block: u32| self.present.get(block as usize * words + word).copied();
            let mut left = blocks.clone().fold(0, |all, block| all | bits(block).unwrap_or(0));
            while left != 0 {
                let bucket = word * 64 + left.trailing_zeros() as usize;
                left &= left - 1;
                let leaf_of = |cell: u32| self.placed_in(cell).map_or(NONE, |placed| placed.leaf);
                if let Some(range) = self.buckets[bucket].range(leaves.first.0..last + 1, leaf_of) {
                    each(BucketId(bucket as u32), range);
                }
            }
        }
    }

    /// Replaces the draws of the objects in some leaves. The buckets must exist.
    pub(crate) fn replace(&mut self, changed: &[(LeafIndex, &[BucketDraw])]) {
        // The time of a single change grows with the spans of its bucket. The time of all changes
        // together grows with the number of leaves.
        const MANY: usize = 16;
        let are_many = changed.len() > 1 && changed.len() * MANY >= self.leaf_count() as usize;
        for (leaf, draws) in changed {
            if self.replace_in_place(*leaf, draws) {
                continue;
            }
            if !are_many {
                self.lift_all(*leaf);
            }
            self.draws.free_all(*leaf);
            let listed = take(&mut self.listed);
            for (_, number) in listed.iter().rev() {
                self.draws.push_front(*leaf, draws[*number as usize]);
            }
            self.listed = listed;
            if !are_many {
                self.insert_all(*leaf);
            }
        }
        if are_many {
            self.lay_out();
        }
    }

    /// Collects the draws of a leaf that draw something, in the order of their buckets. Replaces
    /// only the commands if the leaf already has draws in exactly these buckets; returns true then.
    fn replace_in_place(&mut self, leaf: LeafIndex, draws: &[BucketDraw]) -> bool {
        let drawn = |bucket_draw: &&BucketDraw| {
            bucket_draw.draw.index_count > 0 && bucket_draw.draw.instance_count > 0
        };
        self.listed.clear();
        let listed =
            (0..).zip(draws).filter(|index| drawn(&index.1)).map(|index| (index.1.bucket, index.0));
        self.listed.extend(listed);
        self.listed.sort_unstable();
        let before = self.draws.of(leaf).map(|placed| placed.draw.bucket);
        if !before.eq(self.listed.iter().map(|listed| listed.0)) {
            return false;
        }
        let mut number = self.draws.first(leaf);
        for (_, listed) in &self.listed {
            let Some(placed) = self.draws.at_mut(number) else { break };
            placed.draw = draws[*listed as usize];
            number = placed.next;
        }
        self.changes.touch(leaf);
        true
    }

    /// Notes that the objects in some ranges of leaves are in another order now: `objects`, by
    /// leaf. Ranges may be nested, like subtrees. Additional leaves must lie in the ranges.
    pub(crate) fn reorder(&mut self, ranges: &[LeafRange], objects: &[ObjectId]) {
        self.grow(objects.len());
        let leaves = || ranges.iter().flat_map(|range| range.iter());
        let are_most = leaves().count() > objects.len() / 2;
        if !are_most {
            leaves().for_each(|leaf| self.lift_all(leaf));
        }
        for range in ranges {
            if let Some(objects) = objects.get(range.indices()) {
                self.draws.set_objects(range.first, objects);
            }
        }
        if are_most { self.lay_out() } else { leaves().for_each(|leaf| self.insert_all(leaf)) }
    }

    /// Makes places for at least `leaf_count` leaves; new ones have no objects yet.
    fn grow(&mut self, leaf_count: usize) {
        self.draws.grow(leaf_count);
        self.changes.grow(leaf_count);
        let blocks = self.leaf_count().div_ceil(BLOCK_LEAVES) as usize;
        self.present.resize(blocks * self.words(), 0);
    }

    /// Assigns new cells to all draws, which takes time in proportion to their number. All leaves
    /// count as changed.
    fn lay_out(&mut self) {
        let blocks = self.leaf_count().div_ceil(BLOCK_LEAVES) as usize;
        self.present.clear();
        self.present.resize(blocks * self.words(), 0);
        self.buckets.iter_mut().for_each(|bucket| *bucket = Bucket::default());
        for leaf in (0..self.leaf_count()).map(LeafIndex) {
            let mut number = self.draws.first(leaf);
            while let Some(placed) = self.draws.at_mut(number) {
                (placed.leaf, placed.cell, number) = (leaf.0, NONE, placed.next);
                let bucket = placed.draw.bucket.0 as usize;
                self.buckets[bucket].push(leaf.0 / BLOCK_LEAVES);
                self.mark_present(leaf.0 / BLOCK_LEAVES, bucket);
            }
            self.changes.touch(leaf);
        }
        self.regions = Regions::default();
        for bucket in self.buckets.iter_mut().filter(|bucket| !bucket.spans.is_empty()) {
            let region = self.regions.enlarge(DrawRange::default(), bucket.wanted_cells());
            let spans = 0..bucket.spans.len();
            (bucket.region, bucket.filled) = (region, (0, 0));
            bucket.spread(0, spans, region);
        }
        // The number of cells never shrinks, since noted changes may name any of them.
        let count = self.cells.len().max(self.regions.end() as usize);
        self.cells.clear();
        self.cells.resize(count, NONE);
        // Any cell may hold an old command on the GPU.
        (0..self.cell_count()).for_each(|cell| self.changes.empty(cell));
        for leaf in (0..self.leaf_count()).map(LeafIndex) {
            let mut number = self.draws.first(leaf);
            while let Some(PlacedDraw { draw, next, .. }) = self.draws.at(number).copied() {
                let cell = self.buckets[draw.bucket.0 as usize].fill(leaf.0 / BLOCK_LEAVES);
                self.put(cell, number);
                number = next;
            }
        }
    }

    fn words(&self) -> usize {
        self.buckets.len().div_ceil(64)
    }

    /// Notes that a block has a draw in a bucket.
    fn mark_present(&mut self, block: u32, bucket: usize) {
        let word = block as usize * self.words() + bucket / 64;
        self.present[word] |= 1 << (bucket % 64);
    }

    fn placed_in(&self, cell: u32) -> Option<&PlacedDraw> {
        self.draws.at(*self.cells.get(cell as usize)?)
    }

    fn place_of(&self, number: u32) -> u32 {
        self.draws.at(number).map_or(DrawLink::NO_DRAW, |placed| placed.cell + 1)
    }

    /// Takes the draws of a leaf out of their cells, if they are in cells.
    fn lift_all(&mut self, leaf: LeafIndex) {
        let mut draw = self.draws.first(leaf);
        while let Some(placed) = self.draws.at(draw).copied() {
            self.lift(draw, &placed);
            draw = placed.next;
        }
        self.changes.touch(leaf);
    }

    /// Puts the draws of a leaf that are not in cells into cells.
    fn insert_all(&mut self, leaf: LeafIndex) {
        let mut draw = self.draws.first(leaf);
        while let Some(placed) = self.draws.at_mut(draw) {
            let next = placed.next;
            let is_placed = placed.cell != NONE;
            if !is_placed {
                placed.leaf = leaf.0;
                self.insert(draw);
            }
            draw = next;
        }
        self.changes.touch(leaf);
    }

    /// Takes a draw out of its cell, if it is in one, and closes the gap.
    fn lift(&mut self, draw: u32, placed: &PlacedDraw) {
        if placed.cell == NONE {
            return;
        }
        if let Some(lifted) = self.draws.at_mut(draw) {
            lifted.cell = NONE;
        }
        let bucket = placed.draw.bucket.0 as usize;
        let block = placed.leaf / BLOCK_LEAVES;
        let Some(span) = self.buckets[bucket].shrink(block) else { return };
        let end = span.start + span.len;
        for cell in placed.cell..end {
            self.put(cell, self.cells[cell as usize + 1]);
        }
        self.put(end, NONE);
        if span.len == 0 {
            let word = block as usize * self.words() + bucket / 64;
            self.present[word] &= !(1 << (bucket % 64));
        }
    }

    /// Puts a draw into a cell after the draws of its leaf and of the leaves before it.
    fn insert(&mut self, draw: u32) {
        let Some(&PlacedDraw { draw: BucketDraw { bucket, .. }, leaf, .. }) = self.draws.at(draw)
        else {
            return;
        };
        let bucket = bucket.0 as usize;
        let block = leaf / BLOCK_LEAVES;
        let place = self.buckets[bucket].find_or_add(block);
        if self.buckets[bucket].is_full(place) {
            self.make_room(bucket, place);
        }
        let span = self.buckets[bucket].spans[place];
        let cells = &self.cells[span.cells()];
        let is_before =
            |number: &u32| self.draws.at(*number).is_some_and(|placed| placed.leaf <= leaf);
        let before = cells.partition_point(is_before) as u32;
        for cell in (span.start + before..span.start + span.len).rev() {
            self.put(cell + 1, self.cells[cell as usize]);
        }
        self.put(span.start + before, draw);
        self.buckets[bucket].grow(place);
        self.mark_present(block, bucket);
    }

    /// Makes room for a draw in a full span: spreads the draws of the smallest group of neighbours
    /// that is loose enough, or moves the bucket to a larger region.
    fn make_room(&mut self, bucket: usize, place: usize) {
        if let Some((spans, to)) = self.buckets[bucket].loose_window(place) {
            self.lift_spans(bucket, spans.clone());
            self.spread(bucket, place, spans, to);
            return;
        }
        let all = 0..self.buckets[bucket].spans.len();
        let before = self.buckets[bucket].region;
        self.lift_spans(bucket, all.clone());
        let region = self.regions.enlarge(before, self.buckets[bucket].wanted_cells());
        let end = (region.first + region.count) as usize;
        self.cells.resize(self.cells.len().max(end), NONE);
        if region.first != before.first {
            let before = before.first as usize..(before.first + before.count) as usize;
            self.cells[before].fill(NONE);
        }
        // If the region belonged to another bucket, its old commands are still on the GPU.
        (region.first..region.first + region.count).for_each(|cell| self.changes.empty(cell));
        self.buckets[bucket].region = region;
        self.spread(bucket, place, all, region);
    }

    /// Collects the draws of some spans of a bucket in `moving`, in their order.
    fn lift_spans(&mut self, bucket: usize, spans: Range<usize>) {
        self.moving.clear();
        for span in &self.buckets[bucket].spans[spans] {
            self.moving.extend_from_slice(&self.cells[span.cells()]);
        }
    }

    /// Spreads the draws in `moving` over the cells `to` of some spans, with room for one more draw
    /// in the span `place`.
    fn spread(&mut self, bucket: usize, place: usize, spans: Range<usize>, to: DrawRange) {
        let moving = take(&mut self.moving);
        let mut spread = take(&mut self.spread);
        spread.clear();
        spread.resize(to.count as usize, NONE);
        let mut left = &moving[..];
        self.buckets[bucket].spread(place, spans.clone(), to);
        for span in &self.buckets[bucket].spans[spans] {
            let (draws, rest) = left.split_at(span.len as usize);
            let first = (span.start - to.first) as usize;
            spread[first..first + draws.len()].copy_from_slice(draws);
            left = rest;
        }
        for (cell, draw) in (to.first..).zip(&spread) {
            self.put(cell, *draw);
        }
        (self.moving, self.spread) = (moving, spread);
    }

    /// Writes a draw into a cell, or empties it.
    fn put(&mut self, cell: u32, draw: u32) {
        let Some(place) = self.cells.get_mut(cell as usize) else { return };
        if replace(place, draw) == draw {
            return;
        }
        self.changes.written += 1;
        match self.draws.at_mut(draw) {
            Some(placed) => {
                placed.cell = cell;
                self.changes.touch(LeafIndex(placed.leaf));
            }
            None => self.changes.empty(cell),
        }
    }
}
