//! The shading of objects, where it is more than a pipeline per bucket: depth before colour, work
//! before draws, colours after all visibility is known.

use cull::{CullView, FramePlan};
use gpu::{Commands, Predicate, RenderTarget, Target, Viewport};

use crate::culled_scene::CulledScene;
use crate::error::Error;
use crate::leaf_table::BucketId;
use crate::object_renderer::{ObjectRenderer, Rendering};
use crate::shader_set::ShaderSet;

/// The part of the shading that the draws after a [bind](ShadedObjects::bind_pass) are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObjectPass {
    /// Depth alone, bit for bit the depth of [`ObjectRenderer::bind`].
    Depth,
    /// The colour of the objects that [`ObjectPass::Depth`] drew.
    Colour,
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

/// An owner of objects that shades them in its own order. Every method calls it; an owner without
/// such an order implements [`ObjectRenderer`] and nothing here.
pub trait ShadedObjects: ObjectRenderer {
    /// Begins the last rendering of a view that decides what is visible, in place of
    /// [`ObjectRenderer::begin_rendering`]. Depth is not read after it by the engine, so an owner
    /// who does not read it either need not store it.
    fn begin_last_rendering(
        &mut self,
        commands: &Commands,
        view: &CullView,
        rendering: Rendering,
    ) -> bool {
        self.begin_rendering(commands, view, rendering)
    }

    /// Returns the attachments of a rendering of a view that adds colour to the contents.
    fn colour_rendering(&self, view: &CullView) -> RenderTarget {
        self.rendering(view, Rendering::Next)
    }

    /// Compiles a pass for methods with an option to draw depth first, before the first frame that
    /// binds it. An owner that compiled all passes beforehand does nothing here.
    ///
    /// # Errors
    /// A shader that does not compile, a failed call.
    fn prepare(&mut self, _pass: ObjectPass, _shaders: &ShaderSet) -> Result<(), Error> {
        Ok(())
    }

    /// Binds the objects for draws of a part of the shading, as [`ObjectRenderer::bind`] does for
    /// the draws that decide what is visible.
    fn bind_pass(&self, commands: &Commands, view: &CullView, bucket: BucketId, _pass: ObjectPass) {
        self.bind(commands, view, bucket);
    }

    /// Returns true while work for draws is [left](ShadedObjects::prepare_draws).
    fn has_draws_to_prepare(&self) -> bool {
        false
    }

    /// Records work that the following draws depend on. Every method announces all draws of a view,
    /// so that hidden objects cost nothing. Outside of rendering.
    fn prepare_draws(&mut self, _commands: &Commands, _draws: UpcomingDraws<'_>) {}

    /// Returns true if [`ShadedObjects::shade`] adds the colours, so that the draws before it are
    /// kept.
    fn shades_later(&self) -> bool {
        false
    }

    /// Adds the colours to the draws of the rounds, if they have none yet: `draw` repeats all of
    /// these draws, and binds each bucket before its draws. Outside of rendering.
    fn shade(
        &mut self,
        _scene: &CulledScene,
        _commands: &Commands,
        _view: &CullView,
        _draw: DrawBuckets<'_>,
    ) {
    }

    /// Prepares to add the colours within the last rendering of a view that decides what is
    /// visible, right before it begins. Returns false if they can only be added
    /// [later](ShadedObjects::shade): they depend on its finished depth, or need no pass at all.
    fn prepare_to_shade_within(&mut self, _commands: &Commands) -> bool {
        false
    }

    /// Adds the colours within the last rendering that decides what is visible, in place of
    /// [`ShadedObjects::shade`], with the same draws.
    fn shade_within(
        &mut self,
        _scene: &CulledScene,
        _commands: &Commands,
        _view: &CullView,
        _draw: DrawBuckets<'_>,
    ) {
    }

    /// Draws what follows the colours of a view, after the rendering that
    /// [has them](ShadedObjects::shade_within).
    fn finish_shading(&mut self, _scene: &CulledScene, _commands: &Commands, _view: &CullView) {}
}

/// Objects whose colours are drawn with their depth.
pub(crate) struct Unshaded<'a>(pub(crate) &'a mut dyn ObjectRenderer);

impl ObjectRenderer for Unshaded<'_> {
    fn target(&mut self) -> &mut Target {
        self.0.target()
    }

    fn rendering(&self, view: &CullView, rendering: Rendering) -> RenderTarget {
        self.0.rendering(view, rendering)
    }

    fn begin_rendering(
        &mut self,
        commands: &Commands,
        view: &CullView,
        rendering: Rendering,
    ) -> bool {
        self.0.begin_rendering(commands, view, rendering)
    }

    fn end_rendering(&mut self, commands: &Commands) {
        self.0.end_rendering(commands);
    }

    fn bind(&self, commands: &Commands, view: &CullView, bucket: BucketId) {
        self.0.bind(commands, view, bucket);
    }
}

impl ShadedObjects for Unshaded<'_> {}

/// Records the last rendering of a view that decides what is visible: `record` draws, between the
/// begin and the end of the owner.
pub fn render_last(
    objects: &mut dyn ShadedObjects,
    commands: &Commands,
    view: &CullView,
    rendering: Rendering,
    record: impl FnOnce(&Commands, &mut dyn ShadedObjects),
) {
    if objects.begin_last_rendering(commands, view, rendering) {
        commands.set_viewport(&Viewport::covering(view.origin, view.size));
        record(commands, objects);
        objects.end_rendering(commands);
    }
}

/// Records a rendering of a view that is not the last: `record` draws, between the begin and the
/// end of the owner.
pub fn render(
    objects: &mut dyn ShadedObjects,
    commands: &Commands,
    view: &CullView,
    rendering: Rendering,
    record: impl FnOnce(&Commands, &mut dyn ShadedObjects),
) {
    if objects.begin_rendering(commands, view, rendering) {
        commands.set_viewport(&Viewport::covering(view.origin, view.size));
        record(commands, objects);
        objects.end_rendering(commands);
    }
}
