//! The state per view of a method without plans.

use std::any::Any;

use cull::FrameId;
use gpu::Tick;

use crate::outcomes::Outcomes;

/// The state of a method per view.
pub trait MethodState: Any + Send {
    /// Writes available results into the outcomes of their frames. Returns the newest frame with a
    /// known outcome. Never waits.
    fn collect(&mut self, _completed: Tick, _outcomes: &mut Outcomes) -> Option<FrameId> {
        None
    }

    /// Notes that the newest frame was submitted. Returns true if this state will report the
    /// outcome of the frame.
    fn submitted(&mut self, _tick: Tick, _frame: FrameId) -> bool {
        false
    }
}
