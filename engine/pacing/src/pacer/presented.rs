//! The records of presented frames: signs that they are visible, and their reported timings.

/// The absence of signs that frames are visible.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::pacer) struct Silence {
    /// The last time at which a frame was known to leave the queue, or the queue was not full.
    pub(in crate::pacer) since: f64,
    pub(in crate::pacer) hidden: bool,
}

/// The next timing to return, and the times with which it is compared.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::pacer) struct TimingCursor {
    pub(in crate::pacer) next: u64,
    pub(in crate::pacer) last_start: Option<f64>,
    pub(in crate::pacer) last_shown: Option<f64>,
}

impl TimingCursor {
    /// Notes that the next frame has no predecessor.
    pub(in crate::pacer) const fn interrupt(&mut self) {
        self.last_start = None;
        self.last_shown = None;
    }
}
