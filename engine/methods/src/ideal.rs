//! The ideal (the optimum of the papers on coherent hierarchical culling): draws exactly the
//! objects that own a pixel, found beforehand, and tests nothing. The lower bound of every method,
//! for comparison only.

use cull::Strategy;
use gpu::{Frame, OptionalFeature};
use occlusion::{
    Error, Method, MethodConstructor, MethodRequest, MethodScene, MethodStats, MethodSupport,
    OcclusionState, execute,
};

/// The strategy of this method.
pub const IDEAL: Strategy =
    Strategy::new("ideal", "the bound: the exact visible set, found in advance").in_still_scenes();

/// The method that draws the known visible leaves.
struct Ideal;

/// Returns the method's constructor.
pub(crate) fn method() -> MethodConstructor {
    MethodConstructor::new(|| Box::new(Ideal))
}

impl Method for Ideal {
    fn strategies(&self) -> &[Strategy] {
        &[IDEAL]
    }

    /// Checks that fragment shaders can write to buffers, which finding the visible objects takes.
    fn supports(&self, strategy: Strategy, support: &MethodSupport<'_>) -> Result<(), Error> {
        if support.device.capabilities().has(OptionalFeature::FragmentStores) {
            return Ok(());
        }
        Err(support.missing(OptionalFeature::FragmentStores, strategy))
    }

    fn record(
        &mut self,
        frame: &mut Frame<'_>,
        state: &mut OcclusionState,
        scene: &mut MethodScene<'_>,
        request: &MethodRequest<'_>,
    ) -> Result<MethodStats, Error> {
        let MethodScene { hierarchy, executor, objects, shaders, .. } = scene;
        state.plan_known(hierarchy, &executor.leaves, request.visible);
        execute(frame, executor, state, *objects, shaders, request.view)?;
        Ok(MethodStats::default())
    }

    fn reloaded(&self, _scene: &mut MethodScene<'_>) -> Result<Box<dyn Method>, Error> {
        Ok(Box::new(Self))
    }
}
