//! A set of nodes as one bit per node, emptied in the order of the nodes' memory without sorting.

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

    /// Removes all nodes, and calls `each` with every one, the least first.
    pub(super) fn drain(&mut self, mut each: impl FnMut(u32)) {
        for (group, summary) in self.summary.iter_mut().enumerate() {
            for place in places_of(std::mem::take(summary)) {
                let word = group as u32 * WORD_BITS + place;
                let bits = std::mem::take(&mut self.words[word as usize]);
                places_of(bits).for_each(|place| each(word * WORD_BITS + place));
            }
        }
    }
}

/// Returns the places of the bits that are set, the lowest first.
fn places_of(mut bits: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let place = (bits != 0).then(|| bits.trailing_zeros())?;
        bits &= bits - 1;
        Some(place)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_come_once_and_in_their_order() {
        let mut set = NodeSet::default();
        set.grow(20_000);
        [19_999, 5, 64, 4_096, 65, 5].into_iter().for_each(|node| set.insert(node));
        let mut drained = Vec::new();
        set.drain(|node| drained.push(node));
        assert_eq!(drained, [5, 64, 65, 4_096, 19_999]);
        set.drain(|node| unreachable!("{node} is still in the set"));
    }
}
