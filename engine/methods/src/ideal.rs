//! The ideal (the optimum of the papers on coherent hierarchical culling): draws exactly the
//! objects that own a pixel, which were found in advance, and tests nothing. It is the lower bound
//! of every method, for comparison only.

use cull::Strategy;
use gpu::{Frame, OptionalFeature};
use occlusion::{
    CulledScene, Error, Method, MethodConstructor, MethodRequest, MethodStats, MethodSupport,
    OcclusionState, ShadedObjects, ShaderSet, execute,
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

    /// Checks that fragment shaders can write to buffers, which the search for visible objects
    /// needs.
    fn supports(&self, strategy: Strategy, support: &MethodSupport<'_>) -> Result<(), Error> {
        if support.scene.device().capabilities().has(OptionalFeature::FragmentStores) {
            return Ok(());
        }
        Err(support.missing(OptionalFeature::FragmentStores, strategy))
    }

    fn record(
        &mut self,
        frame: &mut Frame<'_>,
        state: &mut OcclusionState,
        scene: &mut CulledScene,
        objects: &mut dyn ShadedObjects,
        request: &MethodRequest<'_>,
    ) -> Result<MethodStats, Error> {
        state.plan_known(scene, request.view, request.visible);
        execute(frame, scene, state, objects)?;
        Ok(MethodStats::default())
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
