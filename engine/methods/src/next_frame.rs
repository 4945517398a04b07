//! Next-frame occlusion queries (GPU Gems, 29.4): a query per object that is read in a later frame
//! and decides about that one. Never waits, and is wrong until its results are read back.

use cull::{BlockingOptions, Strategy};
use gpu::Frame;
use occlusion::{
    Error, Method, MethodRequest, MethodScene, MethodStats, PlannedMethod, VisibilityState,
};

/// The method of plans in which no draw depends on the tests of the frame.
struct NextFrame;

/// Creates the method.
pub(crate) fn method(_options: &BlockingOptions) -> Box<dyn Method> {
    Box::new(NextFrame)
}

impl Method for NextFrame {
    fn carries_out(&self, strategy: Strategy) -> bool {
        strategy == Strategy::NextFrame
    }

    fn record(
        &mut self,
        frame: &mut Frame<'_>,
        state: &mut VisibilityState,
        scene: &mut MethodScene<'_>,
        request: &MethodRequest<'_>,
    ) -> Result<MethodStats, Error> {
        PlannedMethod::record_planned(frame, state, scene, request)
    }

    fn reloaded(&self, _scene: &mut MethodScene<'_>) -> Result<Box<dyn Method>, Error> {
        Ok(Box::new(Self))
    }
}
