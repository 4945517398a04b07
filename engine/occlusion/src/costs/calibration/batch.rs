//! The batches that are timed: many items of one kind and little else.

use cull::{SkipTimes, VisibilityTest};
use gpu::PredicationMode;

use crate::costs::box_bench::{BenchItem, BoxSize, PredicateResult};

/// A number of items of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Batch {
    pub(super) item: BenchItem,
    pub(super) count: u32,
}

impl Batch {
    pub(super) const DRAWS: Self = Self::of(BenchItem::Draws { per_call: u32::MAX }, 256);
    pub(super) const PATCHES: Self = Self::of(BenchItem::Patches, 24);
    pub(super) const QUERIES: Self = Self::of(BenchItem::QueriedDraws, 48);
    pub(super) const QUERIED_BOXES: Self =
        Self::of(BenchItem::Boxes(VisibilityTest::Query, BoxSize::Small), 48);
    pub(super) const FLAGS: Self =
        Self::of(BenchItem::Boxes(VisibilityTest::Flag, BoxSize::Small), 256);
    pub(super) const HIDDEN_PIXELS: Self =
        Self::of(BenchItem::Boxes(VisibilityTest::Flag, BoxSize::Large), 8);
    pub(super) const FLAGGED_PIXELS: Self = Self::of(BenchItem::VisibleBoxes, 2);
    pub(super) const CALLS: Self = Self::of(BenchItem::EmptyCalls, 256);
    pub(super) const NOTHING: Self = Self::of(BenchItem::Nothing, 0);
    pub(super) const BREAKS: Self = Self::of(BenchItem::Breaks, 4);
    pub(super) const GRIDS: Self = Self::of(BenchItem::Grids, 1);
    pub(super) const COMPUTED_BOXES: Self =
        Self::of(BenchItem::Boxes(VisibilityTest::Compute, BoxSize::Small), 128);

    pub(super) const ALL: [Self; 11] = [
        Self::DRAWS,
        Self::PATCHES,
        Self::QUERIES,
        Self::QUERIED_BOXES,
        Self::FLAGS,
        Self::HIDDEN_PIXELS,
        Self::FLAGGED_PIXELS,
        Self::CALLS,
        Self::BREAKS,
        Self::GRIDS,
        Self::COMPUTED_BOXES,
    ];

    /// The most of an item in a batch, and the most draws of its ranges.
    pub(super) const MOST: u32 = SkipTimes::RANGES * SkipTimes::WIDE_DRAWS;

    const fn of(item: BenchItem, count: u32) -> Self {
        Self { item, count }
    }

    /// Returns the batches that measure an executor: few ranges, many ranges, and few wide ranges.
    pub(super) fn of_ranges(executor: PredicationMode) -> [Self; 3] {
        let few = SkipTimes::RANGES;
        let result = PredicateResult::Skipped;
        [(few, 1), (2 * few, 1), (few, SkipTimes::WIDE_DRAWS)]
            .map(|(count, width)| Self::of(BenchItem::Ranges { executor, width, result }, count))
    }

    pub(super) fn doubled(self) -> Self {
        Self { count: 2 * self.count, ..self }
    }
}
