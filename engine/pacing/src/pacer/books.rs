//! What a pacer keeps of frames that were handed over: what is heard of them, what was said of
//! them.

/// Whether anything is heard of the frames that were handed over.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::pacer) struct Silence {
    /// When a frame was last known to leave the queue, or the queue was last not full.
    pub(in crate::pacer) since: f64,
    pub(in crate::pacer) hidden: bool,
}

/// Frames handed out, and what their successors are compared with.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::pacer) struct Ledger {
    pub(in crate::pacer) next: u64,
    pub(in crate::pacer) last_start: Option<f64>,
    pub(in crate::pacer) last_shown: Option<f64>,
}

impl Ledger {
    /// What comes now has no neighbour.
    pub(in crate::pacer) const fn interrupt(&mut self) {
        self.last_start = None;
        self.last_shown = None;
    }
}
