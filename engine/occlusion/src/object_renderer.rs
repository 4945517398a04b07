//! The seam between the executor and the owner of the objects.

use cull::View;
use gpu::{Commands, RenderTarget, Target};

use crate::error::Error;
use crate::executor::PlanExecutor;
use crate::shader_set::ShaderSet;

/// What the draws that follow a [bind](ObjectRenderer::bind) are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObjectPass {
    /// They decide what is visible: depth, and colour unless that is given
    /// [later](ObjectRenderer::shade).
    Visibility,
    /// Depth alone, the same to the bit.
    Depth,
    /// The colour of what [`ObjectPass::Depth`] drew.
    Colour,
}

/// Where among the renderings of a view one stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rendering {
    /// The first: it clears.
    First,
    /// A later one, which draws over what is there.
    Next,
}

/// Owns the objects and draws them: binds pipelines and geometry, so that indexed indirect draws,
/// each of one leaf, follow.
pub trait ObjectRenderer {
    /// Returns the images that views are drawn to.
    fn target(&mut self) -> &mut Target;

    /// Returns where a rendering of a view goes that decides what is visible.
    fn rendering(&self, view: &View, rendering: Rendering) -> RenderTarget;

    /// Returns where a rendering of a view goes that adds colour to what is there.
    fn colour_rendering(&self, view: &View) -> RenderTarget;

    /// Makes what a pass needs, before the first frame that binds it. [`ObjectPass::Depth`] and
    /// [`ObjectPass::Colour`] are for methods that an option makes draw depth first.
    ///
    /// # Errors
    /// A shader that does not compile, a failed call.
    fn prepare(&mut self, pass: ObjectPass, shaders: &ShaderSet) -> Result<(), Error>;

    /// Binds what the draws of a pass need.
    fn bind(&self, commands: &Commands, view: &View, pass: ObjectPass);

    /// Returns true if [`ObjectRenderer::shade`] gives the colours, so that the draws before it are
    /// kept.
    fn shades_later(&self) -> bool;

    /// Gives what the rounds drew its colour, if it has none yet: `draw` draws all of it again.
    /// Outside of rendering.
    fn shade(
        &mut self,
        executor: &PlanExecutor,
        commands: &Commands,
        view: &View,
        draw: &dyn Fn(&Commands),
    );
}
