//! The execution of a host's frames: which frames ran and in which order, as far as it is known.
//!
//! A host may or may not submit the command buffers that the engine recorded into. When a frame
//! runs, it writes its number into mapped memory, together with the number of the frame that ran
//! before it. Answers of frames that did not run are ignored. Memory that frames share is valid
//! only if the frames ran in the order of their numbers.

use std::collections::VecDeque;
use std::sync::Weak;

use bytemuck::{Pod, Zeroable};

use crate::core::tick::Tick;

/// The stamp that the GPU writes for a frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub(crate) struct FrameStamp {
    /// The number of the frame.
    pub(crate) frame: u64,
    /// The number of the frame that ran before; 0 for none.
    pub(crate) predecessor: u64,
}

/// The memory for the stamp of a frame. If its owner was dropped, the stamp is unknown and the
/// frame counts as lost.
pub(crate) trait StampMemory: Send + Sync {
    /// Returns the stamp of the last frame, which is over or never ran.
    fn stamp(&self) -> FrameStamp;
}

/// The most frames that are remembered as lost; all frames before them then count as lost.
const LOST_KEPT: usize = 256;

/// The record of frames that are over: which of them ran.
#[derive(Default)]
pub(crate) struct Executions {
    /// Frames of all rings of the device that may not be over, in order.
    sent: VecDeque<(Tick, Weak<dyn StampMemory>)>,
    /// The newest frame that ran in order.
    confirmed: Tick,
    /// Frames that never ran, in order.
    lost: VecDeque<Tick>,
    /// Frames up to this one count as lost.
    forgotten: Tick,
    /// The number of times that a frame ran after a later one, or twice.
    disorders: u64,
}

impl Executions {
    /// Notes that `frame` was recorded and leaves its stamp in `memory` if it runs.
    pub(crate) fn sent(&mut self, frame: Tick, memory: Weak<dyn StampMemory>) {
        // Frames that are recorded concurrently may end in another order.
        let place = self.sent.partition_point(|(sent, _)| *sent < frame);
        self.sent.insert(place, (frame, memory));
    }

    /// Notes that all frames up to `safe` are over.
    pub(crate) fn settle(&mut self, safe: Tick) {
        while let Some((frame, memory)) = self.sent.pop_front_if(|(frame, _)| *frame <= safe) {
            self.note(frame, memory.upgrade().map(|memory| memory.stamp()).unwrap_or_default());
        }
    }

    fn note(&mut self, frame: Tick, stamp: FrameStamp) {
        if stamp.frame != frame.0 {
            tracing::debug!("frame {} of the host never ran: its answers are ignored", frame.0);
            if self.lost.len() == LOST_KEPT {
                self.forgotten = self.lost.pop_front().unwrap_or(self.forgotten);
            }
            self.lost.push_back(frame);
        } else if stamp.predecessor < frame.0 {
            self.confirmed = frame;
        } else {
            self.disorders += 1;
        }
    }

    /// Returns the newest frame that ran in order.
    pub(crate) fn confirmed(&self) -> Tick {
        self.confirmed
    }

    /// Returns true if a frame is over and never ran.
    pub(crate) fn is_lost(&self, frame: Tick) -> bool {
        frame <= self.forgotten || self.lost.contains(&frame)
    }

    /// Returns the number of times that frames ran in another order than recorded.
    pub(crate) fn disorders(&self) -> u64 {
        self.disorders
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    fn noted(frames: &[(u64, u64, u64)]) -> Executions {
        let mut executions = Executions::default();
        for (number, frame, predecessor) in frames.iter().copied() {
            executions.note(Tick(number), FrameStamp { frame, predecessor });
        }
        executions
    }

    #[test]
    fn frames_in_their_order_are_confirmed() {
        let executions = noted(&[(3, 3, 0), (4, 4, 3), (7, 7, 4)]);
        assert_eq!((executions.confirmed(), executions.disorders()), (Tick(7), 0));
        assert!(!executions.is_lost(Tick(4)));
    }

    #[test]
    fn a_frame_that_never_ran_is_lost_and_the_next_one_is_not() {
        let executions = noted(&[(3, 3, 0), (4, 1, 0), (5, 5, 3)]);
        assert!(executions.is_lost(Tick(4)) && !executions.is_lost(Tick(5)));
        assert_eq!((executions.confirmed(), executions.disorders()), (Tick(5), 0));
    }

    #[test]
    fn a_frame_that_ran_late_or_twice_is_a_disorder() {
        // 4 ran before 3, and 5 ran twice.
        let executions = noted(&[(3, 3, 4), (4, 4, 0), (5, 5, 5)]);
        assert_eq!((executions.confirmed(), executions.disorders()), (Tick(4), 2));
    }

    #[test]
    fn frames_of_several_rings_are_settled_in_their_order_and_lost_with_their_memory() {
        struct Memory(FrameStamp);
        impl StampMemory for Memory {
            fn stamp(&self) -> FrameStamp {
                self.0
            }
        }
        let memory = |frame| Arc::new(Memory(FrameStamp { frame, predecessor: 0 }));
        let weak = |memory: &Arc<Memory>| Arc::downgrade(memory) as Weak<dyn StampMemory>;
        let ran = memory(3);
        let late = memory(4);
        let dropped = memory(5);
        let next = memory(6);
        let mut executions = Executions::default();
        executions.sent(Tick(4), weak(&late));
        executions.sent(Tick(3), weak(&ran));
        executions.sent(Tick(5), weak(&dropped));
        executions.sent(Tick(6), weak(&next));
        drop(dropped);
        executions.settle(Tick(3));
        assert_eq!(executions.confirmed(), Tick(3));
        executions.settle(Tick(5));
        assert_eq!(executions.confirmed(), Tick(4));
        let lost = [3, 4, 5, 6].map(|frame| executions.is_lost(Tick(frame)));
        assert_eq!(lost, [false, false, true, false]);
    }

    #[test]
    fn what_is_forgotten_counts_as_lost() {
        let mut executions = Executions::default();
        for number in 1..=300 {
            executions.note(Tick(number), FrameStamp::default());
        }
        assert!((1..=300).all(|number| executions.is_lost(Tick(number))));
        assert!(!executions.is_lost(Tick(301)) && executions.lost.len() == LOST_KEPT);
    }
}
