//! The seam between the executor and the owner of the objects.

use cull::{CullView, FramePlan};
use gpu::{Commands, Predicate, RenderTarget, Target, Viewport};

use crate::error::Error;
use crate::executor::PlanExecutor;
use crate::leaf_table::BucketId;
use crate::shader_set::ShaderSet;

/// The purpose of the draws that follow a [bind](ObjectRenderer::bind).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObjectPass {
    /// The draws that decide what is visible: depth, and colour unless that is added
    /// [later](ObjectRenderer::shade).
    Visibility,
    /// Depth alone, the same to the bit.
    Depth,
    /// The colour of the objects that [`ObjectPass::Depth`] drew.
    Colour,
}

/// The place of a rendering among those of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rendering {
    /// The first: it clears.
    First,
    /// A later one, which keeps the contents.
    Next,
}

/// The draws that follow, for an owner with work to do before them: skinning, for example.
#[derive(Clone, Copy, Debug)]
pub enum UpcomingDraws<'a> {
    /// Any: a method without a plan does not know them beforehand.
    All,
    /// The draws of a plan that are taken as visible.
    Visible(&'a FramePlan),
    /// The ranges of a round, each if its result is above the threshold.
    Revealed(&'a [Predicate]),
}

/// A closure that draws buckets, each after a call of the closure that binds it.
pub type DrawBuckets<'a> = &'a dyn Fn(&Commands, &dyn Fn(&Commands, BucketId));

/// The owner of the objects: binds pipelines and geometry, so that indexed indirect draws, each of
/// one leaf, follow.
pub trait ObjectRenderer {
    /// Returns the images that views are drawn to.
    fn target(&mut self) -> &mut Target;

    /// Returns the attachments of a rendering of a view that decides what is visible.
    fn rendering(&self, view: &CullView, rendering: Rendering) -> RenderTarget;

    /// Begins a rendering of a view that decides what is visible. An owner with a render pass of
    /// its own begins that, with the depth that the last rendering of the view left. Returns false
    /// if nothing can be drawn.
    fn begin_rendering(
        &mut self,
        commands: &Commands,
        view: &CullView,
        rendering: Rendering,
    ) -> bool {
        commands.begin_rendering(self.rendering(view, rendering))
    }

    /// Begins the last rendering of a view that decides what is visible, in place of
    /// [`ObjectRenderer::begin_rendering`]. A method that knows which one is the last calls this:
    /// neither it nor the executor reads the depth afterwards, so an owner who does not read it
    /// either need not store it.
    fn begin_last_rendering(
        &mut self,
        commands: &Commands,
        view: &CullView,
        rendering: Rendering,
    ) -> bool {
        self.begin_rendering(commands, view, rendering)
    }

    /// Ends what [`ObjectRenderer::begin_rendering`] began.
    fn end_rendering(&mut self, commands: &Commands) {
        commands.end_rendering();
    }

    /// Returns the viewport of a view, the same in all its renderings.
    fn viewport(&self, view: &CullView) -> Viewport {
        Viewport::covering(view.origin, view.size)
    }

    /// Returns the attachments of a rendering of a view that adds colour to the contents.
    fn colour_rendering(&self, view: &CullView) -> RenderTarget {
        self.rendering(view, Rendering::Next)
    }

    /// Creates the objects of a pass, before the first frame that binds it. [`ObjectPass::Depth`]
    /// and [`ObjectPass::Colour`] are for methods with an option to draw depth first. An owner that
    /// made all beforehand does nothing here.
    ///
    /// # Errors
    /// A shader that does not compile, a failed call.
    fn prepare(&mut self, _pass: ObjectPass, _shaders: &ShaderSet) -> Result<(), Error> {
        Ok(())
    }

    /// Returns true while work for draws is [left](ObjectRenderer::prepare_draws).
    fn has_draws_to_prepare(&self) -> bool {
        false
    }

    /// Records work that the following draws depend on. Every method announces all of its draws of
    /// a view, so that what stays hidden costs nothing. Outside of rendering.
    fn prepare_draws(&mut self, _commands: &Commands, _draws: UpcomingDraws<'_>) {}

    /// Binds the objects that the draws of a bucket in a pass need. Called before the draws of each
    /// bucket in each rendering, in the order of the buckets. No query and no condition may be left
    /// open: the draws that follow have their own.
    fn bind(&self, commands: &Commands, view: &CullView, bucket: BucketId, pass: ObjectPass);

    /// Returns true if [`ObjectRenderer::shade`] adds the colours, so that the draws before it are
    /// kept.
    fn shades_later(&self) -> bool {
        false
    }

    /// Adds the colour to the draws of the rounds, if they have none yet: `draw` draws all of it
    /// again, and binds each bucket before it. Outside of rendering.
    fn shade(
        &mut self,
        _executor: &PlanExecutor,
        _commands: &Commands,
        _view: &CullView,
        _draw: DrawBuckets<'_>,
    ) {
    }

    /// Prepares to add the colours within the last rendering of a view that decides what is
    /// visible, right before it begins. Returns false if they can only be added
    /// [later](ObjectRenderer::shade): they depend on its finished depth, or need no pass at all.
    fn prepare_to_shade_within(&mut self, _commands: &Commands) -> bool {
        false
    }

    /// Adds the colours within that rendering, in place of [`ObjectRenderer::shade`], with the same
    /// draws.
    fn shade_within(
        &mut self,
        _executor: &PlanExecutor,
        _commands: &Commands,
        _view: &CullView,
        _draw: DrawBuckets<'_>,
    ) {
    }

    /// Draws what follows the colours of a view, after that rendering.
    fn finish_shading(&mut self, _executor: &PlanExecutor, _commands: &Commands, _view: &CullView) {
    }
}

/// Records the last rendering of a view that decides what is visible, as [`render`] does others.
pub fn render_last(
    objects: &mut dyn ObjectRenderer,
    commands: &Commands,
    view: &CullView,
    rendering: Rendering,
    record: impl FnOnce(&Commands, &mut dyn ObjectRenderer),
) {
    if objects.begin_last_rendering(commands, view, rendering) {
        record(commands, objects);
        objects.end_rendering(commands);
    }
}

/// Records a rendering of a view: `record` draws, between the begin and the end of the owner.
pub fn render(
    objects: &mut dyn ObjectRenderer,
    commands: &Commands,
    view: &CullView,
    rendering: Rendering,
    record: impl FnOnce(&Commands, &mut dyn ObjectRenderer),
) {
    if objects.begin_rendering(commands, view, rendering) {
        record(commands, objects);
        objects.end_rendering(commands);
    }
}
