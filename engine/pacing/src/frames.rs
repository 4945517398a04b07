//! The books: what is known of the newest frames, in a ring that never grows.

use crate::PacedFrameId;

/// Frames that are remembered: more than can be queued, and some for reports that come late.
pub(crate) const REMEMBERED: usize = 64;

/// One frame. Times in nanoseconds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Record {
    pub(crate) start: f64,
    /// The refresh it was to be shown at.
    pub(crate) target: Option<f64>,
    /// The clock's generation that foretold it.
    pub(crate) generation: u32,
    /// The margin it was given.
    pub(crate) margin: u32,
    /// It started later than was wanted, so that its miss says nothing of the margin.
    pub(crate) compromised: bool,
    /// Acquires return early or late; how long this one kept the CPU waiting.
    pub(crate) waited: f64,
    /// How many frames of this swapchain were queued before.
    pub(crate) ordinal: Option<u64>,
    pub(crate) queued: Option<f64>,
    pub(crate) finished: Option<f64>,
    /// When it was told to be finished.
    pub(crate) seen_finished: Option<f64>,
    /// `finished` is a guess between two looks.
    pub(crate) found: bool,
    /// The last time at which it was not known to be finished.
    pub(crate) unfinished: f64,
    pub(crate) gpu_timed: bool,
    pub(crate) shown: Option<f64>,
    /// It is queued no more: shown, replaced, dropped, or given up.
    pub(crate) left: bool,
    pub(crate) dropped: bool,
}

impl Record {
    /// Begun, and neither presented nor dropped yet.
    pub(crate) const fn open(&self) -> bool {
        self.queued.is_none() && !self.left
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Frames {
    records: [Record; REMEMBERED],
    next: u64,
    /// All before it have left.
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

    /// Returns the id after the newest.
    pub(crate) const fn next(&self) -> u64 {
        self.next
    }

    /// Returns the oldest that is remembered.
    pub(crate) const fn oldest(&self) -> u64 {
        self.next.saturating_sub(REMEMBERED as u64)
    }

    pub(crate) fn record(&self, frame: u64) -> Option<&Record> {
        (self.oldest()..self.next).contains(&frame).then(|| &self.records[Self::slot(frame)])
    }

    pub(crate) fn record_mut(&mut self, frame: u64) -> Option<&mut Record> {
        (self.oldest()..self.next).contains(&frame).then(|| &mut self.records[Self::slot(frame)])
    }

    /// Returns those that have not left, oldest first.
    pub(crate) fn queued(&self) -> impl Iterator<Item = (u64, &Record)> {
        (self.oldest_queued..self.next)
            .map(|frame| (frame, &self.records[Self::slot(frame)]))
            .filter(|(_, record)| !record.left)
    }

    pub(crate) fn oldest_queued(&self) -> Option<(u64, Record)> {
        self.queued().next().map(|(frame, record)| (frame, *record))
    }

    /// Returns the one that so many were presented before in this swapchain.
    pub(crate) fn of_ordinal(&self, ordinal: u64) -> Option<(u64, &Record)> {
        self.newest_first().find(|(_, record)| record.ordinal == Some(ordinal))
    }

    /// Nobody has told yet that these are finished.
    pub(crate) fn note_unfinished(&mut self, now: f64) {
        let oldest = self.next.saturating_sub(u64::from(crate::MAX_QUEUE_LIMIT)).max(self.oldest());
        for frame in oldest..self.next {
            let record = &mut self.records[Self::slot(frame)];
            if record.finished.is_none() {
                record.unfinished = now;
            }
        }
    }

    /// Times of before mean nothing any more.
    pub(crate) fn forget_all(&mut self) {
        self.records.fill(Record { left: true, dropped: true, ..Record::default() });
        self.skip_left();
    }

    /// There is a new swapchain: none is queued but what is being recorded, and counting begins
    /// anew.
    pub(crate) fn begin_anew(&mut self) {
        for record in &mut self.records {
            record.left |= !record.open();
            record.ordinal = None;
        }
        self.skip_left();
    }

    /// Returns all that are remembered, newest first.
    pub(crate) fn newest_first(&self) -> impl Iterator<Item = (u64, &Record)> {
        (self.oldest()..self.next).rev().map(|frame| (frame, &self.records[Self::slot(frame)]))
    }

    /// This one has left.
    pub(crate) fn leave(&mut self, frame: u64) {
        if let Some(record) = self.record_mut(frame) {
            record.left = true;
        }
        self.skip_left();
    }

    /// This one and all before it have left.
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
