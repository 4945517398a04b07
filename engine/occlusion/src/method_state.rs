//! What a method that goes by no plan keeps per view.

use std::any::Any;

use cull::FrameId;
use gpu::Tick;

use crate::outcomes::Outcomes;

/// What a method keeps per view.
pub trait MethodState: Any + Send {
    /// Reads results that are there into the outcomes of their frames. Returns the newest frame
    /// whose outcome it knows now. Never waits.
    fn collect(&mut self, _completed: Tick, _outcomes: &mut Outcomes) -> Option<FrameId> {
        None
    }

    /// Notes that the newest frame is on its way. Returns true if it will know the frame's outcome.
    fn submitted(&mut self, _tick: Tick, _frame: FrameId) -> bool {
        false
    }
}
