//! Marked numbers without duplicates, so that changes for a frame that is never drawn cannot grow
//! without limit.

/// A set of numbers below a bound.
#[derive(Debug, Default)]
pub(crate) struct Marked {
    list: Vec<u32>,
    is_marked: Vec<bool>,
}

impl Marked {
    /// Creates an empty set of numbers below `bound`.
    pub(crate) fn none_of(bound: usize) -> Self {
        Self { list: Vec::new(), is_marked: vec![false; bound] }
    }

    /// Marks a number. A number beyond the bound is ignored.
    pub(crate) fn mark_dirty(&mut self, number: u32) {
        if let Some(is_marked) = self.is_marked.get_mut(number as usize)
            && !std::mem::replace(is_marked, true)
        {
            self.list.push(number);
        }
    }

    /// Returns the marked numbers, in the order in which they were marked.
    pub(crate) fn list(&self) -> &[u32] {
        &self.list
    }

    /// Unmarks all numbers, and returns them in their order.
    pub(crate) fn drain(&mut self) -> impl Iterator<Item = u32> + '_ {
        let Self { list, is_marked } = self;
        list.drain(..).inspect(|number| {
            if let Some(is_marked) = is_marked.get_mut(*number as usize) {
                *is_marked = false;
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_marked_once() {
        let mut marked = Marked::none_of(4);
        for number in [2, 0, 2, 2, 9, 0] {
            marked.mark_dirty(number);
        }
        assert_eq!(marked.list(), [2, 0]);
        assert!(marked.drain().eq([2, 0]));
        marked.mark_dirty(2);
        assert_eq!(marked.list(), [2], "it can be marked again");
    }
}
