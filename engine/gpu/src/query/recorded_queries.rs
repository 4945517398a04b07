//! The record of which queries of a frame were recorded. A query may be begun only once after its
//! reset, and the GPU would wait forever for the result of a query that was never begun.

use std::cell::Cell;
use std::ops::Range;

/// The queries of the frame being recorded, numbered from 0.
#[derive(Debug, Default)]
pub(crate) struct RecordedQueries {
    blocks: Vec<Cell<u64>>,
    count: u32,
}

impl RecordedQueries {
    /// Restarts with `count` queries, none of them recorded.
    pub(crate) fn restart(&mut self, count: u32) {
        self.blocks.clear();
        self.grow(count);
    }

    /// Continues with `count` queries in total.
    pub(crate) fn grow(&mut self, count: u32) {
        self.count = count;
        self.blocks.resize_with(count.div_ceil(u64::BITS) as usize, Cell::default);
    }

    pub(crate) fn count(&self) -> u32 {
        self.count
    }

    /// Notes that `query` is recorded; returns false if it was recorded before or does not exist.
    pub(crate) fn note(&self, query: u32) -> bool {
        let block = self.blocks.get((query / u64::BITS) as usize).filter(|_| query < self.count);
        let Some(block) = block else { return false };
        let bit = 1 << (query % u64::BITS);
        let before = block.replace(block.get() | bit);
        before & bit == 0
    }

    /// Returns true if all of `queries` were recorded.
    pub(crate) fn has_all(&self, mut queries: Range<u32>) -> bool {
        queries.all(|query| {
            let block = self.blocks.get((query / u64::BITS) as usize).map_or(0, Cell::get);
            block & (1 << (query % u64::BITS)) != 0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_query_is_noted_once_a_frame() {
        let mut recorded = RecordedQueries::default();
        recorded.restart(130);
        assert!(recorded.has_all(0..0) && !recorded.has_all(0..1));
        assert!((0..130).rev().all(|query| recorded.note(query)));
        assert!(recorded.has_all(0..130) && !recorded.has_all(129..131));
        assert!(!recorded.note(0) && !recorded.note(129) && !recorded.note(130));
        recorded.grow(300);
        assert!(recorded.has_all(0..130) && !recorded.has_all(130..131) && !recorded.note(64));
        assert!(recorded.note(299) && !recorded.note(299));
        recorded.restart(3);
        assert!(!recorded.has_all(2..3) && recorded.note(2) && recorded.has_all(2..3));
    }
}
