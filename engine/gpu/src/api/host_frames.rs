//! The state of a host's frames as the device knows it.

use crate::core::device::Device;
use crate::core::tick::Tick;

impl Device {
    /// Returns the newest frame for which it is known if it and all earlier frames run. On a device
    /// with a queue this is the newest submit; otherwise it is the newest frame of the host that is
    /// over. Frames that do not run are [lost](Device::is_lost).
    pub fn settled(&self) -> Tick {
        if self.has_queue() { self.submitted() } else { self.proven(self.submitted()) }
    }

    /// Returns the number of times that frames of a host ran in another order than recorded.
    /// Whenever it increases, data that frames share must be uploaded again.
    pub fn disorders(&self) -> u64 {
        self.executions().disorders()
    }

    /// Returns true if a frame of a host is over and never ran, so that it left no answers.
    pub fn is_lost(&self, frame: Tick) -> bool {
        self.executions().is_lost(frame)
    }
}
