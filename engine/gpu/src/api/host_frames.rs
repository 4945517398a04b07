//! The knowledge of a device about the frames of its host.

use crate::core::device::Device;
use crate::core::executions::FrameStamp;
use crate::core::tick::Tick;

impl Device {
    /// Returns the newest frame that is known to run after those before it: the newest submit of a
    /// device with a queue, and of a host's frames the newest one that left its stamp.
    pub fn confirmed(&self) -> Tick {
        match self.has_queue() {
            true => self.submitted(),
            false => self.executions().confirmed(),
        }
    }

    /// Returns the number of times that frames of a host ran in another order than they were
    /// recorded. What frames share must be uploaded again whenever it grows.
    pub fn disorders(&self) -> u64 {
        self.executions().disorders()
    }

    /// Returns true for a frame of a host that is over and never ran: it left no answers.
    pub fn is_lost(&self, frame: Tick) -> bool {
        self.executions().is_lost(frame)
    }

    /// Notes the stamp of a frame of a host that is over. Frames are noted in their order.
    pub(crate) fn note_execution(&self, frame: Tick, stamp: FrameStamp) {
        let mut executions = self.executions();
        executions.note(frame, stamp);
        if executions.is_lost(frame) {
            tracing::debug!("frame {} of the host never ran: its answers are ignored", frame.0);
        }
    }
}
