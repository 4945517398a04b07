//! The leaves whose draw changed, for views with copies of the draws: each reads on where it
//! stopped.

use std::collections::VecDeque;

use cull::LeafIndex;

/// The latest leaves whose draw changed, numbered from the first change on.
#[derive(Debug)]
pub struct DrawChanges {
    leaves: VecDeque<LeafIndex>,
    /// The number of changes before `leaves`.
    dropped: u64,
    most: usize,
}

impl DrawChanges {
    /// Creates a log of as many changes as there are leaves: a view that missed more copies all
    /// draws again.
    pub fn new(leaf_count: usize) -> Self {
        const MOST_MIN: usize = 1 << 10;
        Self { leaves: VecDeque::new(), dropped: 0, most: leaf_count.max(MOST_MIN) }
    }

    /// Notes that the draw of a leaf changed.
    pub fn push(&mut self, leaf: LeafIndex) {
        if self.leaves.len() == self.most {
            self.leaves.pop_front();
            self.dropped += 1;
        }
        self.leaves.push_back(leaf);
    }

    /// Makes every reader copy all draws again.
    pub fn forget(&mut self) {
        self.dropped = self.count() + 1;
        self.leaves.clear();
    }

    /// Returns the number of changes so far.
    pub fn count(&self) -> u64 {
        self.dropped + self.leaves.len() as u64
    }

    /// Returns those after the first `seen`; `None` if not all of them are kept.
    pub fn since(&self, seen: u64) -> Option<impl Iterator<Item = LeafIndex>> {
        let first = usize::try_from(seen.checked_sub(self.dropped)?).ok()?;
        Some(self.leaves.iter().skip(first).copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readers_go_on_where_they_stopped_or_are_told_that_they_cannot() {
        let mut changes = DrawChanges::new(0);
        let since = |changes: &DrawChanges, seen| {
            changes.since(seen).map(|leaves| leaves.map(|leaf| leaf.0).collect::<Vec<_>>())
        };
        assert_eq!(since(&changes, 0), Some(vec![]));
        (0..1023).for_each(|leaf| changes.push(LeafIndex(leaf)));
        assert_eq!(since(&changes, 1021), Some(vec![1021, 1022]));
        (1023..1026).for_each(|leaf| changes.push(LeafIndex(leaf)));
        assert_eq!((changes.count(), since(&changes, 1026)), (1026, Some(vec![])));
        assert_eq!(since(&changes, 2).map(|leaves| leaves[0]), Some(2));
        assert_eq!(since(&changes, 1), None, "leaf 1 was dropped");
        changes.forget();
        assert_eq!(since(&changes, 1026), None, "all were forgotten");
        assert_eq!(since(&changes, changes.count()), Some(vec![]));
    }
}
