//! Items that changed. Each is uploaded with every frame until a frame with its newest change is
//! known to have run.

use std::collections::VecDeque;

use gpu::Tick;

/// The state of an item without changes that a frame must upload.
const CLEAN: u8 = 0;

/// The state of an item whose newest change is not in a submitted frame.
const NEXT: u8 = 1;

/// The items to upload, without duplicates. Each item has a number below `count`.
#[derive(Debug)]
pub(super) struct DirtyList<T> {
    items: Vec<T>,
    /// The state of each item, by its number: [`CLEAN`], [`NEXT`], or the state in `sent` of the
    /// first frame with its newest change. A byte each, because a scene has millions.
    states: Vec<u8>,
    /// The submitted frames that are not known to have run, the oldest first, each with the state
    /// of the items that it was the first to upload.
    sent: VecDeque<(u8, Tick)>,
    number: fn(&T) -> u32,
}

impl<T: Ord> DirtyList<T> {
    /// Creates the list of `count` unchanged items. `number` returns the number of an item.
    pub(super) fn new(count: usize, number: fn(&T) -> u32) -> Self {
        Self { items: Vec::new(), states: vec![CLEAN; count], sent: VecDeque::new(), number }
    }

    /// Makes room for at least `count` items.
    pub(super) fn grow(&mut self, count: usize) {
        let count = count.max(self.states.len());
        self.states.resize(count, CLEAN);
    }

    /// Returns the items to upload.
    pub(super) fn items(&self) -> &[T] {
        &self.items
    }

    /// Sorts the items, so that their data are read in the order of the memory.
    pub(super) fn sort(&mut self) {
        // Items that change in every frame are sorted already. A stable sort would allocate.
        self.items.sort_unstable();
    }

    /// Notes that an item changed. Ignores an item that the list has no room for.
    pub(super) fn push(&mut self, item: T) {
        let Some(state) = self.states.get_mut((self.number)(&item) as usize) else {
            return;
        };
        if std::mem::replace(state, NEXT) == CLEAN {
            self.items.push(item);
        }
    }

    /// Replaces the items to upload by `all`, which changed.
    pub(super) fn push_all(&mut self, all: impl Iterator<Item = T>) {
        self.states.fill(CLEAN);
        self.sent.clear();
        self.items.clear();
        all.for_each(|item| self.push(item));
    }

    /// Notes that a frame that uploads all items was submitted as `tick`.
    pub(super) fn sent(&mut self, tick: Tick) {
        if self.items.is_empty() {
            return;
        }
        let newest = self.sent.back().map_or(NEXT, |(state, _)| *state);
        // States are given out in turn. When all are in use, the last one serves for two frames,
        // and its items wait for the later frame.
        let state = if newest == u8::MAX { NEXT + 1 } else { newest + 1 };
        let state = match self.sent.front() {
            Some((oldest, _)) if *oldest == state => newest,
            _ => state,
        };
        for item in &self.items {
            if let Some(now) = self.states.get_mut((self.number)(item) as usize)
                && *now == NEXT
            {
                *now = state;
            }
        }
        match self.sent.back_mut() {
            Some((newest, sent)) if *newest == state => *sent = tick,
            _ => self.sent.push_back((state, tick)),
        }
    }

    /// Drops the items whose newest change is in a frame up to `ran`.
    pub(super) fn forget(&mut self, ran: Tick) {
        let mut is_over = [false; 1 << u8::BITS];
        let before = self.sent.len();
        while let Some((state, _)) = self.sent.pop_front_if(|(_, tick)| *tick <= ran) {
            is_over[usize::from(state)] = true;
        }
        if self.sent.len() == before {
            return;
        }
        let Self { items, states, number, .. } = self;
        items.retain(|item| match states.get_mut(number(item) as usize) {
            Some(state) if is_over[usize::from(*state)] => {
                *state = CLEAN;
                false
            }
            state => state.is_some(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_stays_until_a_frame_that_holds_it_ran() {
        let mut list = DirtyList::new(4, |item: &u32| *item);
        [2, 0, 2, 9].into_iter().for_each(|item| list.push(item));
        assert_eq!(list.items(), [2, 0]);
        list.forget(Tick(7));
        assert_eq!(list.items(), [2, 0], "no frame has them yet");
        list.sent(Tick(8));
        list.forget(Tick(7));
        list.push(0);
        list.sent(Tick(9));
        list.forget(Tick(8));
        assert_eq!(list.items(), [0], "it changed again after frame 8");
        list.forget(Tick(9));
        assert!(list.items().is_empty());
        list.push(2);
        assert_eq!(list.items(), [2]);
        list.push_all(0..3);
        list.forget(Tick(100));
        list.push(3);
        assert_eq!(list.items(), [0, 1, 2, 3]);
    }

    #[test]
    fn changes_of_more_frames_than_there_are_states_stay_long_enough() {
        let frames = 1_000;
        let mut list = DirtyList::new(frames as usize, |item: &u32| *item);
        for frame in 0..frames {
            list.push(frame);
            list.sent(Tick(u64::from(frame)));
        }
        for ran in 0..frames - 1 {
            list.forget(Tick(u64::from(ran)));
            assert!(list.items().iter().copied().eq(list.items()[0]..frames), "{ran}");
            assert!(list.items()[0] <= ran + 1, "{ran}");
        }
        list.forget(Tick(u64::from(frames)));
        assert!(list.items().is_empty());
    }
}
