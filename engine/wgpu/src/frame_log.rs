//! The numbers of frames, and which of them are over.
//!
//! Each command buffer and each buffer of a frame that wgpu holds has a part of the frame's guard.
//! wgpu drops them when the GPU is done with them, or when they will never be submitted.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use gpu::{FrameNumbers, Tick};

/// The frames of a device that were begun.
#[derive(Debug, Default)]
pub(crate) struct FrameLog {
    frames: Mutex<Frames>,
}

#[derive(Debug, Default)]
pub(crate) struct Frames {
    newest: u64,
    /// The submission of each frame that is not over, once it is known.
    unfinished: BTreeMap<u64, Option<wgpu::SubmissionIndex>>,
}

/// A part of a frame: when the last part is dropped, the frame is over.
#[derive(Clone, Debug)]
pub(crate) struct FrameGuard {
    frame: Arc<UnfinishedFrame>,
}

#[derive(Debug)]
struct UnfinishedFrame {
    log: Arc<FrameLog>,
    number: u64,
}

impl FrameLog {
    /// Returns the frames, which do not change until the guard is dropped.
    pub(crate) fn lock(&self) -> MutexGuard<'_, Frames> {
        self.frames.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the guard of the newest frame, which `frames` of this log has begun.
    pub(crate) fn guard(self: &Arc<Self>, frames: &mut Frames) -> FrameGuard {
        let number = frames.newest;
        frames.unfinished.insert(number, None);
        FrameGuard { frame: Arc::new(UnfinishedFrame { log: Arc::clone(self), number }) }
    }
}

impl Frames {
    /// Returns the numbers of the next frame.
    pub(crate) fn begin(&mut self) -> FrameNumbers {
        let safe = self.over();
        self.newest += 1;
        FrameNumbers { current: Tick(self.newest), safe: Tick(safe) }
    }

    /// Returns the newest frame that is over together with all frames before it.
    pub(crate) fn over(&self) -> u64 {
        self.unfinished.first_key_value().map_or(self.newest, |(oldest, _)| oldest - 1)
    }

    /// Returns the submission of the last frame up to `number` that is not over. Submissions end in
    /// their order.
    pub(crate) fn last_submission(&self, number: u64) -> Option<wgpu::SubmissionIndex> {
        self.unfinished.range(..=number).rev().find_map(|(_, submission)| submission.clone())
    }

    /// Returns the number of frames that are not over.
    pub(crate) fn unfinished(&self) -> usize {
        self.unfinished.len()
    }
}

impl FrameGuard {
    /// Notes the submission of the frame.
    pub(crate) fn submitted(&self, submission: &wgpu::SubmissionIndex) {
        let mut frames = self.frame.log.lock();
        if let Some(known) = frames.unfinished.get_mut(&self.frame.number) {
            *known = Some(submission.clone());
        }
    }
}

impl Drop for UnfinishedFrame {
    fn drop(&mut self) {
        self.log.lock().unfinished.remove(&self.number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_over_when_its_last_part_and_all_frames_before_it_are() {
        let log = Arc::new(FrameLog::default());
        let begin = || {
            let mut frames = log.lock();
            let numbers = frames.begin();
            let guard = log.guard(&mut frames);
            (numbers, guard)
        };
        let (first, first_guard) = begin();
        let (second, second_guard) = begin();
        assert_eq!([first.current, first.safe], [Tick(1), Tick(0)]);
        assert_eq!([second.current, second.safe], [Tick(2), Tick(0)]);
        let state = || {
            let frames = log.lock();
            [frames.over(), frames.unfinished() as u64]
        };
        let part = first_guard.clone();
        drop(second_guard);
        drop(first_guard);
        assert_eq!(state(), [0, 1]);
        drop(part);
        assert_eq!(state(), [2, 0]);
        // A frame that failed to begin has a number but no guard.
        log.lock().begin();
        assert_eq!(log.lock().over(), 3);
    }
}
