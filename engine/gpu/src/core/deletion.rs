//! The deletion queue: dropped objects wait here until neither commands that are being recorded nor
//! the GPU can use them any more.

use std::collections::VecDeque;

use ash::vk;
use gpu_allocator::vulkan::Allocation;

use crate::core::tick::Tick;

/// The payload of a dropped object.
pub(crate) enum Retired {
    Buffer(vk::Buffer, Allocation),
    Image(vk::Image, vk::ImageView, Allocation),
    ImageView(vk::ImageView),
    Pipeline(vk::Pipeline),
    PipelineLayout(vk::PipelineLayout),
    SetLayout(vk::DescriptorSetLayout),
    DescriptorPool(vk::DescriptorPool),
    CommandPool(vk::CommandPool),
    QueryPool(vk::QueryPool),
    Sampler(vk::Sampler),
    Semaphore(vk::Semaphore),
    /// Objects of several handles that are destroyed together.
    Other(Box<dyn RetiredObject>),
}

/// A payload with its own way of destruction.
pub(crate) trait RetiredObject: Send {
    /// Destroys the payload. Nothing may use it any more.
    fn destroy(self: Box<Self>, device: &ash::Device);
}

/// The identity of a recording among all recordings of its device, including recordings of reused
/// command buffers. Recordings are numbered from 1 in the order in which they are opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct RecordingId(u64);

/// A dropped object that open recordings may use.
struct Recorded<T> {
    /// The newest recording that may use it.
    newest: RecordingId,
    /// The tick until which the GPU uses it in any case.
    until: Tick,
    payload: T,
}

/// Dropped objects, in the order in which they are freed.
pub(crate) struct DeletionQueue<T> {
    newest: RecordingId,
    /// Recordings that are neither submitted nor abandoned, oldest first.
    open: Vec<RecordingId>,
    /// Objects that open recordings may use.
    recorded: VecDeque<Recorded<T>>,
    /// Objects that only the GPU may still use, until the given tick.
    submitted: VecDeque<(Tick, T)>,
}

impl<T> DeletionQueue<T> {
    pub(crate) fn new() -> Self {
        Self {
            newest: RecordingId::default(),
            open: Vec::new(),
            recorded: VecDeque::new(),
            submitted: VecDeque::new(),
        }
    }

    /// Begins a recording: objects retired before it is closed outlive it.
    pub(crate) fn open(&mut self) -> RecordingId {
        self.newest.0 += 1;
        self.open.push(self.newest);
        self.newest
    }

    /// Ends a recording that was submitted at `submitted` or before, or will never be submitted.
    pub(crate) fn close(&mut self, recording: RecordingId, submitted: Tick) {
        self.open.retain(|open| *open != recording);
        let oldest = self.open.first().copied();
        while let Some(first) = self.recorded.front()
            && oldest.is_none_or(|oldest| oldest > first.newest)
        {
            let Some(Recorded { until, payload, .. }) = self.recorded.pop_front() else { return };
            self.keep_until(until.max(submitted), payload);
        }
    }

    /// Keeps `payload` until every open recording is closed and the last submit before that is
    /// over, and until `until` is over, which is the newest tick or a later one.
    pub(crate) fn retire(&mut self, until: Tick, payload: T) {
        if self.open.is_empty() {
            self.keep_until(until, payload);
        } else {
            self.recorded.push_back(Recorded { newest: self.newest, until, payload });
        }
    }

    /// Keeps `payload` until a tick is over, and at least as long as what was retired before.
    fn keep_until(&mut self, tick: Tick, payload: T) {
        let last = self.submitted.back().map_or(Tick::ZERO, |(last, _)| *last);
        self.submitted.push_back((tick.max(last), payload));
    }

    /// Returns the next payload that nothing uses if `completed` is over.
    pub(crate) fn pop_over(&mut self, completed: Tick) -> Option<T> {
        if self.submitted.front()?.0 <= completed {
            self.submitted.pop_front().map(|(_, payload)| payload)
        } else {
            None
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.recorded.len() + self.submitted.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_freed_before_its_tick() {
        let mut queue = DeletionQueue::new();
        queue.retire(Tick(1), 'a');
        queue.retire(Tick(2), 'b');
        queue.retire(Tick(2), 'c');
        queue.retire(Tick(5), 'd');
        assert_eq!(queue.pop_over(Tick::ZERO), None);
        assert_eq!(queue.pop_over(Tick(2)), Some('a'));
        assert_eq!(queue.pop_over(Tick(2)), Some('b'));
        assert_eq!(queue.pop_over(Tick(4)), Some('c'));
        assert_eq!(queue.pop_over(Tick(4)), None);
        assert_eq!(queue.len(), 1);
        assert_eq!(queue.pop_over(Tick(9)), Some('d'));
    }

    #[test]
    fn what_waits_for_a_later_submit_holds_back_what_comes_after_it() {
        let mut queue = DeletionQueue::new();
        queue.retire(Tick(3), 'a');
        queue.retire(Tick(2), 'b');
        assert_eq!(queue.pop_over(Tick(2)), None);
        let frame = queue.open();
        queue.retire(Tick(5), 'c');
        // Given up: it was never submitted.
        queue.close(frame, Tick(3));
        assert_eq!([3, 3, 4].map(|tick| queue.pop_over(Tick(tick))), [Some('a'), Some('b'), None]);
        assert_eq!(queue.pop_over(Tick(5)), Some('c'));
    }

    #[test]
    fn what_an_open_recording_may_use_has_no_tick_yet() {
        let mut queue = DeletionQueue::new();
        let frame = queue.open();
        queue.retire(Tick(3), 'a');
        // Meanwhile a transfer of another thread begins and ends.
        let transfer = queue.open();
        queue.retire(Tick(3), 'b');
        queue.close(transfer, Tick(4));
        queue.retire(Tick(4), 'c');
        assert_eq!((queue.pop_over(Tick(4)), queue.len()), (None, 3));
        queue.close(frame, Tick(5));
        assert_eq!(queue.pop_over(Tick(4)), None);
        assert_eq!(queue.pop_over(Tick(5)), Some('a'));
        assert_eq!(queue.pop_over(Tick(5)), Some('b'));
        assert_eq!(queue.pop_over(Tick(5)), Some('c'));
    }

    #[test]
    fn recordings_that_overlap_for_ever_hold_nothing_for_ever() {
        let mut queue = DeletionQueue::new();
        let mut open = queue.open();
        for tick in 1..100 {
            queue.retire(Tick(tick - 1), tick);
            let next = queue.open();
            queue.close(open, Tick(tick));
            open = next;
            assert_eq!(queue.pop_over(Tick(tick)), Some(tick));
        }
    }
}
