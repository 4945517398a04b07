//! The draws of leaves that have any number of them, each in a bucket: a pipeline in a pass.
//!
//! A *cell* is the place of one indirect command. The cells of a bucket lie in the order of the
//! leaves of their draws, so that the draws of a subtree are one contiguous range per bucket. Empty
//! cells between them make room: leaves are taken in blocks, and each block has a span of cells per
//! bucket that it uses. A change shifts cells of its span. A full span takes room from its
//! neighbours: a packed-memory array (Bender, Demaine and Farach-Colton 2000, "Cache-Oblivious
//! B-Trees").

mod bucket;
mod cell_changes;
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
use regions::Regions;

/// A pipeline in a pass, in which draws of objects are drawn together. Buckets are drawn in the
/// order of their numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BucketId(pub u32);

/// A draw of an object. One without indices or instances draws nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BucketDraw {
    /// The bucket that it is drawn in.
    pub bucket: BucketId,
    /// The command, of any number of instances.
    pub draw: IndirectDraw,
    /// The number of triangles of all instances.
    pub triangles: u32,
}

/// The number of leaves that share a span per bucket.
const BLOCK_LEAVES: u32 = 64;

/// The end of a list, and the content of an empty cell.
const NONE: u32 = u32::MAX;

/// A draw at its place.
#[derive(Clone, Copy)]
struct PlacedDraw {
    draw: BucketDraw,
    leaf: u32,
    /// The next draw of the same object, of the same bucket or a later one.
    next: u32,
    cell: u32,
}

/// The draws of all leaves in cells.
pub(crate) struct BucketCells {
    draws: Vec<PlacedDraw>,
    /// The first unused place in `draws`; the others follow by `next`.
    unused: u32,
    /// The first draw of each object.
    firsts: Vec<u32>,
    /// The object of each leaf.
    objects: Vec<ObjectId>,
    buckets: Vec<Bucket>,
    /// A bit per block and bucket: set if the block has a draw in the bucket.
    present: Vec<u64>,
    /// The draw in each cell.
    cells: Vec<u32>,
    regions: Regions,
    pub(crate) changes: CellChanges,
    /// Draws on their way from old cells to new ones; kept to allocate nothing.
    moving: Vec<u32>,
    spread: Vec<u32>,
    listed: Vec<(BucketId, u32)>,
}

impl BucketCells {
    /// Creates the cells of leaves with these objects, without draws.
    pub(crate) fn new(bucket_count: u32, objects: &[ObjectId]) -> Self {
        let mut cells = Self {
            draws: Vec::new(),
            unused: NONE,
            firsts: Vec::new(),
            objects: Vec::new(),
            buckets: (0..bucket_count).map(|_| Bucket::default()).collect(),
            present: Vec::new(),
            cells: Vec::new(),
            regions: Regions::default(),
            changes: CellChanges::default(),
            moving: Vec::new(),
            spread: Vec::new(),
            listed: Vec::new(),
        };
        cells.resize(objects);
        cells
    }

    /// Returns the number of buckets.
    pub(crate) fn bucket_count(&self) -> u32 {
        self.buckets.len() as u32
    }

    /// Returns the number of leaves.
    pub(crate) fn leaf_count(&self) -> u32 {
        self.objects.len() as u32
    }

    /// Returns the number of cells, empty ones included.
    pub(crate) fn cell_count(&self) -> u32 {
        self.cells.len() as u32
    }

    /// Returns the command in a cell; an empty one where there is no draw.
    pub(crate) fn command(&self, cell: u32) -> IndirectDraw {
        self.placed_in(cell).map(|it| it.draw.draw).unwrap_or_default()
    }

    /// Returns the link of a cell to the next of its leaf.
    pub(crate) fn link(&self, cell: u32) -> DrawLink {
        let link = |placed: &PlacedDraw| DrawLink {
            next: self.place_of(placed.next),
            instance_count: placed.draw.draw.instance_count,
        };
        self.placed_in(cell).map_or(DrawLink::EMPTY, link)
    }

    /// Returns one more than the first cell of a leaf, or [`DrawLink::NO_DRAW`].
    pub(crate) fn first(&self, leaf: LeafIndex) -> u32 {
        self.place_of(self.first_draw(leaf))
    }

    /// Returns the cells of a leaf, in the order of their buckets.
    pub(crate) fn cells_of(&self, leaf: LeafIndex) -> impl Iterator<Item = (BucketId, u32)> {
        self.placed_of(leaf).map(|placed| (placed.draw.bucket, placed.cell))
    }

    /// Counts the draws of a leaf.
    pub(crate) fn count(&self, leaf: LeafIndex) -> LeafCount {
        self.placed_of(leaf).fold(LeafCount::default(), |sum, placed| LeafCount {
            draws: sum.draws + 1,
            triangles: sum.triangles + u64::from(placed.draw.triangles),
        })
    }

