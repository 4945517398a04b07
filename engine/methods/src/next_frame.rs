//! Next-frame occlusion queries (GPU Gems, 29.4): a query for each object, whose result decides in
//! a later frame. Never waits, and its images are wrong until results arrive.

use cull::Strategy;
use gpu::Frame;
use occlusion::{
    CulledScene, Error, Method, MethodConstructor, MethodRequest, MethodStats, OcclusionState,
    ShadedObjects, ShaderSet, execute,
};

/// The strategy of this method.
pub const NEXT_FRAME: Strategy =
    Strategy::new("next_frame", "a query per object, used a frame later: it pops").inexact();

/// The method of plans in which no draw depends on a test of the same frame.
struct NextFrame;

/// Returns the method's constructor.
pub(crate) fn method() -> MethodConstructor {
    MethodConstructor::new(|| Box::new(NextFrame))
}

impl Method for NextFrame {
    fn strategies(&self) -> &[Strategy] {
        &[NEXT_FRAME]
    }

    fn record(
        &mut self,
        frame: &mut Frame<'_>,
        state: &mut OcclusionState,
        scene: &mut CulledScene,
        objects: &mut dyn ShadedObjects,
        request: &MethodRequest<'_>,
    ) -> Result<MethodStats, Error> {
        state.plan_next_frame(scene, request.view);
        execute(frame, scene, state, objects)?;
        Ok(MethodStats::of(state.plan()))
    }

    fn reloaded(
        &self,
        _scene: &CulledScene,
        _objects: &mut dyn ShadedObjects,
        _shaders: &ShaderSet,
    ) -> Result<Box<dyn Method>, Error> {
        Ok(Box::new(Self))
    }
}
