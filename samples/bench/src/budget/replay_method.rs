//! The method that records frames of Antumbra's method, and draws parts of them.

use std::sync::{Arc, Mutex, PoisonError};

use antumbra::cull::{Hierarchy, LeafIndex, QueryKind, Strategy};
use antumbra::gpu::Frame;
use antumbra::occlusion::{
    AntumbraMethod, CulledScene, Error, Method, MethodConstructor, MethodRequest, MethodStats,
    OcclusionState, ShadedObjects, ShaderSet,
};

use super::ablation::Ablation;
use super::frame_record::FrameRecord;

/// The frames of a walk, shared by the program and its method.
#[derive(Debug, Default)]
pub(super) struct WalkRecord {
    pub(super) frames: Vec<FrameRecord>,
    /// The frame that is drawn next.
    pub(super) next: usize,
    /// True while frames are planned anew: their plans are kept.
    pub(super) is_planning: bool,
    /// The frame whose results the next planning reads, if they are to be kept.
    pub(super) observed: Option<usize>,
}

/// The method of all ablations.
struct ReplayMethod {
    record: Arc<Mutex<WalkRecord>>,
    strategies: [Strategy; Ablation::ALL.len()],
}

/// Returns the constructor of the method.
pub(super) fn method(record: &Arc<Mutex<WalkRecord>>) -> MethodConstructor {
    let record = Arc::clone(record);
    MethodConstructor::new(move || Box::new(ReplayMethod::new(Arc::clone(&record))))
}

impl ReplayMethod {
    fn new(record: Arc<Mutex<WalkRecord>>) -> Self {
        Self { record, strategies: Ablation::ALL.map(Ablation::strategy) }
    }
}

impl Method for ReplayMethod {
    fn strategies(&self) -> &[Strategy] {
        &self.strategies
    }

    fn plan(
        &mut self,
        state: &mut OcclusionState,
        scene: &CulledScene,
        request: &MethodRequest<'_>,
        query_budget: usize,
    ) {
        let mut record = self.record.lock().unwrap_or_else(PoisonError::into_inner);
        let record = &mut *record;
        if let Some(observed) = record.observed.take()
            && let Some(frame) = record.frames.get_mut(observed)
        {
            frame.revealed = revealed(state, scene.hierarchy());
        }
        let Some(frame) = record.frames.get_mut(record.next) else { return };
        match Ablation::of(request.strategy) {
            Some(Ablation::Whole) | None => {
                state.plan_frame(scene, Strategy::ANTUMBRA, request.view, query_budget);
                if record.is_planning {
                    frame.plan = state.plan().clone();
                }
            }
            Some(ablation) => {
                state.plan_given(scene, request.view, |plan| frame.write_plan(ablation, plan));
            }
        }
    }

    fn record(
        &mut self,
        frame: &mut Frame<'_>,
        state: &mut OcclusionState,
        scene: &mut CulledScene,
        objects: &mut dyn ShadedObjects,
        request: &MethodRequest<'_>,
    ) -> Result<MethodStats, Error> {
        AntumbraMethod.record(frame, state, scene, objects, request)
    }

    fn reloaded(
        &self,
        _scene: &CulledScene,
        _objects: &mut dyn ShadedObjects,
        _shaders: &ShaderSet,
    ) -> Result<Box<dyn Method>, Error> {
        Ok(Box::new(Self::new(Arc::clone(&self.record))))
    }
}

/// Returns the leaves that the tests of the newest frame revealed. Its results must be home.
fn revealed(state: &OcclusionState, hierarchy: &Hierarchy) -> Vec<LeafIndex> {
    let shown = state.newest_answers().iter().filter(|answer| answer.shows());
    let draws =
        shown.filter(|answer| matches!(answer.tag.kind, QueryKind::Proxy | QueryKind::Leaf));
    draws.flat_map(|answer| hierarchy.leaves(answer.tag.node).iter()).collect()
}
