//! The trait of all methods that decide what is drawn: Antumbra's own and those of the literature.

use std::fmt;
use std::sync::Arc;

use cull::{CullView, FramePlan, LeafIndex, Strategy};
use gpu::{Frame, OptionalFeature, Tick, Timeline};

use crate::culled_scene::CulledScene;
use crate::error::{BucketError, Error};
use crate::occlusion_state::OcclusionState;
use crate::shaded_objects::ShadedObjects;
use crate::shader_set::ShaderSet;

/// A method to decide what a view draws. One method serves all views of a scene; its data per view
/// is a [`MethodState`](crate::MethodState).
pub trait Method: Send {
    /// Returns the strategies that it carries out.
    fn strategies(&self) -> &[Strategy];

    /// Refuses a device, scene or threshold that it cannot work with.
    ///
    /// # Errors
    /// The name of what is missing or too large.
    fn supports(&self, _strategy: Strategy, _support: &MethodSupport<'_>) -> Result<(), Error> {
        Ok(())
    }

    /// Creates its objects on the device, before the first frame that it records.
    ///
    /// # Errors
    /// No memory, a shader that does not compile, a failed call.
    fn prepare(
        &mut self,
        _scene: &CulledScene,
        _objects: &mut dyn ShadedObjects,
        _shaders: &ShaderSet,
    ) -> Result<(), Error> {
        Ok(())
    }

    /// Plans one view's frame with at most `query_budget` queries, after all available results were
    /// read. All views of a frame are planned before the first is recorded, in any order
    /// ([`QueryShares`](cull::QueryShares)). Methods that decide while they record do nothing here.
    fn plan(
        &mut self,
        _state: &mut OcclusionState,
        _scene: &CulledScene,
        _request: &MethodRequest<'_>,
        _query_budget: usize,
    ) {
    }

    /// Records one view's frame.
    ///
    /// # Errors
    /// No memory, a lost device, a result that takes too long.
    fn record(
        &mut self,
        frame: &mut Frame<'_>,
        state: &mut OcclusionState,
        scene: &mut CulledScene,
        objects: &mut dyn ShadedObjects,
        request: &MethodRequest<'_>,
    ) -> Result<MethodStats, Error>;

    /// Returns the same method with other shaders.
    ///
    /// # Errors
    /// A shader that does not fit its pass, a failed call.
    fn reloaded(
        &self,
        scene: &CulledScene,
        objects: &mut dyn ShadedObjects,
        shaders: &ShaderSet,
    ) -> Result<Box<dyn Method>, Error>;

    /// Drops its objects that depend on the size of the target, after a change of it.
    fn resized(&mut self) {}
}

/// The constructor of a method, with the options of the method. Nothing of the device is used yet.
#[derive(Clone)]
pub struct MethodConstructor(Arc<dyn Fn() -> Box<dyn Method> + Send + Sync>);

impl MethodConstructor {
    /// Creates a constructor from a closure.
    pub fn new(construct: impl Fn() -> Box<dyn Method> + Send + Sync + 'static) -> Self {
        Self(Arc::new(construct))
    }

    /// Constructs the method.
    pub fn construct(&self) -> Box<dyn Method> {
        (self.0)()
    }
}

impl fmt::Debug for MethodConstructor {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_list().entries(self.construct().strategies()).finish()
    }
}

/// The scene and the image that a method must support.
#[derive(Clone, Copy)]
pub struct MethodSupport<'a> {
    /// The scene.
    pub scene: &'a CulledScene,
    /// Size of the target in pixels.
    pub size: [u32; 2],
    /// The most samples of a test that still counts as hidden in the plans of the scene's views.
    pub threshold_samples: u32,
}

impl MethodSupport<'_> {
    /// Refuses a table with buckets, for a strategy that works with one draw per leaf.
    ///
    /// # Errors
    /// [`BucketError::HasBuckets`].
    pub fn needs_one_draw_per_leaf(&self, strategy: Strategy) -> Result<(), Error> {
        if self.scene.leaves.has_one_draw_per_leaf() {
            Ok(())
        } else {
            Err(BucketError::HasBuckets(strategy).into())
        }
    }

    /// Returns the error for a strategy that the device lacks something for.
    pub fn missing(&self, missing: OptionalFeature, strategy: Strategy) -> Error {
        let device = self.scene.device.adapter().name.clone();
        gpu::Error::Unsupported { device, missing: missing.name(), wanted: strategy.name() }.into()
    }
}

/// The request for a frame of one view.
#[derive(Clone, Copy)]
pub struct MethodRequest<'a> {
    /// The strategy to use, one of the method's.
    pub strategy: Strategy,
    /// The camera's matrix, its volumes and its part of the image.
    pub view: &'a CullView,
    /// The leaves that own a pixel, for strategies with [objects found
    /// beforehand](Strategy::needs_still_scene); empty for others.
    pub visible: &'a [LeafIndex],
    /// The tick of a host's timeline that the frame waits for on the GPU.
    pub after: Option<(&'a Timeline, Tick)>,
}

/// The counts of a method in a frame of one view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MethodStats {
    /// Proxies tested, by any tester.
    pub tests: u32,
    /// Occlusion queries recorded, those on draws included.
    pub queries: u32,
}

impl MethodStats {
    /// Returns those of a plan that is executed.
    pub fn of(plan: &FramePlan) -> Self {
        Self { tests: plan.tests.len() as u32, queries: plan.query_count() as u32 }
    }
}
