//! Plans of a view: each is made for a scene and for views, and executed once.

use cull::{CullView, Culler, FramePlan, Hierarchy, LeafIndex, MultiView, Strategy};
use gpu::{DrawRange, Frame};

use super::super::{OcclusionState, PlannedScene};
use crate::error::{Error, PlanError};
use crate::leaf_table::LeafTable;

impl OcclusionState {
    /// Refuses to execute the newest plan for anything but what it was made for, once.
    ///
    /// # Errors
    /// [`Error::Plan`], [`Error::ForeignView`].
    pub(crate) fn check_plan(&self, leaves: &LeafTable, views: MultiView<'_>) -> Result<(), Error> {
        self.check(leaves)?;
        let version = match self.planned.ok_or(PlanError::Missing)? {
            PlannedScene::Own { version } => version,
            PlannedScene::Foreign => return Err(Error::ForeignView),
        };
        if version != leaves.version {
            return Err(PlanError::SceneChanged.into());
        }
        if self.planned_views.is_empty() || self.planned_views == views.as_slice() {
            Ok(())
        } else {
            Err(PlanError::OtherViews.into())
        }
    }

    /// Plans the next frame of a view, or of several drawn at once, and lays out its tests. To be
    /// called once all changes of the scene are [uploaded](crate::HostScene::upload); the plan is
    /// executed once, for these views. Nothing is planned for another scene than the view's own:
    /// the execution is [refused](Error::ForeignView).
    pub fn plan_frame<'v>(
        &mut self,
        hierarchy: &Hierarchy,
        leaves: &LeafTable,
        strategy: Strategy,
        views: impl Into<MultiView<'v>>,
        query_budget: usize,
    ) {
        let views = views.into();
        self.planned_views.clear();
        self.planned_views.extend_from_slice(views.as_slice());
        self.plan_by(hierarchy, leaves, |culler, plan| {
            culler.plan(hierarchy, strategy, views, query_budget, plan);
        });
    }

    /// Plans a frame of next-frame queries ([`Culler::plan_next_frame`]) and lays out its tests.
    pub fn plan_next_frame(&mut self, hierarchy: &Hierarchy, leaves: &LeafTable, view: &CullView) {
        self.planned_views.clear();
        self.planned_views.push(*view);
        self.plan_by(hierarchy, leaves, |culler, plan| {
            culler.plan_next_frame(hierarchy, view, plan);
        });
    }

    /// Plans a frame of `visible` leaves and no test.
    pub fn plan_known(&mut self, hierarchy: &Hierarchy, leaves: &LeafTable, visible: &[LeafIndex]) {
        self.planned_views.clear();
        self.plan_by(hierarchy, leaves, |culler, plan| culler.plan_known(hierarchy, visible, plan));
    }

    fn plan_by(
        &mut self,
        hierarchy: &Hierarchy,
        leaves: &LeafTable,
        plan: impl FnOnce(&mut Culler, &mut FramePlan),
    ) {
        if leaves.id != self.table || *hierarchy.id() != leaves.hierarchy {
            self.planned = Some(PlannedScene::Foreign);
            return;
        }
        plan(&mut self.culler, &mut self.plan);
        self.planned = Some(PlannedScene::Own { version: leaves.version });
        self.generation = hierarchy.generation();
        self.layout.lay_out(&self.plan, leaves);
    }

    /// Begins a frame that is not planned: an empty plan without tests.
    ///
    /// # Errors
    /// [`Error::NotUploaded`]; no memory, a failed call.
    pub fn begin_unplanned(
        &mut self,
        frame: &mut Frame<'_>,
        hierarchy: &Hierarchy,
        leaves: &LeafTable,
    ) -> Result<(), Error> {
        leaves.check_uploaded(frame)?;
        self.plan_known(hierarchy, leaves, &[]);
        self.planned = None;
        let Self { rings, plan, generation, .. } = self;
        rings.queries.begin(frame, &[])?;
        rings.flags.begin(frame, std::iter::empty())?;
        rings.computed.begin(frame, std::iter::empty())?;
        let nothing = std::iter::empty::<DrawRange>();
        let draws = leaves.copied_draws();
        rings.leaf_draws.begin(frame, (plan.frame, *generation), nothing, &draws)?;
        Ok(())
    }
}
