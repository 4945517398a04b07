//! The regions of buckets among all cells.

use gpu::DrawRange;

/// The cells that no bucket uses.
#[derive(Default)]
pub(super) struct Regions {
    /// Unused ranges, in order; adjacent ranges are merged.
    free: Vec<DrawRange>,
    /// The end of all regions that were ever taken.
    end: u32,
}

impl Regions {
    /// Returns the end of all regions that were ever taken.
    pub(super) fn end(&self) -> u32 {
        self.end
    }

    /// Replaces a region by a larger one, which begins at the same place if it was the last region.
    pub(super) fn enlarge(&mut self, before: DrawRange, count: u32) -> DrawRange {
        if before.first + before.count == self.end {
            self.end = before.first + count;
            return DrawRange { first: before.first, count };
        }
        let taken = self.take(count);
        self.free(before);
        taken
    }

    /// Takes the first free range that is large enough, or a new range at the end.
    fn take(&mut self, count: u32) -> DrawRange {
        let Some(place) = self.free.iter().position(|free| free.count >= count) else {
            let first = self.end;
            self.end += count;
            return DrawRange { first, count };
        };
        let free = &mut self.free[place];
        let taken = DrawRange { first: free.first, count };
        (free.first, free.count) = (free.first + count, free.count - count);
        if free.count == 0 {
            self.free.remove(place);
        }
        taken
    }

    fn free(&mut self, region: DrawRange) {
        if region.count == 0 {
            return;
        }
        let place = self.free.partition_point(|free| free.first < region.first);
        self.free.insert(place, region);
        self.free.dedup_by(|next, kept| {
            let meets = kept.first + kept.count == next.first;
            kept.count += if meets { next.count } else { 0 };
            meets
        });
    }
}
