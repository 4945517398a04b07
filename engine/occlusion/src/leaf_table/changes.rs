//! The log of cells whose draw changed, for views that keep copies of the draws. Each view
//! continues where it stopped reading.

use std::collections::VecDeque;

/// The latest cells whose draw changed. Changes are numbered from the first one on.
#[derive(Debug)]
pub struct DrawChanges {
    cells: VecDeque<u32>,
    /// The number of changes before `cells`.
    dropped: u64,
    most: usize,
}

impl DrawChanges {
    /// Creates a log with room for one change per cell. A view that missed more changes copies all
    /// draws again.
    pub fn new(cell_count: usize) -> Self {
        const MOST_MIN: usize = 1 << 10;
        Self { cells: VecDeque::new(), dropped: 0, most: cell_count.max(MOST_MIN) }
    }

    /// Notes that the draw in a cell changed.
    pub fn push(&mut self, cell: u32) {
        if self.cells.len() == self.most {
            self.cells.pop_front();
            self.dropped += 1;
        }
        self.cells.push_back(cell);
    }

    /// Makes every reader copy all draws again.
    pub fn forget(&mut self) {
        self.dropped = self.count() + 1;
        self.cells.clear();
    }

    /// Returns the number of changes so far.
    pub fn count(&self) -> u64 {
        self.dropped + self.cells.len() as u64
    }

    /// Returns the changes after the first `seen`; `None` if the log no longer has all of them.
    pub fn since(&self, seen: u64) -> Option<impl Iterator<Item = u32>> {
        let first = usize::try_from(seen.checked_sub(self.dropped)?).ok()?;
        Some(self.cells.iter().skip(first).copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readers_go_on_where_they_stopped_or_are_told_that_they_cannot() {
        let mut changes = DrawChanges::new(0);
        let since =
            |changes: &DrawChanges, seen| changes.since(seen).map(Iterator::collect::<Vec<u32>>);
        assert_eq!(since(&changes, 0), Some(vec![]));
        (0..1023).for_each(|cell| changes.push(cell));
        assert_eq!(since(&changes, 1021), Some(vec![1021, 1022]));
        (1023..1026).for_each(|cell| changes.push(cell));
        assert_eq!((changes.count(), since(&changes, 1026)), (1026, Some(vec![])));
        assert_eq!(since(&changes, 2).map(|cells| cells[0]), Some(2));
        assert_eq!(since(&changes, 1), None, "cell 1 was dropped");
        changes.forget();
        assert_eq!(since(&changes, 1026), None, "all were forgotten");
        assert_eq!(since(&changes, changes.count()), Some(vec![]));
    }
}
