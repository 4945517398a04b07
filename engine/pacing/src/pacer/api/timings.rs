//! The timing of each frame, in order, once it is complete.

use std::time::Duration;

use super::super::Pacer;
use crate::frame::{FrameTiming, PacedFrameId};
use crate::frames::REMEMBERED;
use crate::options::PresentReports;
use crate::time::SECOND_NS;

/// The number of later frames after which no more feedback about a frame is expected.
const PATIENCE_FRAMES: u64 = 3 * REMEMBERED as u64 / 4;

impl Pacer {
    /// Returns the next frame with complete timing, each frame once and in order; dropped frames
    /// are left out. Call it after delivering feedback until it returns `None`: only about the last
    /// sixty frames are remembered.
    pub fn completed(&mut self) -> Option<(PacedFrameId, FrameTiming)> {
        self.timing_cursor.next = self.timing_cursor.next.max(self.frames.oldest());
        loop {
            let frame = self.timing_cursor.next;
            let record = *self.frames.record(frame)?;
            if !record.dropped && !self.is_settled(frame) {
                return None;
            }
            self.timing_cursor.next += 1;
            if !record.dropped {
                return Some((PacedFrameId(frame), self.timing(record.start, record.shown)));
            }
        }
    }

    fn is_settled(&self, frame: u64) -> bool {
        let Some(record) = self.frames.record(frame) else { return true };
        let age = self.frames.next() - frame;
        if record.shown.is_some() || age > PATIENCE_FRAMES {
            return true;
        }
        match self.presentation.reports {
            // A later frame was shown, so no report of this frame will come, or it was replaced.
            PresentReports::Times => {
                let later = self.frames.newest_first().take_while(|(id, _)| *id > frame);
                record.left && later.into_iter().any(|(_, record)| record.shown.is_some())
            }
            PresentReports::Missing => record.left && age > u64::from(self.presentation.images),
        }
    }

    fn timing(&mut self, start: f64, shown: Option<f64>) -> FrameTiming {
        let span = |ns: f64| Duration::from_nanos(ns.max(0.0).round() as u64);
        let period = self.period_ns();
        let in_refreshes = |ns: f64| period.map(|period| (ns / period).round() as u32);
        let present_interval =
            shown.zip(self.timing_cursor.last_shown).map(|(shown, last)| (shown - last).max(0.0));
        let refreshes = present_interval.and_then(in_refreshes);
        let latency = shown.map(|shown| shown - start);
        let intended = self
            .options
            .frame_limit_hz
            .map_or(1, |hz| in_refreshes(1.45 * SECOND_NS / hz).unwrap_or(1).max(1));
        let timing = FrameTiming {
            start_interval: self.timing_cursor.last_start.map(|last| span(start - last)),
            present_interval: present_interval.map(span),
            latency: latency.map(span),
            refreshes,
            latency_refreshes: latency.and_then(in_refreshes),
            missed: refreshes.map(|refreshes| refreshes.saturating_sub(intended)),
        };
        self.timing_cursor.last_start = Some(start);
        // A frame that was replaced before it was shown does not change the displayed image. For an
        // unknown frame, the duration of its display is unknown.
        if shown.is_some() || self.presentation.in_order() {
            self.timing_cursor.last_shown = shown;
        }
        timing
    }
}
