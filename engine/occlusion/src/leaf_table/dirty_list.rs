//! Items that changed. Each is uploaded with every frame until a frame with its newest change is
//! known to have run.

use gpu::Tick;

/// The items to upload, without duplicates. Each item has a number below `count`.
#[derive(Debug)]
pub(super) struct DirtyList<T> {
    items: Vec<T>,
    /// The first frame with the newest change of each item, by the item's number.
    uploaded_in: Vec<UploadFrame>,
    number: fn(&T) -> u32,
}

/// The first frame with the newest change of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum UploadFrame {
    /// A frame that is known to have run.
    Past,
    /// The next frame.
    Next,
    /// A submitted frame that may not have run yet.
    Sent(Tick),
}

impl<T> DirtyList<T> {
    /// Creates the list of `count` unchanged items. `number` returns the number of an item.
    pub(super) fn new(count: usize, number: fn(&T) -> u32) -> Self {
        Self { items: Vec::new(), uploaded_in: vec![UploadFrame::Past; count], number }
    }

    /// Makes room for at least `count` items.
    pub(super) fn grow(&mut self, count: usize) {
        let count = count.max(self.uploaded_in.len());
        self.uploaded_in.resize(count, UploadFrame::Past);
    }

    /// Returns the items to upload.
    pub(super) fn items(&self) -> &[T] {
        &self.items
    }

    /// Notes that an item changed. Ignores an item that the list has no room for.
    pub(super) fn push(&mut self, item: T) {
        let Some(uploaded_in) = self.uploaded_in.get_mut((self.number)(&item) as usize) else {
            return;
        };
        if std::mem::replace(uploaded_in, UploadFrame::Next) == UploadFrame::Past {
            self.items.push(item);
        }
    }

    /// Replaces the items to upload by `all`, which changed.
    pub(super) fn push_all(&mut self, all: impl Iterator<Item = T>) {
        self.uploaded_in.fill(UploadFrame::Past);
        self.items.clear();
        all.for_each(|item| self.push(item));
    }

    /// Notes that a frame that uploads all items was submitted as `tick`.
    pub(super) fn sent(&mut self, tick: Tick) {
        for item in &self.items {
            if let Some(uploaded_in) = self.uploaded_in.get_mut((self.number)(item) as usize)
                && *uploaded_in == UploadFrame::Next
            {
                *uploaded_in = UploadFrame::Sent(tick);
            }
        }
    }

    /// Drops the items whose newest change is in a frame up to `ran`.
    pub(super) fn forget(&mut self, ran: Tick) {
        let Self { items, uploaded_in, number } = self;
        items.retain(|item| match uploaded_in.get_mut(number(item) as usize) {
            Some(UploadFrame::Sent(tick)) if *tick > ran => true,
            Some(UploadFrame::Next) => true,
            Some(over) => {
                *over = UploadFrame::Past;
                false
            }
            None => false,
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
}
