//! The clock of a device: the numbers of the work in flight and of the work that is over.

use std::sync::atomic::{AtomicU64, Ordering};

use ash::vk;

use crate::core::error::Error;
use crate::core::queue_lock::QueueLock;
use crate::core::tick::Tick;

/// The numbers of work in flight, as [`Tick`]s.
pub(super) struct Clock {
    pub(super) source: ClockSource,
    /// The newest tick that was issued.
    newest: AtomicU64,
    /// The newest tick that is known to be over.
    over: AtomicU64,
}

/// The origin of a clock's numbers.
pub(super) enum ClockSource {
    /// The submits of the device to a queue, counted by a timeline semaphore.
    Timeline(OwnTimeline),
    /// The frames of a host, which submits them and reports which are over.
    HostFrames,
}

/// A queue and the semaphore that counts the submits to it.
pub(super) struct OwnTimeline {
    pub(super) queue: QueueLock<vk::Queue>,
    pub(super) semaphore: vk::Semaphore,
}

impl Clock {
    pub(super) fn new(source: ClockSource) -> Self {
        Self { source, newest: AtomicU64::new(0), over: AtomicU64::new(0) }
    }

    /// Returns the queue and its timeline; `what` names the operation that needs them.
    pub(super) fn timeline(&self, what: &'static str) -> Result<&OwnTimeline, Error> {
        match &self.source {
            ClockSource::Timeline(timeline) => Ok(timeline),
            ClockSource::HostFrames => Err(Error::NoQueue { what }),
        }
    }

    pub(super) fn newest(&self) -> Tick {
        Tick(self.newest.load(Ordering::Acquire))
    }

    pub(super) fn over(&self) -> Tick {
        Tick(self.over.load(Ordering::Acquire))
    }

    /// Notes a submit. The caller must hold the queue.
    pub(super) fn submitted(&self, tick: Tick) {
        self.newest.store(tick.0, Ordering::Release);
    }

    /// Notes that everything up to `tick` is over.
    pub(super) fn completed(&self, tick: Tick) {
        self.over.fetch_max(tick.0, Ordering::AcqRel);
    }

    /// Begins the frame `current` of a host; all frames up to `safe` are over.
    pub(super) fn begin_host_frame(&self, current: Tick, safe: Tick) -> Result<(), Error> {
        if !matches!(self.source, ClockSource::HostFrames) {
            return Err(Error::HasQueue);
        }
        let newest = self.newest();
        let over = self.over();
        if current <= newest || safe < over || safe >= current {
            return Err(Error::FrameNumbers {
                current: current.0,
                safe: safe.0,
                newest: newest.0,
                over: over.0,
            });
        }
        self.completed(safe);
        self.submitted(current);
        Ok(())
    }

    /// Notes that all frames of a host are over.
    pub(super) fn finish_host_frames(&self) -> Result<(), Error> {
        if !matches!(self.source, ClockSource::HostFrames) {
            return Err(Error::HasQueue);
        }
        self.completed(self.newest());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_frames_rise_and_none_is_over_before_it_begins() {
        let clock = Clock::new(ClockSource::HostFrames);
        // The engine may start late and need not see every frame.
        clock.begin_host_frame(Tick(7), Tick(5)).unwrap();
        clock.begin_host_frame(Tick(10), Tick(9)).unwrap();
        assert_eq!((clock.newest(), clock.over()), (Tick(10), Tick(9)));
        for (current, safe, rule) in [
            (10, 9, "must rise with each frame that begins on the device, and is 11 or more now"),
            (3, 9, "after frame 10"),
            (11, 8, "up to 9 were over before, and `safe` must not fall, so it must be 9 or more"),
            (11, 11, "no frame is over before it begins, so `safe` must be below 11"),
            (11, 12, "`FrameNumbers::safe` is 12: no frame is over before it begins"),
        ] {
            let error = clock.begin_host_frame(Tick(current), Tick(safe)).unwrap_err();
            assert!(matches!(error, Error::FrameNumbers { .. }), "{error}");
            let text = error.to_string();
            assert!(text.contains(&format!("frame {current}")) && text.contains(rule), "{text}");
        }
        // A rejected frame changes nothing.
        assert_eq!((clock.newest(), clock.over()), (Tick(10), Tick(9)));
        assert!(matches!(clock.timeline("a drain"), Err(Error::NoQueue { what: "a drain" })));
        clock.finish_host_frames().unwrap();
        assert_eq!(clock.over(), Tick(10));
    }
}
