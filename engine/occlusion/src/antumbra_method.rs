//! Antumbra's own method: coherent hierarchical culling (GPU Gems 2, 6.4) with results that are
//! read in later frames, made exact by predicates. Plain frustum culling is a plan without tests.

use cull::Strategy;
use gpu::{Frame, OptionalFeature};

use crate::culled_scene::CulledScene;
use crate::error::{CannotCount, Error};
use crate::execution::execute;
use crate::method::{Method, MethodRequest, MethodStats, MethodSupport};
use crate::occlusion_state::OcclusionState;
use crate::passes::ComputeTest;
use crate::shaded_objects::ShadedObjects;
use crate::shader_set::ShaderSet;

/// The method that plans a frame and executes the plan.
#[derive(Clone, Copy, Debug, Default)]
pub struct AntumbraMethod;

impl Method for AntumbraMethod {
    fn strategies(&self) -> &[Strategy] {
        &Strategy::PLANNED
    }

    fn supports(&self, strategy: Strategy, support: &MethodSupport<'_>) -> Result<(), Error> {
        let MethodSupport { scene, size, threshold_samples } = *support;
        let counts_nothing = strategy.culls_occluded() && !strategy.has_sample_threshold();
        if counts_nothing && threshold_samples > 0 {
            return Err(CannotCount { strategy, threshold_samples }.into());
        }
        if strategy == Strategy::ANTUMBRA_COMPUTE {
            ComputeTest::check(&scene.device, size)?;
        }
        if strategy == Strategy::ANTUMBRA_FLAGS && !scene.passes.proxies.can_flag() {
            return Err(support.missing(OptionalFeature::FragmentStores, strategy));
        }
        Ok(())
    }

    fn plan(
        &mut self,
        state: &mut OcclusionState,
        scene: &CulledScene,
        request: &MethodRequest<'_>,
        query_budget: usize,
    ) {
        state.plan_frame(scene, request.strategy, request.view, query_budget);
    }

    fn record(
        &mut self,
        frame: &mut Frame<'_>,
        state: &mut OcclusionState,
        scene: &mut CulledScene,
        objects: &mut dyn ShadedObjects,
        _request: &MethodRequest<'_>,
    ) -> Result<MethodStats, Error> {
        execute(frame, scene, state, objects)?;
        Ok(MethodStats::of(state.plan()))
    }

    fn reloaded(
        &self,
        _scene: &CulledScene,
        _objects: &mut dyn ShadedObjects,
        _shaders: &ShaderSet,
    ) -> Result<Box<dyn Method>, Error> {
        Ok(Box::new(*self))
    }
}