    /// Calls `each` with the cells of a range of leaves, once per bucket with draws there, in the
    /// order of the buckets. Some of the cells may be empty.
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
                let leaf_of = |cell: u32| self.placed_in(cell).map_or(NONE, |it| it.leaf);
                if let Some(range) = self.buckets[bucket].range(leaves.first.0..last + 1, leaf_of) {
                    each(BucketId(bucket as u32), range);
                }
            }
        }
    }

    /// Replaces the draws of the object in a leaf, whose buckets exist.
    pub(crate) fn replace(&mut self, leaf: LeafIndex, draws: &[BucketDraw]) {
        let mut listed = take(&mut self.listed);
        let drawn = |it: &&BucketDraw| it.draw.index_count > 0 && it.draw.instance_count > 0;
        listed.clear();
        listed.extend((0..).zip(draws).filter(|it| drawn(&it.1)).map(|it| (it.1.bucket, it.0)));
        listed.sort_unstable();
        let before = self.placed_of(leaf).map(|placed| placed.draw.bucket);
        if before.eq(listed.iter().map(|it| it.0)) {
            let mut place = self.first_draw(leaf);
            for (_, number) in &listed {
                let placed = &mut self.draws[place as usize];
                placed.draw = draws[*number as usize];
                place = placed.next;
            }
            self.changes.touch(leaf);
        } else {
            self.lift_all(leaf);
            self.free_all(leaf);
            for (_, number) in listed.iter().rev() {
                self.push_front(leaf, draws[*number as usize]);
            }
            self.insert_all(leaf);
        }
        self.listed = listed;
    }

    /// Notes that the objects in some ranges of leaves are in another order now, which is that of
    /// `objects`, by leaf. Ranges may lie in each other, as subtrees do.
    pub(crate) fn reorder(&mut self, ranges: &[LeafRange], objects: &[ObjectId]) {
        let leaves = || ranges.iter().flat_map(|range| range.iter());
        leaves().for_each(|leaf| self.lift_all(leaf));
        for range in ranges.iter().map(|range| range.indices()) {
            if let (Some(to), Some(from)) =
                (self.objects.get_mut(range.clone()), objects.get(range))
            {
                to.copy_from_slice(from);
            }
        }
        leaves().for_each(|leaf| self.insert_all(leaf));
    }

    /// Notes that there is another number of leaves, with these objects. Objects keep their draws;
    /// one that is not among them loses them. All leaves count as changed.
    pub(crate) fn resize(&mut self, objects: &[ObjectId]) {
        for leaf in (0..self.objects.len() as u32).map(LeafIndex) {
            if self.object_of(leaf).is_none_or(|object| object >= objects.len()) {
                self.free_all(leaf);
            }
        }
        self.firsts.resize(objects.len(), NONE);
        self.objects.clear();
        self.objects.extend_from_slice(objects);
        let blocks = (objects.len() as u32).div_ceil(BLOCK_LEAVES) as usize;
        self.present.clear();
        self.present.resize(blocks * self.words(), 0);
        self.buckets.iter_mut().for_each(|bucket| *bucket = Bucket::default());
        self.cells.clear();
        self.regions = Regions::default();
        self.changes.resize(objects.len());
        self.draws.iter_mut().for_each(|placed| placed.cell = NONE);
        (0..objects.len() as u32).for_each(|leaf| self.insert_all(LeafIndex(leaf)));
    }

    fn words(&self) -> usize {
        self.buckets.len().div_ceil(64)
    }

    fn placed_in(&self, cell: u32) -> Option<&PlacedDraw> {
        self.draws.get(*self.cells.get(cell as usize)? as usize)
    }

    fn place_of(&self, draw: u32) -> u32 {
        self.draws.get(draw as usize).map_or(DrawLink::NO_DRAW, |placed| placed.cell + 1)
    }

    fn object_of(&self, leaf: LeafIndex) -> Option<usize> {
        self.objects.get(leaf.0 as usize).map(|object| object.0 as usize)
    }

    fn first_draw(&self, leaf: LeafIndex) -> u32 {
        let first = self.object_of(leaf).and_then(|object| self.firsts.get(object));
        first.copied().unwrap_or(NONE)
    }

    fn set_first_draw(&mut self, leaf: LeafIndex, draw: u32) {
        if let Some(object) = self.object_of(leaf)
            && let Some(first) = self.firsts.get_mut(object)
        {
            *first = draw;
        }
    }

    fn placed_of(&self, leaf: LeafIndex) -> impl Iterator<Item = &PlacedDraw> {
        let at = |draw: u32| self.draws.get(draw as usize);
        std::iter::successors(at(self.first_draw(leaf)), move |placed| at(placed.next))
    }

    /// Puts a draw before the others of a leaf, in no cell yet.
    fn push_front(&mut self, leaf: LeafIndex, draw: BucketDraw) {
        let next = self.first_draw(leaf);
        let placed = PlacedDraw { draw, leaf: leaf.0, next, cell: NONE };
        let number = match self.draws.get_mut(self.unused as usize) {
            Some(place) => {
                let unused = replace(place, placed).next;
                replace(&mut self.unused, unused)
            }
            None => {
                self.draws.push(placed);
                self.draws.len() as u32 - 1
            }
        };
        self.set_first_draw(leaf, number);
    }

    /// Forgets the draws of a leaf, which are in no cell.
    fn free_all(&mut self, leaf: LeafIndex) {
        let mut draw = self.first_draw(leaf);
        while let Some(placed) = self.draws.get_mut(draw as usize) {
            let next = replace(&mut placed.next, self.unused);
            self.unused = replace(&mut draw, next);
        }
        self.set_first_draw(leaf, NONE);
    }

    /// Takes the draws of a leaf out of their cells, those that are in some.
    fn lift_all(&mut self, leaf: LeafIndex) {
        let mut draw = self.first_draw(leaf);
        while let Some(placed) = self.draws.get(draw as usize).copied() {
            self.lift(draw, &placed);
            draw = placed.next;
        }
        self.changes.touch(leaf);
    }

    /// Puts the draws of a leaf into cells, those that are in none.
    fn insert_all(&mut self, leaf: LeafIndex) {
        let mut draw = self.first_draw(leaf);
        while let Some(placed) = self.draws.get_mut(draw as usize) {
            let (next, is_placed) = (placed.next, placed.cell != NONE);
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
        self.draws[draw as usize].cell = NONE;
        let (bucket, block) = (placed.draw.bucket.0 as usize, placed.leaf / BLOCK_LEAVES);
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

    /// Puts a draw into a cell behind those of its leaf and of the leaves before.
    fn insert(&mut self, draw: u32) {
        let PlacedDraw { draw: BucketDraw { bucket, .. }, leaf, .. } = self.draws[draw as usize];
        let (bucket, block) = (bucket.0 as usize, leaf / BLOCK_LEAVES);
        let place = self.buckets[bucket].find_or_add(block);
        if self.buckets[bucket].is_full(place) {
            self.make_room(bucket, place);
        }
        let span = self.buckets[bucket].spans[place];
        let cells = &self.cells[span.cells()];
        let before = cells.partition_point(|it| self.draws[*it as usize].leaf <= leaf) as u32;
        for cell in (span.start + before..span.start + span.len).rev() {
            self.put(cell + 1, self.cells[cell as usize]);
        }
        self.put(span.start + before, draw);
        self.buckets[bucket].grow(place);
        let word = block as usize * self.words() + bucket / 64;
        self.present[word] |= 1 << (bucket % 64);
    }

    /// Makes room for a draw in a full span: spreads those of its neighbours, as few as are loose
    /// enough, or moves the bucket to a larger region.
    fn make_room(&mut self, bucket: usize, place: usize) {
        if let Some((spans, to)) = self.buckets[bucket].loose_window(place) {
            self.lift_spans(bucket, spans.clone());
            self.spread(bucket, (place, spans), to);
            return;
        }
        let (all, before) = (0..self.buckets[bucket].spans.len(), self.buckets[bucket].region);
        self.lift_spans(bucket, all.clone());
        let region = self.regions.enlarge(before, self.buckets[bucket].wanted_cells());
        let end = (region.first + region.count) as usize;
        self.cells.resize(self.cells.len().max(end), NONE);
        if region.first != before.first {
            let before = before.first as usize..(before.first + before.count) as usize;
            self.cells[before].fill(NONE);
        }
        // Where the region belonged to another bucket, its old commands are still on the GPU.
        (region.first..region.first + region.count).for_each(|cell| self.changes.empty(cell));
        self.buckets[bucket].region = region;
        self.spread(bucket, (place, all), region);
    }

    /// Notes the draws of some spans of a bucket in `moving`, in their order.
    fn lift_spans(&mut self, bucket: usize, spans: Range<usize>) {
        self.moving.clear();
        for span in &self.buckets[bucket].spans[spans] {
            self.moving.extend_from_slice(&self.cells[span.cells()]);
        }
    }

    /// Spreads the draws in `moving` over cells as those of spans, with room for one more in the
    /// span `place`.
    fn spread(&mut self, bucket: usize, (place, spans): (usize, Range<usize>), to: DrawRange) {
        let (moving, mut spread) = (take(&mut self.moving), take(&mut self.spread));
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

    /// Writes a draw, or none, into a cell.
    fn put(&mut self, cell: u32, draw: u32) {
        let Some(place) = self.cells.get_mut(cell as usize) else { return };
        if replace(place, draw) == draw {
            return;
        }
        self.changes.written += 1;
        match self.draws.get_mut(draw as usize) {
            Some(placed) => {
                placed.cell = cell;
                self.changes.touch(LeafIndex(placed.leaf));
            }
            None => self.changes.empty(cell),
        }
    }
}
