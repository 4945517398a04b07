//! Cells against a model that keeps nothing but a list of draws per object.

use super::*;

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % end.max(1) as u64) as usize
    }
}

/// The cells, the draws that they should hold, and a copy that is updated by the noted changes, as
/// on the GPU.
struct Model {
    random: Random,
    buckets: usize,
    cells: BucketCells,
    draws: Vec<Vec<BucketDraw>>,
    objects: Vec<ObjectId>,
    copied: Vec<(IndirectDraw, DrawLink)>,
    copied_firsts: Vec<u32>,
    serial: u32,
    /// The number of draws that were added, removed or moved to other leaves.
    moves: u64,
}

impl Model {
    fn new(seed: u64, leaf_count: usize, buckets: usize) -> Self {
        let objects: Vec<ObjectId> = (0..leaf_count as u32).map(ObjectId).collect();
        Self {
            random: Random(seed),
            buckets,
            cells: BucketCells::new(buckets as u32, &objects),
            draws: vec![Vec::new(); leaf_count],
            objects,
            copied: Vec::new(),
            copied_firsts: vec![DrawLink::NO_DRAW; leaf_count],
            serial: 0,
            moves: 0,
        }
    }

    fn some_draws(&mut self) -> Vec<BucketDraw> {
        let count = [0, 1, 1, 1, 2, 3, 7][self.random.below(7)];
        let draw = |model: &mut Self| {
            model.serial += 1;
            let bucket = BucketId(model.random.below(model.buckets) as u32);
            let instance_count = model.random.below(5) as u32;
            let draw = IndirectDraw {
                index_count: 3,
                instance_count,
                first_index: model.serial,
                ..Default::default()
            };
            BucketDraw { bucket, draw, triangles: model.serial % 100 }
        };
        (0..count).map(|_| draw(self)).collect()
    }

    fn change(&mut self) {
        let leaves = self.objects.len();
        match self.random.below(20) {
            0 => {
                let first = self.random.below(leaves);
                let count = self.random.below((leaves - first).min(90) + 1);
                let part = first..first + count;
                for place in part.clone().rev() {
                    let with = first + self.random.below(place - first + 1);
                    self.objects.swap(place, with);
                }
                self.moves += part.clone().map(|leaf| self.listed(leaf).len() as u64).sum::<u64>();
                let range = |part: Range<usize>| LeafRange {
                    first: LeafIndex(part.start as u32),
                    count: part.len() as u32,
                };
                // A subtree that is rebuilt, and others in it before and after.
                let inner = [first + count / 3..first + count / 2, first + count / 2..part.end];
                let ranges = [range(inner[0].clone()), range(part), range(inner[1].clone())];
                self.cells.reorder(&ranges, &self.objects);
            }
            1 if leaves > 1 && self.random.below(4) == 0 => {
                // Enough changes to lay out everything anew.
                let first = self.random.below(leaves / 2);
                let count = leaves / 8 + 2 + self.random.below(leaves);
                let changed = first..(first + count).min(leaves);
                let draws: Vec<_> = changed.clone().map(|_| self.some_draws()).collect();
                let listed = (first as u32..).map(LeafIndex).zip(draws.iter().map(Vec::as_slice));
                self.cells.replace(&listed.collect::<Vec<_>>());
                for (leaf, draws) in changed.zip(draws) {
                    self.draws[self.objects[leaf].0 as usize] = draws;
                }
                self.moves += (0..leaves).map(|leaf| self.listed(leaf).len() as u64).sum::<u64>();
            }
            1 => {
                // Several leaves in a row, as when an owner adds objects in bulk.
                let first = self.random.below(leaves);
                for leaf in first..(first + 40).min(leaves) {
                    let draws = self.some_draws();
                    self.replace(leaf, draws);
                }
            }
            2..8 => {
                let leaf = self.random.below(leaves);
                self.replace(leaf, Vec::new());
            }
            8..10 => {
                // The same buckets, other commands.
                let leaf = self.random.below(leaves);
                let mut draws = self.draws[self.objects[leaf].0 as usize].clone();
                for draw in &mut draws {
                    self.serial += 1;
                    draw.draw.first_index = self.serial;
                }
                self.replace(leaf, draws);
            }
            _ => {
                let leaf = self.random.below(leaves);
                let draws = self.some_draws();
                self.replace(leaf, draws);
            }
        }
    }

    fn replace(&mut self, leaf: usize, draws: Vec<BucketDraw>) {
        self.moves += (self.listed(leaf).len() + draws.len()) as u64;
        self.cells.replace(&[(LeafIndex(leaf as u32), &draws)]);
        self.draws[self.objects[leaf].0 as usize] = draws;
    }

    /// Adds leaves to the last subtree, which is rebuilt.
    fn grow(&mut self, more: usize) {
        let before = self.objects.len();
        let first = before.saturating_sub(50);
        self.objects.extend((before as u32..).take(more).map(ObjectId));
        self.objects[first..].reverse();
        self.draws.resize(before + more, Vec::new());
        let count = (before + more - first) as u32;
        let last = LeafRange { first: LeafIndex(first as u32), count };
        self.cells.reorder(&[last], &self.objects);
        self.copied_firsts.resize(before + more, 7);
    }

    /// Returns the draws of a leaf that draw something, by bucket.
    fn listed(&self, leaf: usize) -> Vec<BucketDraw> {
        let mut draws = self.draws[self.objects[leaf].0 as usize].clone();
        draws.retain(|draw| draw.draw.instance_count > 0);
        draws.sort_by_key(|draw| draw.bucket);
        draws
    }

