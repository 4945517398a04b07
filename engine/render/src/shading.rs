//! Depth first: how scenes with surfaces are drawn, so that no order of draws shows in the picture.
//!
//! ```text
//! as always   the rounds of culling, each strategy's own, with the depth alone
//! surfaces    what they drew once more, for its colour; the sky where nothing is
//! ```
//!
//! Real scenes have surfaces that lie in one plane or cut each other, so that several are equally near at
//! a pixel. Whoever is drawn first would win there, and culling changes who that is. Here all of them
//! pass the test against the finished depth, whoever was first, and the lightest of each channel stays:
//! a maximum knows no order. What culling left out is not among them: it is farther than the depth at
//! each of its samples, since proxies that are as near as the depth count as visible.

use cull::View;
use gpu::{BufferSlice, Commands, Device, RenderTarget};

use crate::error::Error;
use crate::frame_passes::FramePasses;
use crate::passes::{OpaquePass, SkyPass};
use crate::shaders::ShaderSet;

/// What scenes with surfaces are drawn with.
pub(crate) struct Shading {
    depth: OpaquePass,
    surfaces: OpaquePass,
    sky: SkyPass,
}

/// Before anything is drawn, each channel is as dark as can be.
const DARK: [f32; 4] = [0.0; 4];

impl Shading {
    /// Compiles the passes.
    ///
    /// # Errors
    /// A failed call.
    pub(crate) fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        Ok(Self {
            depth: OpaquePass::depth_only(device, shaders)?,
            surfaces: OpaquePass::lightest(device, shaders)?,
            sky: SkyPass::new(device, shaders)?,
        })
    }
}

impl FramePasses {
    /// Where the first draws of a view's frame go.
    pub(crate) fn first_target(&self, view: &View) -> RenderTarget {
        match self.shading {
            Some(_) => self.target_of(view, Some(DARK)).depth_only(),
            None => self.target_of(view, Some(self.sky())),
        }
    }

    /// Where all others go that decide what is visible.
    pub(crate) fn next_target(&self, view: &View) -> RenderTarget {
        match self.shading {
            Some(_) => self.target_of(view, None).depth_only(),
            None => self.target_of(view, None),
        }
    }

    /// Where [`FramePasses::draw_all`] goes, before such a backdrop.
    pub(crate) fn picture_target(&self, view: &View, backdrop: [f32; 4]) -> RenderTarget {
        self.target_of(view, Some(self.shading.as_ref().map_or(backdrop, |_| DARK)))
    }

    fn sky(&self) -> [f32; 4] {
        let [red, green, blue] = self.light.sky;
        [red, green, blue, 1.0]
    }

    /// Binds what the rounds draw objects with: those of their colours where no other pass gives them any.
    pub(crate) fn bind_rounds(&self, commands: &Commands, view: &View) {
        let pass = self.shading.as_ref().map_or(&self.opaque, |shading| &shading.depth);
        pass.bind(commands, &self.opaque_io(), view, &self.light);
    }

    /// Gives what the rounds drew its colour, if it has none yet: `draw` draws all of it again.
    pub(crate) fn shade(
        &mut self,
        commands: &Commands,
        view: &View,
        draw: impl FnOnce(&Self, &Commands),
    ) {
        if self.shading.is_none() {
            return;
        }
        self.target.prepare(commands);
        commands.pass("surfaces", |commands| {
            let target = self.target_of(view, None).cleared_to(DARK);
            commands.rendering(target, |commands| {
                self.draw_surfaces(commands, view, self.sky(), |commands| draw(self, commands));
            });
        });
    }

    fn draw_surfaces(
        &self,
        commands: &Commands,
        view: &View,
        backdrop: [f32; 4],
        draw: impl FnOnce(&Commands),
    ) {
        let Some(Shading { surfaces, sky, .. }) = &self.shading else { return };
        surfaces.bind(commands, &self.opaque_io(), view, &self.light);
        draw(commands);
        sky.record(commands, backdrop);
    }

    /// Draws all of the `draws`, of which there are so many, in their own colours, before a backdrop, to
    /// the [picture's target](FramePasses::picture_target).
    pub(crate) fn draw_all(
        &self,
        commands: &Commands,
        view: &View,
        (draws, count): (BufferSlice, u32),
        backdrop: [f32; 4],
    ) {
        let draw = |commands: &Commands| {
            if count > 0 {
                commands.draw_indirect(draws);
            }
        };
        self.bind_rounds(commands, view);
        draw(commands);
        self.draw_surfaces(commands, view, backdrop, draw);
    }
}
