//! Places labels beside the ends of lines so that none overlaps another.

/// Moves wanted places apart until neighbours are `gap` from each other, as little as possible, and
/// keeps them between `least` and `most` while there is room. Returns them in the order of
/// `wanted`.
pub fn spread_apart(wanted: &[i32], gap: i32, least: i32, most: i32) -> Vec<i32> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by_key(|&place| wanted.get(place));
    // Blocks of labels that touch: where the first wants to be, on average, and how many there are.
    let mut blocks: Vec<Block> = Vec::new();
    for &place in &order {
        let wanted = f64::from(wanted.get(place).copied().unwrap_or(least));
        blocks.push(Block { wanted_sum: wanted, count: 1 });
        while let [.., above, below] = blocks.as_slice()
            && above.first(gap, least, most) + above.height(gap) > below.first(gap, least, most)
        {
            let merged = above.with(below, gap);
            blocks.truncate(blocks.len() - 2);
            blocks.push(merged);
        }
    }
    let mut places = vec![least; wanted.len()];
    let mut next = order.into_iter();
    for block in blocks {
        let first = block.first(gap, least, most);
        for step in 0..block.count {
            if let Some(place) = next.next().and_then(|place| places.get_mut(place)) {
                *place = (first + f64::from(gap) * f64::from(step)).round() as i32;
            }
        }
    }
    places
}

#[derive(Clone, Copy)]
struct Block {
    /// The sum over its labels of the place of the block's first label that would put the label
    /// right.
    wanted_sum: f64,
    count: u32,
}

impl Block {
    fn first(&self, gap: i32, least: i32, most: i32) -> f64 {
        let last_first = f64::from(most) - self.height(gap) + f64::from(gap);
        (self.wanted_sum / f64::from(self.count)).min(last_first).max(f64::from(least))
    }

    fn height(&self, gap: i32) -> f64 {
        f64::from(gap) * f64::from(self.count)
    }

    fn with(&self, below: &Self, gap: i32) -> Self {
        let moved = below.wanted_sum - self.height(gap) * f64::from(below.count);
        Self { wanted_sum: self.wanted_sum + moved, count: self.count + below.count }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn labels_that_have_room_stay() {
        assert_eq!(spread_apart(&[90, 10, 50], 20, 0, 100), [90, 10, 50]);
        assert!(spread_apart(&[], 20, 0, 100).is_empty());
    }

    #[test]
    fn labels_that_meet_move_apart_evenly() {
        assert_eq!(spread_apart(&[50, 50], 20, 0, 100), [40, 60]);
        assert_eq!(spread_apart(&[52, 50, 48], 20, 0, 100), [70, 50, 30]);
        assert_eq!(spread_apart(&[1, 1, 80], 20, 0, 100), [0, 20, 80]);
        assert_eq!(spread_apart(&[99, 99], 20, 0, 100), [80, 100]);
    }

    proptest! {
        #[test]
        fn none_lies_over_another(wanted in prop::collection::vec(-50i32..500, 0..20)) {
            let places = spread_apart(&wanted, 16, 0, 400);
            prop_assert_eq!(places.len(), wanted.len());
            let mut sorted = places.clone();
            sorted.sort_unstable();
            prop_assert!(sorted.windows(2).all(|pair| pair[1] - pair[0] >= 16), "{:?}", sorted);
            prop_assert!(sorted.first().is_none_or(|first| *first >= 0));
            prop_assert!(sorted.len() > 20 || sorted.last().is_none_or(|last| *last <= 400));
            for (a, place_a) in wanted.iter().zip(&places) {
                for (b, place_b) in wanted.iter().zip(&places) {
                    prop_assert!(a >= b || place_a < place_b, "order is kept");
                }
            }
        }
    }
}
