//! The changes of cells, each noted once.

use cull::LeafIndex;

/// The changes of cells since they were last taken.
#[derive(Default)]
pub(crate) struct CellChanges {
    leaves: Vec<LeafIndex>,
    is_touched: Vec<bool>,
    emptied: Vec<u32>,
    is_emptied: Vec<bool>,
    /// The number of cells written since the beginning, as a measure of work.
    pub(crate) written: u64,
}

impl CellChanges {
    /// Makes room for at least `leaf_count` leaves.
    pub(super) fn grow(&mut self, leaf_count: usize) {
        let leaf_count = leaf_count.max(self.is_touched.len());
        self.is_touched.resize(leaf_count, false);
    }

    /// Notes that the draws of a leaf changed or moved.
    pub(super) fn touch(&mut self, leaf: LeafIndex) {
        if let Some(is_touched) = self.is_touched.get_mut(leaf.0 as usize)
            && !std::mem::replace(is_touched, true)
        {
            self.leaves.push(leaf);
        }
    }

    /// Notes that a cell became empty.
    pub(super) fn empty(&mut self, cell: u32) {
        let place = cell as usize;
        if self.is_emptied.len() <= place {
            self.is_emptied.resize(place + 1, false);
        }
        if let Some(is_emptied) = self.is_emptied.get_mut(place)
            && !std::mem::replace(is_emptied, true)
        {
            self.emptied.push(cell);
        }
    }

    /// Takes the leaves whose draws changed or moved.
    pub(crate) fn take_leaves(&mut self, mut each: impl FnMut(LeafIndex)) {
        for leaf in self.leaves.drain(..) {
            if let Some(is_touched) = self.is_touched.get_mut(leaf.0 as usize) {
                *is_touched = false;
            }
            each(leaf);
        }
    }

    /// Takes the cells that became empty. Some may have a draw again.
    pub(crate) fn take_emptied(&mut self, mut each: impl FnMut(u32)) {
        for cell in self.emptied.drain(..) {
            if let Some(is_emptied) = self.is_emptied.get_mut(cell as usize) {
                *is_emptied = false;
            }
            each(cell);
        }
    }
}
