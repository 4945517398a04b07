//! The plans of a view. Each is made for a state of the scene and for views, and executed once.

use cull::{CullView, Culler, FramePlan, LeafIndex, MultiView, Strategy};
use gpu::{DrawRange, Frame};

use super::super::OcclusionState;
use crate::culled_scene::CulledScene;
use crate::error::Error;

impl OcclusionState {
    /// Returns the views that the newest plan was made for. The plan is executed once, for the
    /// scene as it was then.
    pub(crate) fn planned_views(&self, scene: &CulledScene) -> Result<&[CullView], Error> {
        self.check(scene)?;
        if self.planned == Some(scene.leaves.version) {
            Ok(&self.planned_views)
        } else {
            Err(Error::NoPlan)
        }
    }

    /// Takes the views of the newest plan, which cannot be executed again.
    pub(crate) fn take_planned_views(&mut self) -> Vec<CullView> {
        self.planned = None;
        std::mem::take(&mut self.planned_views)
    }

    /// Returns the memory of the views of a plan for reuse.
    pub(crate) fn keep_planned_views(&mut self, views: Vec<CullView>) {
        self.planned_views = views;
    }

    /// Plans the next frame of a view, or of several views drawn at once, and lays out its tests.
    /// Call it after all changes of the scene were uploaded. The plan can be executed once, for
    /// these views. Does nothing for a scene other than the view's own, and for views that
    /// [`cull::check_view`] refuses: an execution is then refused by [`Error::NoPlan`].
    pub fn plan_frame<'v>(
        &mut self,
        scene: &CulledScene,
        strategy: Strategy,
        views: impl Into<MultiView<'v>>,
        query_budget: usize,
    ) {
        let views = views.into();
        self.plan_by(scene, views.as_slice(), |culler, plan| {
            culler.plan(&scene.hierarchy, strategy, views, query_budget, plan);
        });
    }

    /// Plans a frame of next-frame queries ([`Culler::plan_next_frame`]) and lays out its tests.
    pub fn plan_next_frame(&mut self, scene: &CulledScene, view: &CullView) {
        self.plan_by(scene, std::slice::from_ref(view), |culler, plan| {
            culler.plan_next_frame(&scene.hierarchy, view, plan);
        });
    }

    /// Plans a frame of a view that draws the leaves in `visible` and tests nothing.
    pub fn plan_known(&mut self, scene: &CulledScene, view: &CullView, visible: &[LeafIndex]) {
        self.plan_by(scene, std::slice::from_ref(view), |culler, plan| {
            culler.plan_known(&scene.hierarchy, visible, plan);
        });
    }

    /// Plans a frame of a view as `write` fills an empty plan: a frame that was recorded before, or
    /// a part of it. The caller answers for what is drawn.
    pub fn plan_given(
        &mut self,
        scene: &CulledScene,
        view: &CullView,
        write: impl FnOnce(&mut FramePlan),
    ) {
        self.plan_by(scene, std::slice::from_ref(view), |culler, plan| {
            culler.plan_known(&scene.hierarchy, &[], plan);
            write(plan);
        });
    }

    fn plan_by(
        &mut self,
        scene: &CulledScene,
        views: &[CullView],
        plan: impl FnOnce(&mut Culler, &mut FramePlan),
    ) {
        self.planned = None;
        let are_valid = views.iter().all(|view| cull::check_view(view).is_ok());
        if !are_valid || self.check(scene).is_err() {
            return;
        }
        self.planned_views.clear();
        self.planned_views.extend_from_slice(views);
        plan(&mut self.culler, &mut self.plan);
        self.planned = Some(scene.leaves.version);
        self.generation = scene.hierarchy.generation();
        self.layout.lay_out(&self.plan, &scene.leaves);
    }

    /// Begins a frame without a plan of the culler: the plan is empty and has no tests.
    ///
    /// # Errors
    /// [`Error::NotUploaded`]; no memory, a failed call.
    pub fn begin_unplanned(
        &mut self,
        frame: &mut Frame<'_>,
        scene: &CulledScene,
        view: &CullView,
    ) -> Result<(), Error> {
        scene.leaves.check_uploaded(frame)?;
        self.plan_known(scene, view, &[]);
        self.planned = None;
        let Self { rings, plan, generation, .. } = self;
        rings.queries.begin(frame, &[])?;
        rings.flags.begin(frame, std::iter::empty())?;
        rings.computed.begin(frame, std::iter::empty())?;
        let nothing = std::iter::empty::<DrawRange>();
        let draws = scene.leaves.copied_draws();
        rings.leaf_draws.begin(frame, (plan.frame, *generation), nothing, &draws)?;
        Ok(())
    }
}