    /// Copies the noted changes.
    fn copy(&mut self) {
        let rubbish = IndirectDraw { index_count: 9, instance_count: 9, ..Default::default() };
        self.copied.resize(self.cells.cell_count() as usize, (rubbish, DrawLink::EMPTY));
        let mut changes = std::mem::take(&mut self.cells.changes);
        let mut copy = |cell: u32| {
            self.copied[cell as usize] = (self.cells.command(cell), self.cells.link(cell));
        };
        changes.take_emptied(&mut copy);
        changes.take_leaves(|leaf| {
            self.copied_firsts[leaf.0 as usize] = self.cells.first(leaf);
            self.cells.cells_of(leaf).for_each(|(_, cell)| copy(cell));
        });
        self.cells.changes = changes;
    }

    /// Compares the copy with the draws of single leaves and of ranges.
    fn check(&mut self) {
        self.copy();
        for leaf in 0..self.objects.len() {
            let mut cell = self.copied_firsts[leaf];
            let index = LeafIndex(leaf as u32);
            for draw in self.listed(leaf) {
                let (command, link) = self.copied[cell as usize - 1];
                assert_eq!(command, draw.draw, "leaf {leaf}");
                assert_eq!(link.instance_count, draw.draw.instance_count);
                cell = link.next;
            }
            assert_eq!(cell, DrawLink::NO_DRAW, "leaf {leaf} has no more");
            let triangles =
                self.listed(leaf).iter().map(|listed| u64::from(listed.triangles)).sum();
            let draws = self.listed(leaf).len() as u64;
            assert_eq!(self.cells.count(index), LeafCount { draws, triangles });
        }
        for _ in 0..20 {
            let first = self.random.below(self.objects.len());
            let count = self.random.below(self.objects.len() - first + 1);
            self.check_range(first..first + count);
        }
    }

    fn check_range(&self, leaves: Range<usize>) {
        let first = LeafIndex(leaves.start as u32);
        let count = leaves.len() as u32;
        let all: Vec<BucketDraw> = leaves.flat_map(|leaf| self.listed(leaf)).collect();
        let mut found = Vec::new();
        self.cells.ranges(LeafRange { first, count }, |bucket, cells| {
            found.push(bucket);
            let cells = cells.first as usize..(cells.first + cells.count) as usize;
            let ends = [cells.start, cells.end - 1].map(|end| self.copied[end].0.instance_count);
            assert!(ends.iter().all(|count| *count > 0), "the range ends with draws");
            let drawn = self.copied[cells]
                .iter()
                .map(|copied| copied.0)
                .filter(|copied| copied.instance_count > 0);
            let wanted = all.iter().filter(|draw| draw.bucket == bucket).map(|draw| draw.draw);
            assert!(drawn.eq(wanted), "{first:?} {count} in {bucket:?}");
        });
        let mut buckets: Vec<BucketId> = all.iter().map(|draw| draw.bucket).collect();
        buckets.sort_unstable();
        buckets.dedup();
        assert_eq!(found, buckets);
    }
}

#[test]
fn every_range_holds_the_draws_of_its_leaves_in_their_order_through_any_changes() {
    for (seed, buckets) in (0..60).zip([1, 16, 256].into_iter().cycle()) {
        let leaf_count = [1, 63, 64, 65, 700][seed as usize % 5];
        let mut model = Model::new(seed, leaf_count, buckets);
        for round in 0..12 {
            for _ in 0..leaf_count.min(80) {
                model.change();
            }
            model.check();
            if round == 8 {
                model.grow(70);
                model.check();
            }
        }
    }
}

#[test]
fn the_work_of_a_change_is_bounded_and_so_is_the_room() {
    for buckets in [1, 16, 256] {
        let mut model = Model::new(3, 5_000, buckets);
        for leaf in 0..5_000 {
            let draws = model.some_draws();
            model.replace(leaf, draws);
        }
        let filled = (model.cells.changes.written, model.moves);
        for _ in 0..5_000 {
            model.change();
        }
        // Measured: 8 to 43 cells per draw while filling in order, and 7 to 30 afterwards.
        let per_draw = |written: u64, draws: u64| written / draws.max(1);
        let changed = (model.cells.changes.written - filled.0, model.moves - filled.1);
        let work = [per_draw(filled.0, filled.1), per_draw(changed.0, changed.1)];
        assert!(work.iter().all(|cells| *cells < 100), "{buckets} buckets: {work:?}");
        let draws: usize = (0..5_000).map(|leaf| model.listed(leaf).len()).sum();
        let room = model.cells.cell_count() as usize;
        assert!(room < 4 * draws + 16 * buckets, "{buckets} buckets: {room} cells, {draws} draws");
        println!("{buckets}: {work:?} {room} {draws}");
        model.check();
    }
}

#[test]
fn a_steady_replacement_writes_nothing_but_its_own_cells() {
    let mut model = Model::new(5, 500, 16);
    (0..2_000).for_each(|_| model.change());
    model.copy();
    let written = model.cells.changes.written;
    let leaf = (0..500).find(|leaf| model.listed(*leaf).len() > 1).unwrap();
    let mut draws = model.draws[model.objects[leaf].0 as usize].clone();
    draws.iter_mut().for_each(|draw| draw.draw.vertex_offset += 1);
    model.replace(leaf, draws);
    assert_eq!(model.cells.changes.written, written);
    let mut changed = Vec::new();
    model.cells.changes.take_leaves(|leaf| changed.push(leaf.0 as usize));
    assert_eq!(changed, [leaf]);
    model.cells.changes.take_emptied(|cell| panic!("cell {cell} was emptied"));
}
