//! A frame of a scene that is being recorded: changes are uploaded before it, every view is planned
//! before it is recorded, and the end of the frame reaches the scene and all its views.

use cull::{CullView, MultiView, Strategy};
use gpu::{Commands, Frame, Target, Tick, TimelineWait, Uploads};
use smallvec::SmallVec;

use crate::culled_scene::CulledScene;
use crate::draw_lists::DrawList;
use crate::error::Error;
use crate::execution::{ListedTests, execute, list_draws};
use crate::object_renderer::ObjectRenderer;
use crate::occlusion_state::OcclusionState;
use crate::shaded_objects::{ShadedObjects, Unshaded};
use crate::transparent_list::TransparentList;

/// The default limit of occlusion queries per view.
const QUERY_BUDGET: usize = 4096;

/// Values per view of a frame, without an allocation for a stereo pair or the faces of a cube.
pub type PerView<T> = SmallVec<[T; 6]>;

/// The request to draw one view, or several that are drawn at once to the layers of a target.
#[derive(Clone, Copy, Debug)]
pub struct DrawRequest<'v> {
    /// The views.
    pub views: MultiView<'v>,
    /// A strategy of plans. Default: [`Strategy::ANTUMBRA`].
    pub strategy: Strategy,
    /// The most occlusion queries; leaves that are left without one are drawn. Default: 4096.
    pub query_budget: usize,
}

impl<'v> From<&'v CullView> for DrawRequest<'v> {
    fn from(view: &'v CullView) -> Self {
        Self::from(MultiView::from(view))
    }
}

impl<'v> From<MultiView<'v>> for DrawRequest<'v> {
    fn from(views: MultiView<'v>) -> Self {
        Self { views, strategy: Strategy::ANTUMBRA, query_budget: QUERY_BUDGET }
    }
}

/// A frame of a scene that is being recorded. It borrows the scene and the views that it draws, so
/// that neither changes before the [end](FrameScope::end).
///
/// ```no_run
/// # use antumbra_occlusion as occlusion;
/// use cull::CullView;
/// use occlusion::*;
///
/// /// Records a frame of one view into the command buffer of a host.
/// fn record(
///     scene: &mut CulledScene,
///     frame: gpu::Frame<'_>, // of `FrameRing::begin_in`, or `FrameRing::begin`
///     state: &mut OcclusionState,
///     view: &CullView,
///     objects: &mut dyn ObjectRenderer,
/// ) -> Result<(), Error> {
///     let mut scope = scene.begin(frame)?;
///     scope.draw(state, view, objects)?;
///     scope.end()?;
///     Ok(())
/// }
/// ```
///
/// A view is drawn once per frame:
///
/// ```compile_fail,E0499
/// # use antumbra_occlusion as occlusion;
/// # use cull::CullView;
/// # use occlusion::*;
/// # fn record(
/// #     scene: &mut CulledScene,
/// #     frame: gpu::Frame<'_>,
/// #     mut state: OcclusionState,
/// #     view: &CullView,
/// #     objects: &mut dyn ObjectRenderer,
/// # ) -> Result<(), Error> {
/// let mut scope = scene.begin(frame)?;
/// scope.draw(&mut state, view, objects)?;
/// scope.draw(&mut state, view, objects)?; // error: borrowed until the end of the frame
/// scope.end()?;
/// # Ok(())
/// # }
/// ```
///
/// The scene stays as the frame uploaded it:
///
/// ```compile_fail,E0499
/// # use antumbra_occlusion as occlusion;
/// # use occlusion::*;
/// # fn record(scene: &mut CulledScene, frame: gpu::Frame<'_>) -> Result<(), Error> {
/// let scope = scene.begin(frame)?;
/// scene.remove(&[])?; // error: borrowed until the end of the frame
/// scope.end()?;
/// # Ok(())
/// # }
/// ```
#[must_use = "a frame without its end is given up"]
pub struct FrameScope<'a, 'ring> {
    scene: &'a mut CulledScene,
    frame: Frame<'ring>,
    drawn: PerView<&'a mut OcclusionState>,
    /// The number of views whose draws are listed and whose tests are not recorded yet.
    listed: usize,
    /// True after a view that could not be recorded: its commands may be in the frame in part.
    is_incomplete: bool,
}

/// A view whose frame is planned, to be [recorded](FrameScope::record) or
/// [listed](FrameScope::list) once.
#[must_use = "a plan that is not recorded draws nothing"]
pub struct PlannedView<'a> {
    state: &'a mut OcclusionState,
}

impl PlannedView<'_> {
    /// Returns the view, with its plan.
    pub fn state(&self) -> &OcclusionState {
        self.state
    }
}

/// A view whose draws are listed for a host that records them itself. The tests between them are
/// still to be [recorded](ListedView::record).
#[must_use = "the lists of revealed draws are undefined until the tests are recorded"]
pub struct ListedView<'a> {
    state: &'a mut OcclusionState,
    tests: ListedTests,
}

