//! A set of nodes as one bit per node, emptied from the greatest node down: children come before
//! their parents, in the order of their memory and without sorting.

const WORD_BITS: u32 = u64::BITS;

/// A set of nodes.
#[derive(Clone, Debug, Default)]
pub(super) struct NodeSet {
    words: Vec<u64>,
    /// One bit per word, set if the word has a bit.
    summary: Vec<u64>,
}

impl NodeSet {
    /// Makes room for `nodes` nodes. A set never shrinks.
    pub(super) fn grow(&mut self, nodes: usize) {
        let words = nodes.div_ceil(WORD_BITS as usize);
        if words > self.words.len() {
            self.words.resize(words, 0);
            self.summary.resize(words.div_ceil(WORD_BITS as usize), 0);
        }
    }

    /// Inserts a node for which there is room.
    #[inline]
    pub(super) fn insert(&mut self, node: u32) {
        let word = node / WORD_BITS;
        self.words[word as usize] |= 1 << (node % WORD_BITS);
        self.summary[(word / WORD_BITS) as usize] |= 1 << (word % WORD_BITS);
    }

    /// Removes all nodes, the greatest first. `each` gets every node and may return a smaller node
    /// to insert.
    pub(super) fn drain_down(&mut self, mut each: impl FnMut(u32) -> Option<u32>) {
        for group in (0..self.summary.len()).rev() {
            while let Some(place) = self.summary[group].checked_ilog2() {
                let word = group as u32 * WORD_BITS + place;
                while let Some(bit) = self.words[word as usize].checked_ilog2() {
                    self.words[word as usize] &= !(1 << bit);
                    if let Some(smaller) = each(word * WORD_BITS + bit) {
                        self.insert(smaller);
                    }
                }
                self.summary[group] &= !(1 << place);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_come_from_the_greatest_down_with_those_that_are_inserted_on_the_way() {
        let mut set = NodeSet::default();
        set.grow(20_000);
        [19_999, 5, 64, 4_096, 65, 5].into_iter().for_each(|node| set.insert(node));
        let mut drained = Vec::new();
        set.drain_down(|node| {
            drained.push(node);
            (node > 64).then_some(node / 2)
        });
        let halves = [19_999, 9_999, 4_999, 4_096, 2_499, 2_048, 1_249, 1_024, 624, 512, 312];
        assert_eq!(drained[..halves.len()], halves);
        assert!(drained.is_sorted_by(|a, b| a > b), "{drained:?}");
        assert_eq!(drained.last(), Some(&5));
        set.drain_down(|node| unreachable!("{node} is still in the set"));
    }
}
