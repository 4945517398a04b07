//! The seam between the engine and the owner of the objects.

use cull::CullView;
use gpu::{Commands, RenderTarget, Target};

use crate::leaf_table::BucketId;

/// The place of a rendering among those of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rendering {
    /// The first: it clears.
    First,
    /// A later one, which keeps the contents.
    Next,
}

/// The owner of the objects: binds pipelines and geometry, so that indexed indirect draws follow.
pub trait ObjectRenderer {
    /// Returns the images that views are drawn to.
    fn target(&mut self) -> &mut Target;

    /// Returns the attachments of a rendering of a view that decides what is visible. If the view
    /// covers a part of the target, restrict them by
    /// `RenderTarget::within(view.origin, view.size)`, or the clear of its first rendering covers
    /// all of the target.
    fn rendering(&self, view: &CullView, rendering: Rendering) -> RenderTarget;

    /// Begins a rendering of a view that decides what is visible. An owner with a render pass of
    /// its own begins that pass, with the depth that the last rendering of the view left. Returns
    /// false if nothing can be drawn.
    fn begin_rendering(
        &mut self,
        commands: &Commands,
        view: &CullView,
        rendering: Rendering,
    ) -> bool {
        commands.begin_rendering(self.rendering(view, rendering))
    }

    /// Ends the rendering that [`ObjectRenderer::begin_rendering`] began.
    fn end_rendering(&mut self, commands: &Commands) {
        commands.end_rendering();
    }

    /// Binds the objects that the draws of a bucket need: depth, and colour unless the owner
    /// [adds it later](crate::ShadedObjects::shade). Called before the draws of each bucket in each
    /// rendering, in the order of the buckets; viewport and scissor cover the view then. No query
    /// and no condition may be left open: the engine opens its own around the draws that follow.
    fn bind(&self, commands: &Commands, view: &CullView, bucket: BucketId);
}
