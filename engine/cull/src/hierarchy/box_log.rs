//! The changes of objects' boxes, for data that depends on them, such as shadow maps. Each reader
//! continues where it stopped.

use std::collections::VecDeque;

use crate::geom::bounds::Aabb;
use crate::ids::ObjectId;

/// The most changes that are held for any number of objects: after more changes in a frame, readers
/// should start afresh.
const CHANGES_MAX: usize = 1 << 16;

/// The number of changes that are held for a few objects: enough for readers that pause for a
/// while.
const CHANGES_OF_FEW: usize = 1 << 10;

/// A change of an object's box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxChange {
    /// The object whose box changed.
    pub object: ObjectId,
    /// The box before; [empty](Aabb::EMPTY) if the object was inserted.
    pub before: Aabb,
    /// The box after; [empty](Aabb::EMPTY) if the object was removed.
    pub after: Aabb,
}

/// The latest changes. The log is bounded: a reader that reads too seldom has to start afresh.
#[derive(Clone, Debug, Default)]
pub(super) struct BoxLog {
    changes: VecDeque<BoxChange>,
    /// The number of changes so far.
    count: u64,
}

impl BoxLog {
    /// Notes a change of one of `objects` objects. Drops the oldest if each object has changed
    /// several times since.
    #[inline]
    pub(super) fn push(&mut self, change: BoxChange, objects: usize) {
        if self.changes.len() >= objects.saturating_mul(4).clamp(CHANGES_OF_FEW, CHANGES_MAX) {
            self.changes.pop_front();
        }
        self.changes.push_back(change);
        self.count += 1;
    }

    /// Clears all changes: every reader has to start afresh.
    pub(super) fn clear(&mut self) {
        self.changes.clear();
        self.count += 1;
    }

    pub(super) fn count(&self) -> u64 {
        self.count
    }

    /// Returns the changes after the first `count`, the oldest first; `None` if not all of them are
    /// held.
    pub(super) fn since(&self, count: u64) -> Option<impl Iterator<Item = &BoxChange>> {
        let wanted = usize::try_from(self.count.checked_sub(count)?).ok()?;
        let first = self.changes.len().checked_sub(wanted)?;
        Some(self.changes.range(first..))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn objects(log: &BoxLog, count: u64) -> Option<Vec<u32>> {
        Some(log.since(count)?.map(|change| change.object.0).collect())
    }

    #[test]
    fn readers_go_on_where_they_stopped_or_start_afresh() {
        let mut log = BoxLog::default();
        let change = |object| BoxChange {
            object: ObjectId(object),
            before: Aabb::EMPTY,
            after: Aabb::EMPTY,
        };
        (0..5).for_each(|object| log.push(change(object), 5));
        assert_eq!(objects(&log, 5), Some(vec![]));
        assert_eq!(objects(&log, 3), Some(vec![3, 4]));
        assert_eq!(objects(&log, 6), None, "that is the future");
        log.clear();
        assert_eq!(objects(&log, 5), None);
        assert_eq!(objects(&log, 6), Some(vec![]));
        let mut first = log.count();
        for (count, held) in [(1, CHANGES_OF_FEW), (1_000, 4_000), (usize::MAX / 2, CHANGES_MAX)] {
            (0..held as u32 + 1).for_each(|object| log.push(change(object), count));
            assert_eq!(objects(&log, first), None, "{count} objects");
            assert_eq!(objects(&log, first + 1).map(|all| all.len()), Some(held));
            log.clear();
            first = log.count();
        }
    }
}
