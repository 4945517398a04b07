//! The cells of one bucket: a span per block of leaves, in a region of its own.

use std::ops::Range;

use gpu::DrawRange;

use super::BLOCK_LEAVES;

/// The lowest number of cells of a bucket with draws.
pub(super) const LEAST_CELLS: u32 = 8;

/// Returns a number of cells of which `draws` draws leave two fifths empty.
pub(super) fn wanted_cells(draws: u32) -> u32 {
    (u64::from(draws) * 5 / 3).min(u64::from(u32::MAX)) as u32
}

/// The cells of a bucket.
#[derive(Default)]
pub(super) struct Bucket {
    pub(super) region: DrawRange,
    /// The spans of blocks that ever had a draw, in the order of the blocks and of the cells.
    pub(super) spans: Vec<Span>,
    /// The number of draws.
    draws: u32,
    /// The span that is being [filled](Bucket::fill), and the number of its draws placed so far.
    pub(super) filled: (usize, u32),
}

/// The cells of a block up to the next span. Cells with draws come first.
#[derive(Clone, Copy)]
pub(super) struct Span {
    block: u32,
    pub(super) start: u32,
    pub(super) len: u32,
}

impl Span {
    /// Returns the cells with draws.
    pub(super) fn cells(&self) -> Range<usize> {
        self.start as usize..(self.start + self.len) as usize
    }
}

impl Bucket {
    /// Removes a draw from the span of a block. Returns the shortened span, if the block has one.
    pub(super) fn shrink(&mut self, block: u32) -> Option<Span> {
        let place = self.spans.binary_search_by_key(&block, |span| span.block).ok()?;
        let span = self.spans.get_mut(place)?;
        span.len -= 1;
        self.draws -= 1;
        Some(*span)
    }

    /// Adds a draw to a span that is not full.
    pub(super) fn grow(&mut self, place: usize) {
        self.spans[place].len += 1;
        self.draws += 1;
    }

    /// Counts a draw of a block. Blocks come in ascending order.
    pub(super) fn push(&mut self, block: u32) {
        if self.spans.last().is_none_or(|last| last.block != block) {
            self.spans.push(Span { block, start: 0, len: 0 });
        }
        self.grow(self.spans.len() - 1);
    }

    /// Returns the cell of the next draw of a block whose draws were counted.
    pub(super) fn fill(&mut self, block: u32) -> u32 {
        let (mut place, mut placed) = self.filled;
        if self.spans[place].block != block {
            (place, placed) = (place + 1, 0);
        }
        self.filled = (place, placed + 1);
        self.spans[place].start + placed
    }

    /// Returns the index of the span of a block. A new span has no cells.
    pub(super) fn find_or_add(&mut self, block: u32) -> usize {
        match self.spans.binary_search_by_key(&block, |span| span.block) {
            Ok(place) => place,
            Err(place) => {
                let start = self.spans.get(place).map_or(self.end(), |next| next.start);
                self.spans.insert(place, Span { block, start, len: 0 });
                place
            }
        }
    }

    /// Returns true if a span has no empty cell.
    pub(super) fn is_full(&self, place: usize) -> bool {
        let span = self.spans[place];
        span.start + span.len == self.end_of(place)
    }

    /// Returns the smallest group of spans around `place` that is loose enough for one more draw,
    /// and its cells. A larger group must be looser, so that it stays loose for a while. Returns
    /// `None` if even the whole bucket is not loose enough.
    pub(super) fn loose_window(&self, place: usize) -> Option<(Range<usize>, DrawRange)> {
        let height = self.spans.len().next_power_of_two().ilog2().max(1);
        (1..=height).find_map(|level| {
            let first = place >> level << level;
            let spans = first..(first + (1 << level)).min(self.spans.len());
            let start = if first == 0 { self.region.first } else { self.spans[first].start };
            let cells = DrawRange { first: start, count: self.end_of(spans.end - 1) - start };
            let used = 1 + self.spans[spans.clone()].iter().map(|span| span.len).sum::<u32>();
            // The smallest groups may be full, the whole bucket only to three quarters.
            let limit = cells.count - cells.count / 4 * level / height;
            (used <= limit).then_some((spans, cells))
        })
    }

    /// Returns a number of cells of which one more draw leaves two fifths empty.
    pub(super) fn wanted_cells(&self) -> u32 {
        wanted_cells(self.draws + 1).max(LEAST_CELLS)
    }

    /// Moves spans into the cells `to`. Empty cells are shared out evenly, with one more for
    /// `place`.
    pub(super) fn spread(&mut self, place: usize, spans: Range<usize>, to: DrawRange) {
        let used = 1 + self.spans[spans.clone()].iter().map(|span| span.len).sum::<u32>();
        let empty = to.count.saturating_sub(used);
        let count = spans.len() as u32;
        let mut start = to.first;
        for (number, span) in (0..).zip(&mut self.spans[spans.clone()]) {
            span.start = start;
            let share = empty / count + u32::from(number < empty % count);
            start += span.len + share + u32::from(spans.start + number as usize == place);
        }
    }

    /// Returns the cells from the first to the last draw of some leaves; `leaf_of` returns the leaf
    /// of a cell.
    pub(super) fn range(
        &self,
        leaves: Range<u32>,
        leaf_of: impl Fn(u32) -> u32,
    ) -> Option<DrawRange> {
        let block = |leaf: u32| leaf / BLOCK_LEAVES;
        let first = self.spans.partition_point(|span| span.block < block(leaves.start));
        let end = self.spans.partition_point(|span| span.block <= block(leaves.end - 1));
        let spans = &self.spans[first..end];
        // The number of draws in a span that come before the draws of a leaf.
        let before = |span: &Span, leaf: u32| match span.block * BLOCK_LEAVES {
            start if start >= leaf => 0,
            start if start + BLOCK_LEAVES <= leaf => span.len,
            _ => span.partition(|cell| leaf_of(cell) < leaf),
        };
        let inside = |span: &Span| {
            let [first, end] = [leaves.start, leaves.end].map(|leaf| before(span, leaf));
            (first < end).then_some([span.start + first, span.start + end])
        };
        let [first, _] = spans.iter().find_map(inside)?;
        let [_, end] = spans.iter().rev().find_map(inside)?;
        Some(DrawRange { first, count: end - first })
    }

    fn end(&self) -> u32 {
        self.region.first + self.region.count
    }

    fn end_of(&self, place: usize) -> u32 {
        self.spans.get(place + 1).map_or(self.end(), |next| next.start)
    }
}

impl Span {
    /// Returns the number of draws up to the first for which `is_before` does not hold.
    fn partition(&self, is_before: impl Fn(u32) -> bool) -> u32 {
        let mut low = 0;
        let mut high = self.len;
        while low < high {
            let middle = (low + high) / 2;
            if is_before(self.start + middle) { low = middle + 1 } else { high = middle }
        }
        low
    }
}
