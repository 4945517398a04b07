//! Facts about an object: the decision to draw it, its triangles, and the outline of its box.

use cull::{CullView, FrameId, LeafExplanation, LeafRange, ObjectId, Outcome};

use crate::error::Error;
use crate::render_view::RenderView;
use crate::renderer::Renderer;

impl Renderer {
    /// Explains the decision to draw an object or not in the newest frame of `state`, seen from
    /// `view`. The result contains the outcome of the newest answers and their frame. `None` if
    /// there is no such object or the view belongs to another renderer.
    pub fn explain_object(
        &self,
        state: &RenderView,
        view: &CullView,
        object: ObjectId,
    ) -> Option<(LeafExplanation, Option<(FrameId, Outcome)>)> {
        self.check_view(state).ok()?;
        let plan = state.plan();
        let explained =
            state.visibility.culler().explain(self.scene.hierarchy(), view, plan, object)?;
        let answers = state.visibility.newest_answers();
        let outcome = explained.outcome(self.scene.hierarchy(), answers);
        Some((explained, answers.first().map(|answer| answer.tag.frame).zip(outcome)))
    }

    /// Returns the number of triangles of an object at its present level of detail; 0 for an object
    /// that does not exist.
    pub fn triangles_of(&self, object: ObjectId) -> u64 {
        let leaf = self.scene.hierarchy().leaf_of(object);
        leaf.map_or(0, |first| self.scene.leaves().count(LeafRange { first, count: 1 }).triangles)
    }

    /// Outlines the box of an object in every image from now on, drawn over everything. Of several
    /// views, only the first shows it.
    ///
    /// # Errors
    /// A shader that does not compile, a failed call.
    pub fn outline(&mut self, object: Option<ObjectId>) -> Result<(), Error> {
        self.passes.pipelines.overlay.prepare(&self.device, &self.shaders)?;
        self.outlined = object;
        Ok(())
    }
}
