//! The queue of frames, and the reactions when it does not empty.

use super::super::Pacer;
use crate::frame::{PacedFrameId, WaitReason};
use crate::frames::Record;
use crate::options::PresentReports;
use crate::time::{MILLISECOND_NS, SECOND_NS, ns};

/// The number of refreshes after which the window counts as hidden if no frame leaves the full
/// queue.
const PATIENCE_REFRESHES: f64 = 8.0;
const PATIENCE_NS: f64 = 100.0 * MILLISECOND_NS;
/// The interval at which a hidden window is checked, so that frames resume soon after it is
/// visible.
const HIDDEN_POLL_NS: f64 = 50.0 * MILLISECOND_NS;
/// The time after which the pacer no longer waits for unfinished work.
const GPU_PATIENCE_NS: f64 = 5.0 * SECOND_NS;
/// The shortest pause between two polls with a full queue.
const SHORTEST_PAUSE_NS: f64 = 0.1 * MILLISECOND_NS;
/// The first pause after consecutive frames that could not be presented.
const DROP_PAUSE_NS: f64 = 4.0 * MILLISECOND_NS;

impl Pacer {
    /// Returns the number of frames that may be queued. Without reports and without a known phase,
    /// only a queue as full as the swapchain allows reveals a refresh.
    pub(in crate::pacer) fn queue_limit(&self) -> usize {
        let limit = self.options.queue_limit;
        let blind = self.learns_from_acquires()
            && (self.phase_search.active || self.clock.period().is_none());
        (if blind { limit.max(self.presentation.images) } else { limit }) as usize
    }

    /// Returns true if acquires are the only sign of refreshes.
    pub(in crate::pacer) fn learns_from_acquires(&self) -> bool {
        self.presentation.reports == PresentReports::Missing
            && self.presentation.in_order()
            && self.presentation.has_grid()
    }

    /// Returns the ordinal of the frame that must replace another frame on the screen before an
    /// image is free, once every image has been presented.
    pub(in crate::pacer) fn ordinal_in_the_way(&self) -> Option<u64> {
        let images = u64::from(self.presentation.images);
        self.presented.checked_sub(images).map(|replaced| replaced + 1)
    }

    /// Removes frames from the queue that must have left it, if there are no reports.
    pub(in crate::pacer) fn settle(&mut self, now: f64) {
        if self.presentation.reports == PresentReports::Times {
            return;
        }
        let mut gpu_free =
            self.frames.newest_first().find_map(|(_, record)| record.finished).unwrap_or(0.0);
        while let Some((frame, record)) = self.frames.oldest_queued() {
            let knowledge = self.knowledge(now);
            let finish = knowledge.finish(&record, gpu_free);
            let shown = knowledge.shown(&record, finish, self.last_left.1);
            let done = record.finished.is_some() || !self.sees_finishes;
            let certain = if self.learns_from_acquires() {
                let doubt = self.clock.uncertainty(now).map(|deviation| 2.0 * deviation);
                // Without a phase only acquires reveal that a frame has left, if they are reported.
                doubt.or((!self.sees_acquires).then_some(0.0))
            } else {
                Some(0.0)
            };
            let over = certain.is_some_and(|doubt| done && now >= shown + doubt);
            if record.queued.is_none() || !over {
                break;
            }
            gpu_free = gpu_free.max(finish);
            self.frames.leave(frame);
            self.shown_at(frame, shown);
        }
    }

    /// Returns the time until which no frame may start, and the reason.
    pub(in crate::pacer) fn held_back(&mut self, now: f64) -> Option<(f64, WaitReason)> {
        let last_start = self.last_start.unwrap_or(f64::NEG_INFINITY);
        if self.dropped_in_a_row > 1 {
            // The pause doubles: frames continue while a window is resized, and the loop does not
            // spin when the window is gone.
            let pause = DROP_PAUSE_NS * f64::from(1_u32 << (self.dropped_in_a_row - 2).min(12));
            let until = last_start + pause.min(ns(self.options.hidden_interval));
            if now < until {
                return Some((until, WaitReason::Hidden));
            }
        }
        let queued = self.frames.queued().count();
        if queued < self.queue_limit() {
            self.silence.since = now;
            return self.gpu_backlog(now);
        }
        let (oldest, record) = self.frames.oldest_queued()?;
        let period = self.some_period_ns();
        // A GPU that is still working does not mean a hidden window.
        let works = record.queued.is_some_and(|queued| now - queued < GPU_PATIENCE_NS);
        if self.sees_finishes && record.finished.is_none() && works {
            self.silence.since = now;
        }
        let patience = PATIENCE_NS.max(PATIENCE_REFRESHES * period);
        if now - self.silence.since > patience {
            self.silence.hidden = true;
        }
        if self.silence.hidden {
            let due = last_start + ns(self.options.hidden_interval);
            if now < due {
                return Some((due.min(now + HIDDEN_POLL_NS), WaitReason::Hidden));
            }
            // Given up, so that a lost report cannot block the loop forever.
            self.frames.leave(oldest);
            return None;
        }
        let leaves = self.knowledge(now).forecast(&self.frames, None).first_leaves;
        let until = if leaves.is_finite() { leaves } else { now };
        let pause = (period / 16.0).max(SHORTEST_PAUSE_NS).max((now - self.silence.since) / 8.0);
        let until = until.clamp(now + pause, now + patience.max(pause));
        Some((until, WaitReason::QueueFull(PacedFrameId(oldest))))
    }

    /// Returns a wait for the GPU while the queue may be filled beyond its limit: the extra frames
    /// may wait for the display, but not for the GPU.
    fn gpu_backlog(&self, now: f64) -> Option<(f64, WaitReason)> {
        if !self.sees_finishes {
            return None;
        }
        let limit = self.options.queue_limit as usize;
        let unfinished = |record: &Record| {
            record.finished.is_none()
                && record.queued.is_some_and(|queued| now - queued < GPU_PATIENCE_NS)
                && !record.left
        };
        let recent = self.frames.newest_first().take(limit);
        let mut oldest = None;
        let mut count = 0;
        for (frame, _) in recent.filter(|(_, record)| unfinished(record)) {
            count += 1;
            oldest = Some(frame);
        }
        let frame = oldest.filter(|_| count >= limit)?;
        let period = self.some_period_ns();
        let expected = self
            .frames
            .record(frame)
            .map_or(now, |record| self.knowledge(f64::NEG_INFINITY).finish(record, 0.0));
        let pause = (period / 16.0).max(SHORTEST_PAUSE_NS).max(0.25 * (now - expected));
        let until = expected.clamp(now + pause, now + period.max(pause));
        Some((until, WaitReason::QueueFull(PacedFrameId(frame))))
    }

    /// Notes the best known present time of the newest frame that has left the queue.
    pub(in crate::pacer) fn shown_at(&mut self, frame: u64, at: f64) {
        if frame >= self.last_left.0 {
            self.last_left = (frame, at);
        }
    }

    /// Notes a sign that the window is visible.
    pub(in crate::pacer) fn heard(&mut self) {
        self.silence.hidden = false;
        if let Some(now) = self.now {
            self.silence.since = now;
        }
    }
}
