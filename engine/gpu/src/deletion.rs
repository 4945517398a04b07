//! The deletion queue: dropped objects wait here until the GPU can no longer use them.

use std::collections::VecDeque;

use ash::vk;
use gpu_allocator::vulkan::Allocation;

use crate::timeline::Tick;

/// The payload of a dropped object.
pub(crate) enum Garbage {
    Buffer(vk::Buffer, Allocation),
    Image(vk::Image, vk::ImageView, Allocation),
    Pipeline(vk::Pipeline),
    PipelineLayout(vk::PipelineLayout),
    SetLayout(vk::DescriptorSetLayout),
    DescriptorPool(vk::DescriptorPool),
    CommandPool(vk::CommandPool),
    QueryPool(vk::QueryPool),
    Semaphore(vk::Semaphore),
}

/// What was retired, in the order of the ticks that free it.
pub(crate) struct DeletionQueue<T> {
    waiting: VecDeque<(Tick, T)>,
}

impl<T> DeletionQueue<T> {
    pub(crate) fn new() -> Self {
        Self { waiting: VecDeque::new() }
    }

    /// Keeps `payload` until `tick` is over. Ticks never fall from call to call.
    pub(crate) fn retire(&mut self, tick: Tick, payload: T) {
        debug_assert!(self.waiting.back().is_none_or(|(last, _)| *last <= tick));
        self.waiting.push_back((tick, payload));
    }

    /// The next payload whose tick is over.
    pub(crate) fn pop_over(&mut self, completed: Tick) -> Option<T> {
        if self.waiting.front()?.0 <= completed {
            self.waiting.pop_front().map(|(_, payload)| payload)
        } else {
            None
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.waiting.len()
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
}
