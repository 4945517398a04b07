//! Counts of the draws and triangles in a range of leaves, kept while leaves change by a tree of
//! partial sums (Fenwick 1994, "A New Data Structure for Cumulative Frequency Tables").

use cull::LeafRange;

/// The counts of draws and triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeafCount {
    /// The number of draws.
    pub draws: u64,
    /// The number of triangles of these draws.
    pub triangles: u64,
}

/// The counts of all leaves. A change and a sum each take logarithmic time in the number of leaves.
#[derive(Debug, Default)]
pub struct LeafCounts {
    /// The partial sums: entry `i - 1` is the sum over the last `n` leaves before `i`, where `n` is
    /// the lowest set bit of `i`.
    sums: Vec<LeafCount>,
}

impl LeafCounts {
    pub fn new(counts: impl Iterator<Item = LeafCount>) -> Self {
        let mut sums: Vec<LeafCount> = counts.collect();
        for place in 1..=sums.len() {
            let above = place + lowest_bit(place);
            let sum = sums[place - 1];
            if let Some(above) = sums.get_mut(above - 1) {
                above.draws += sum.draws;
                above.triangles += sum.triangles;
            }
        }
        Self { sums }
    }

    /// Adds leaves without draws until there are `leaf_count`.
    pub fn grow(&mut self, leaf_count: usize) {
        for place in self.sums.len() + 1..=leaf_count {
            let [start, end] = [place - lowest_bit(place), place - 1].map(|leaf| self.before(leaf));
            self.sums.push(LeafCount {
                draws: end.draws - start.draws,
                triangles: end.triangles - start.triangles,
            });
        }
    }

    /// Replaces the count of a leaf.
    pub fn replace(&mut self, leaf: usize, before: LeafCount, now: LeafCount) {
        let mut place = leaf + 1;
        while let Some(sum) = self.sums.get_mut(place - 1) {
            sum.draws = sum.draws + now.draws - before.draws;
            sum.triangles = sum.triangles + now.triangles - before.triangles;
            place += lowest_bit(place);
        }
    }

    /// Returns the sum of a range of leaves.
    pub fn of(&self, leaves: LeafRange) -> LeafCount {
        let range = leaves.indices();
        let before = self.before(range.start);
        let end = self.before(range.end);
        LeafCount {
            draws: end.draws.saturating_sub(before.draws),
            triangles: end.triangles.saturating_sub(before.triangles),
        }
    }

    fn before(&self, leaf: usize) -> LeafCount {
        let mut count = LeafCount::default();
        let mut place = leaf.min(self.sums.len());
        while place > 0 {
            let sum = self.sums[place - 1];
            count.draws += sum.draws;
            count.triangles += sum.triangles;
            place -= lowest_bit(place);
        }
        count
    }
}

const fn lowest_bit(place: usize) -> usize {
    place & place.wrapping_neg()
}

#[cfg(test)]
mod tests {
    use cull::LeafIndex;

    use super::*;

    #[test]
    fn sums_are_those_of_the_leaves_after_any_change() {
        for leaves in 0..40_usize {
            let count =
                |n: usize| LeafCount { draws: n as u64 % 3, triangles: n as u64 * 17 % 101 };
            let mut truth: Vec<LeafCount> = (0..leaves).map(count).collect();
            let mut counts = LeafCounts::new(truth.iter().copied());
            for change in 0..20 {
                for first in 0..=leaves {
                    for end in first..=leaves {
                        let range = LeafRange {
                            first: LeafIndex(first as u32),
                            count: (end - first) as u32,
                        };
                        let sum =
                            truth[first..end].iter().fold(LeafCount::default(), |sum, leaf| {
                                LeafCount {
                                    draws: sum.draws + leaf.draws,
                                    triangles: sum.triangles + leaf.triangles,
                                }
                            });
                        assert_eq!(counts.of(range), sum, "{first}..{end} of {leaves}");
                    }
                }
                if leaves > 0 {
                    let leaf = change * 7 % leaves;
                    let now = count(change * 31 + 5);
                    counts.replace(leaf, truth[leaf], now);
                    truth[leaf] = now;
                }
            }
        }
    }
}