impl<'a, 'ring> FrameScope<'a, 'ring> {
    pub(crate) fn new(scene: &'a mut CulledScene, frame: Frame<'ring>) -> Self {
        Self { scene, frame, drawn: PerView::new(), listed: 0, is_incomplete: false }
    }

    /// Returns the command buffer, for commands of the owner between those of the engine.
    pub fn commands(&self) -> &Commands {
        self.frame.commands()
    }

    /// Returns the memory of the frame, for uploads of the owner.
    pub fn uploads(&mut self) -> &mut Uploads {
        self.frame.uploads()
    }

    /// Returns the scene as this frame draws it.
    pub fn scene(&self) -> &CulledScene {
        self.scene
    }

    /// Plans and records a view: what is taken as visible, tests of the rest, and what they reveal.
    /// Brings the target of `objects` to its exit state. To let several views share one budget of
    /// queries, [plan](FrameScope::plan_all) all of them first.
    ///
    /// # Errors
    /// [`Error::ForeignView`]; [`Error::InvalidView`] for a view with numbers that are not finite
    /// or without pixels; [`Error::NotPlanned`]; the errors of [`FrameScope::record`].
    pub fn draw<'v>(
        &mut self,
        state: &'a mut OcclusionState,
        request: impl Into<DrawRequest<'v>>,
        objects: &mut dyn ObjectRenderer,
    ) -> Result<(), Error> {
        let planned = self.plan(state, request)?;
        self.record(planned, objects)
    }

    /// Reads the results of earlier frames that are over, and plans a view by them.
    ///
    /// # Errors
    /// [`Error::ForeignView`], [`Error::InvalidView`], [`Error::NotPlanned`], a lost device.
    pub fn plan<'v>(
        &mut self,
        state: &'a mut OcclusionState,
        request: impl Into<DrawRequest<'v>>,
    ) -> Result<PlannedView<'a>, Error> {
        let request = request.into();
        check_request(&request)?;
        let DrawRequest { views, strategy, query_budget } = request;
        let completed = self.scene.device.completed()?;
        state.follow_frames_in_flight(self.scene)?;
        state.collect(completed, self.scene);
        state.plan_frame(self.scene, strategy, views, query_budget);
        Ok(PlannedView { state })
    }

    /// Plans several views with one budget of queries for all of them, in place of the budgets in
    /// their requests. Give the views in the same order in each frame.
    ///
    /// # Errors
    /// [`Error::ForeignView`], [`Error::InvalidView`], [`Error::NotPlanned`], a lost device. No
    /// view is planned then.
    pub fn plan_all<'v>(
        &mut self,
        views: impl IntoIterator<Item = (&'a mut OcclusionState, DrawRequest<'v>)>,
        query_budget: usize,
    ) -> Result<PerView<PlannedView<'a>>, Error> {
        let mut views: PerView<_> = views.into_iter().collect();
        let completed = self.scene.device.completed()?;
        for (_, request) in &views {
            check_request(request)?;
        }
        for (state, _) in &mut views {
            state.follow_frames_in_flight(self.scene)?;
        }
        let mut shares = std::mem::take(&mut self.scene.query_shares);
        let scene = &*self.scene;
        shares.plan_views(
            query_budget,
            &mut views,
            |(state, _)| state.plan().query_count(),
            |_, (state, request), share| {
                state.collect(completed, scene);
                state.plan_frame(scene, request.strategy, request.views, share);
            },
        );
        self.scene.query_shares = shares;
        Ok(views.into_iter().map(|(state, _)| PlannedView { state }).collect())
    }

    /// Records a planned view, and brings the target of `objects` to its exit state.
    ///
    /// # Errors
    /// A target with other attachments than the passes were compiled for, or with another number of
    /// views; a depth that the tests cannot read; no memory, a failed call.
    pub fn record(
        &mut self,
        planned: PlannedView<'a>,
        objects: &mut dyn ObjectRenderer,
    ) -> Result<(), Error> {
        self.record_shaded(planned, &mut Unshaded(objects))
    }

    /// Records a planned view of objects that are shaded in an order of their own, such as depth
    /// before colour.
    ///
    /// # Errors
    /// The errors of [`FrameScope::record`].
    pub fn record_shaded(
        &mut self,
        planned: PlannedView<'a>,
        objects: &mut dyn ShadedObjects,
    ) -> Result<(), Error> {
        let state = planned.state;
        let executed = execute(&mut self.frame, self.scene, state, objects);
        self.is_incomplete |= executed.is_err();
        executed?;
        objects.target().restore(self.frame.commands());
        self.drawn.push(state);
        Ok(())
    }

    /// Writes the transparent objects of a view into the memory of the frame.
    ///
    /// # Errors
    /// No memory, a failed call.
    pub fn upload_transparent(&mut self, objects: &mut TransparentList) -> Result<(), Error> {
        objects.write(&mut self.frame, &self.scene.passes)
    }

    /// Lists the draws of a planned view for a host that records them itself: it cannot be called
    /// back between commands, or does not support conditional rendering. Records clears alone.
    ///
    /// The order on the queue is: the [visible draws](ListedView::visible), in renderings of the
    /// host that clear; the [tests](ListedView::record), in the command buffer of this frame; the
    /// [revealed draws](ListedView::revealed), in renderings that keep the contents. All lists are
    /// known after this call; the GPU fills the revealed ones before the tests end. The buffers
    /// live until the frame is over.
    ///
    /// # Errors
    /// [`Error::DrawsAmongTests`] for a scene that was created without
    /// [`DrawPhases::Two`](cull::DrawPhases::Two); no memory, a failed call.
    pub fn list(&mut self, planned: PlannedView<'a>) -> Result<ListedView<'a>, Error> {
        let listed = list_draws(&mut self.frame, self.scene, planned.state);
        self.is_incomplete |= listed.is_err();
        let tests = listed?;
        self.listed += 1;
        Ok(ListedView { state: planned.state, tests })
    }

    /// Refuses a frame that lacks a view, and a frame whose lists of revealed draws are never
    /// filled.
    fn check_complete(&self) -> Result<(), Error> {
        if self.is_incomplete {
            return Err(Error::Incomplete);
        }
        if self.listed == 0 { Ok(()) } else { Err(Error::TestsMissing) }
    }

    /// Gives the frame back, for a host that records other scenes into it. Once the frame has
    /// ended, its tick goes to [`OcclusionState::submitted`] of each view that was drawn, and then
    /// to [`CulledScene::submitted`].
    ///
    /// # Errors
    /// [`Error::TestsMissing`], [`Error::Incomplete`]. The frame is given up then.
    pub fn into_frame(self) -> Result<Frame<'ring>, Error> {
        self.check_complete()?;
        Ok(self.frame)
    }

    /// Ends a frame in the command buffer of a host. Returns its number.
    ///
    /// # Errors
    /// [`Error::TestsMissing`], [`Error::Incomplete`]; [`gpu::Error::HasQueue`] on a device with a
    /// queue, whose frames are [submitted](FrameScope::submit); no memory, a failed call. The frame
    /// is given up then: its command buffer must not be submitted.
    pub fn end(self) -> Result<Tick, Error> {
        self.check_complete()?;
        let Self { scene, frame, drawn, .. } = self;
        let tick = frame.end()?;
        submitted(scene, drawn, tick);
        Ok(tick)
    }

    /// Submits a frame of the engine's own, with an optional wait on the GPU for a host's timeline.
    /// Returns its tick.
    ///
    /// # Errors
    /// [`Error::TestsMissing`], [`Error::Incomplete`], a failed call. The frame is given up then.
    pub fn submit(self, after: Option<TimelineWait<'_>>) -> Result<Tick, Error> {
        self.check_complete()?;
        let Self { scene, frame, drawn, .. } = self;
        let tick = frame.submit(after)?;
        submitted(scene, drawn, tick);
        Ok(tick)
    }
}

