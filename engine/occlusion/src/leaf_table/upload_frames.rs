//! The frames that uploaded the changes of a table. A frame of the device need not contain every
//! table, and a host may never submit a frame.

use std::collections::VecDeque;

use gpu::Tick;

/// The frames that uploaded everything marked in a table.
#[derive(Debug, Default)]
pub(super) struct UploadFrames {
    /// The frames that are not yet known to run or to be lost, in their order.
    sent: VecDeque<Tick>,
    /// The newest frame that is known to run.
    ran: Tick,
}

impl UploadFrames {
    /// Notes a frame that uploads everything marked.
    pub(super) fn sent(&mut self, frame: Tick) {
        self.sent.push_back(frame);
    }

    /// Returns the newest frame that is known to run. All frames up to `settled` run, except those
    /// for which `is_lost` returns true.
    pub(super) fn newest_run(&mut self, settled: Tick, is_lost: impl Fn(Tick) -> bool) -> Tick {
        while let Some(frame) = self.sent.pop_front_if(|frame| *frame <= settled) {
            if !is_lost(frame) {
                self.ran = frame;
            }
        }
        self.ran
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_other_tables_prove_nothing() {
        let mut frames = UploadFrames::default();
        [3, 7].into_iter().for_each(|frame| frames.sent(Tick(frame)));
        let is_lost = |frame| frame == Tick(3);
        assert_eq!(frames.newest_run(Tick(2), is_lost), Tick::ZERO);
        assert_eq!(frames.newest_run(Tick(6), is_lost), Tick::ZERO, "5 ran without this table");
        assert_eq!(frames.newest_run(Tick(7), is_lost), Tick(7));
        assert_eq!(frames.newest_run(Tick(9), is_lost), Tick(7));
    }
}
