//! The trait of all methods that decide what is drawn: Antumbra's own and the published ones.

use std::fmt;
use std::sync::Arc;

use cull::{CullView, FramePlan, LeafIndex, Strategy};
use gpu::{Frame, OptionalFeature, TimelineWait};

use crate::culled_scene::CulledScene;
use crate::error::{BucketError, Error};
use crate::occlusion_state::OcclusionState;
use crate::shaded_objects::ShadedObjects;
use crate::shader_set::ShaderSet;

/// A method that decides what a view draws. One method serves all views of a scene; its data per
/// view is a [`MethodState`](crate::MethodState).
pub trait Method: Send {
    /// Returns the strategies that the method carries out.
    fn strategies(&self) -> &[Strategy];

    /// Refuses a device, scene or threshold that the method does not support.
    ///
    /// # Errors
    /// The name of what is missing or too large.
    fn supports(&self, _strategy: Strategy, _support: &MethodSupport<'_>) -> Result<(), Error> {
        Ok(())
    }

    /// Creates the GPU objects of the method, before the first frame that it records.
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

    /// Plans one view's frame with at most `query_budget` queries, after all available results have
    /// been read. All views of a frame are planned, in any order, before the first is recorded
    /// ([`QueryShares`](cull::QueryShares)). A method that decides while it records does nothing
    /// here.
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

    /// Returns the method with other shaders.
    ///
    /// # Errors
    /// A shader that does not fit its pass, a failed call.
    fn reloaded(
        &self,
        scene: &CulledScene,
        objects: &mut dyn ShadedObjects,
        shaders: &ShaderSet,
    ) -> Result<Box<dyn Method>, Error>;

    /// Drops the objects that depend on the size of the target, after it has changed.
    fn resized(&mut self) {}
}

/// The constructor of a method, with the method's options. Constructing does not use the device.
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
    /// The highest number of samples of a test that counts as hidden in plans of the scene's views.
    pub threshold_samples: u32,
}

impl MethodSupport<'_> {
    /// Refuses a table with buckets, for a strategy that needs one draw per leaf.
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

    /// Returns the error for a strategy that needs a feature which the device lacks.
    pub fn missing(&self, missing: OptionalFeature, strategy: Strategy) -> Error {
        let device = self.scene.device.adapter().name.clone();
        gpu::Error::Unsupported { device, missing: missing.name(), wanted: strategy.name() }.into()
    }
}

/// The request for a frame of one view.
#[derive(Clone, Copy)]
pub struct MethodRequest<'a> {
    /// The strategy to use, one of the strategies of the method.
    pub strategy: Strategy,
    /// The view: matrix, frustum, and part of the image.
    pub view: &'a CullView,
    /// The leaves that own a pixel, for strategies that [need to know them in
    /// advance](Strategy::needs_still_scene); empty for others.
    pub visible: &'a [LeafIndex],
    /// The tick of a host's timeline that the frame waits for on the GPU.
    pub after: Option<TimelineWait<'a>>,
}

/// The counts of a method in a frame of one view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MethodStats {
    /// The number of proxies tested, by any tester.
    pub tests: u32,
    /// The number of occlusion queries recorded, including queries on draws.
    pub queries: u32,
}

impl MethodStats {
    /// Returns the counts of a plan that is executed.
    pub fn of(plan: &FramePlan) -> Self {
        Self { tests: plan.tests.len() as u32, queries: plan.query_count() as u32 }
    }
}