/// Refuses views that nothing can be drawn by, and strategies that no plan carries out. The cost is
/// per view and not per object.
fn check_request(request: &DrawRequest<'_>) -> Result<(), Error> {
    if !Strategy::PLANNED.contains(&request.strategy) {
        return Err(Error::NotPlanned(request.strategy));
    }
    Ok(request.views.as_slice().iter().try_for_each(cull::check_view)?)
}

fn submitted(scene: &mut CulledScene, drawn: PerView<&mut OcclusionState>, tick: Tick) {
    for state in drawn {
        state.submitted(tick, scene, None);
    }
    scene.submitted(tick);
}

impl<'a> ListedView<'a> {
    /// Returns the draws that are taken as visible, a list per bucket.
    pub fn visible(&self) -> &[DrawList] {
        self.state.visible_lists()
    }

    /// Returns the draws that the tests reveal, a list per bucket.
    pub fn revealed(&self) -> &[DrawList] {
        self.state.revealed_lists()
    }

    /// Returns the view, with its plan.
    pub fn state(&self) -> &OcclusionState {
        self.state
    }

    /// Records the tests against the depth in `target`, which holds the visible draws, and the
    /// passes that list what they reveal. Outside of rendering. Brings the target to its exit
    /// state. Colours of the target, if it has any, are not written.
    ///
    /// # Errors
    /// A target with other attachments than the passes were compiled for, or with another number of
    /// views; a depth that the tests cannot read; a failed call.
    pub fn record(self, scope: &mut FrameScope<'a, '_>, target: &mut Target) -> Result<(), Error> {
        let recorded = self.tests.record(&mut scope.frame, scope.scene, self.state, target);
        scope.is_incomplete |= recorded.is_err();
        recorded?;
        target.restore(scope.frame.commands());
        scope.listed = scope.listed.saturating_sub(1);
        scope.drawn.push(self.state);
        Ok(())
    }
}
