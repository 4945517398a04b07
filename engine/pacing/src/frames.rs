//! The records of the newest frames, in a ring that never grows.

use crate::PacedFrameId;

/// The number of frames that are remembered: more than can be queued, plus some for late reports.
pub(crate) const REMEMBERED: usize = 64;

/// The record of one frame, with times in nanoseconds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Record {
    pub(crate) start: f64,
    /// The refresh for which the frame was planned.
    pub(crate) target: Option<f64>,
    /// The generation of the clock that predicted the target.
    pub(crate) generation: u32,
    /// The version of the margin with which it was planned.
    pub(crate) margin: u32,
    /// True if it started later than wanted, so that its miss says nothing about the margin.
    pub(crate) compromised: bool,
    /// The time for which its acquire blocked.
    pub(crate) waited: f64,
    /// The number of frames that were queued to this swapchain before it.
    pub(crate) ordinal: Option<u64>,
    pub(crate) queued: Option<f64>,
    pub(crate) finished: Option<f64>,
    /// The time at which it was reported finished.
    pub(crate) seen_finished: Option<f64>,
    /// True if `finished` is a guess between two polls.
    pub(crate) found: bool,
    /// The last time at which it was not known to be finished.
    pub(crate) unfinished: f64,
    pub(crate) gpu_timed: bool,
    pub(crate) shown: Option<f64>,
    /// True once it is no longer queued: it was shown, replaced, dropped, or given up.
    pub(crate) left: bool,
    pub(crate) dropped: bool,
}

impl Record {
    /// Returns true if it was neither presented nor dropped yet.
    pub(crate) const fn open(&self) -> bool {
        self.queued.is_none() && !self.left
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Frames {
    records: [Record; REMEMBERED],
    next: u64,
    /// The oldest queued frame: all earlier frames have left.
    oldest_queued: u64,
}

impl Frames {
    pub(crate) fn new() -> Self {
        Self { records: [Record::default(); REMEMBERED], next: 0, oldest_queued: 0 }
    }

    pub(crate) fn begin(&mut self, record: Record) -> PacedFrameId {
        let frame = PacedFrameId(self.next);
        self.next += 1;
        self.oldest_queued = self.oldest_queued.max(self.oldest());
        self.records[Self::slot(frame.0)] = record;
        frame
    }

    /// Returns the id of the next frame.
    pub(crate) const fn next(&self) -> u64 {
        self.next
    }

    /// Returns the oldest frame that is remembered.
    pub(crate) const fn oldest(&self) -> u64 {
        self.next.saturating_sub(REMEMBERED as u64)
    }

    pub(crate) fn record(&self, frame: u64) -> Option<&Record> {
        (self.oldest()..self.next).contains(&frame).then(|| &self.records[Self::slot(frame)])
    }

    pub(crate) fn record_mut(&mut self, frame: u64) -> Option<&mut Record> {
        (self.oldest()..self.next).contains(&frame).then(|| &mut self.records[Self::slot(frame)])
    }

    /// Returns the frames that have not left, oldest first.
    pub(crate) fn queued(&self) -> impl Iterator<Item = (u64, &Record)> {
        (self.oldest_queued..self.next)
            .map(|frame| (frame, &self.records[Self::slot(frame)]))
            .filter(|(_, record)| !record.left)
    }

    pub(crate) fn oldest_queued(&self) -> Option<(u64, Record)> {
        self.queued().next().map(|(frame, record)| (frame, *record))
    }

    /// Returns the frame with this ordinal in the swapchain.
    pub(crate) fn of_ordinal(&self, ordinal: u64) -> Option<(u64, &Record)> {
        self.newest_first().find(|(_, record)| record.ordinal == Some(ordinal))
    }

    /// Notes that frames without a report were not finished yet at this time.
    pub(crate) fn note_unfinished(&mut self, now: f64) {
        let oldest = self.next.saturating_sub(u64::from(crate::MAX_QUEUE_LIMIT)).max(self.oldest());
        for frame in oldest..self.next {
            let record = &mut self.records[Self::slot(frame)];
            if record.finished.is_none() {
                record.unfinished = now;
            }
        }
    }

    /// Forgets all times, after the caller's clock was set.
    pub(crate) fn forget_all(&mut self) {
        self.records.fill(Record { left: true, dropped: true, ..Record::default() });
        self.skip_left();
    }

    /// Starts over with a new swapchain: only the frame that is being recorded can still be queued,
    /// and ordinals restart.
    pub(crate) fn restart(&mut self) {
        for record in &mut self.records {
            record.left |= !record.open();
            record.ordinal = None;
        }
        self.skip_left();
    }

    /// Returns all remembered frames, newest first.
    pub(crate) fn newest_first(&self) -> impl Iterator<Item = (u64, &Record)> {
        (self.oldest()..self.next).rev().map(|frame| (frame, &self.records[Self::slot(frame)]))
    }

    /// Notes that this frame has left the queue.
    pub(crate) fn leave(&mut self, frame: u64) {
        if let Some(record) = self.record_mut(frame) {
            record.left = true;
        }
        self.skip_left();
    }

    /// Notes that this frame and all earlier frames have left the queue.
    pub(crate) fn leave_through(&mut self, frame: u64) {
        for older in self.oldest_queued..=frame.min(self.next.saturating_sub(1)) {
            self.records[Self::slot(older)].left = true;
        }
        self.skip_left();
    }

    fn skip_left(&mut self) {
        while self.oldest_queued < self.next && self.records[Self::slot(self.oldest_queued)].left {
            self.oldest_queued += 1;
        }
    }

    const fn slot(frame: u64) -> usize {
        (frame % REMEMBERED as u64) as usize
    }
}
