//! The knowledge of a device about the frames of its host.

use crate::core::device::Device;
use crate::core::tick::Tick;

impl Device {
    /// Returns the newest frame of which it is known if it runs, as it is of all before it: the
    /// newest submit of a device with a queue, and of a host's frames the newest that is over.
    /// Those that do not run are [lost](Device::is_lost).
    pub fn settled(&self) -> Tick {
        if self.has_queue() { self.submitted() } else { self.proven(self.submitted()) }
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
}
