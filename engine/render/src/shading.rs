//! Depth first: how scenes with surfaces are drawn, so that no order of draws shows in the picture.
//!
//! ```text
//! as always   the rounds of culling, each strategy's own, with the depth alone
//! surfaces    what they drew once more, for its colour; the sky where nothing is
//! blended     what is blended, back to front
//! ```
//!
//! Real scenes have surfaces that lie in one plane or cut each other, so that several are equally near at
//! a pixel. Whoever is drawn first would win there, and culling changes who that is. Here all of them
//! pass the test against the finished depth, whoever was first, and the lightest of each channel stays:
//! a maximum knows no order. What culling left out is not among them: it is farther than the depth at
//! each of its samples, since proxies that are as near as the depth count as visible.

use cull::View;
use gpu::{BufferSlice, Commands, Device, RenderTarget};
use occlusion::{Error, PlanExecutor, ShaderSet};

use crate::frame_passes::FramePasses;
use crate::passes::{OpaquePass, SkyPass, SurfaceIo, SurfaceKind, SurfacePass};
use crate::surfaces::SurfaceResources;

/// What scenes with surfaces are drawn with.
pub(crate) struct Shading {
    depth: DepthPass,
    surfaces: SurfacePass,
    sky: SkyPass,
}

/// What draws the depth: with the holes of masked materials where there are any.
enum DepthPass {
    Whole(OpaquePass),
    Masked(SurfacePass),
}

/// Before anything is drawn, each channel is as dark as can be.
const DARK: [f32; 4] = [0.0; 4];

impl Shading {
    /// Compiles the passes.
    ///
    /// # Errors
    /// A failed call.
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        surfaces: &SurfaceResources,
    ) -> Result<Self, Error> {
        let pass = |kind| SurfacePass::new(device, shaders, kind, surfaces);
        let depth = match surfaces.is_masked() {
            true => DepthPass::Masked(pass(SurfaceKind::Depth)?),
            false => DepthPass::Whole(OpaquePass::depth_only(device, shaders)?),
        };
        Ok(Self {
            depth,
            surfaces: pass(SurfaceKind::Colour)?,
            sky: SkyPass::new(device, shaders)?,
        })
    }
}

impl FramePasses {
    /// The sky's colour as it is exposed: as light, so that it is no brighter than white.
    pub(crate) fn sky(&self) -> [f32; 3] {
        let surfaces = self.geometry.surfaces.as_ref();
        let exposure = surfaces.map_or(1.0, SurfaceResources::exposure);
        self.light.sky.map(|part| (part * exposure).min(1.0))
    }

    /// Where [`FramePasses::draw_all`] goes, before such a backdrop.
    pub(crate) fn picture_target(&self, view: &View, backdrop: [f32; 3]) -> RenderTarget {
        let [red, green, blue] = backdrop;
        let plain = [red, green, blue, 1.0];
        self.target_of(view, Some(self.shading.as_ref().map_or(plain, |_| DARK)))
    }

    /// Binds what the rounds draw objects with: those of their colours where no other pass gives them any.
    pub(crate) fn bind_visibility(&self, commands: &Commands, view: &View) {
        let pass = match (self.shading.as_ref().map(|shading| &shading.depth), self.surface_io()) {
            (Some(DepthPass::Masked(pass)), Some(io)) => {
                pass.bind(commands, &io, view, &self.light);
                return;
            }
            (Some(DepthPass::Whole(pass)), _) => pass,
            _ => &self.opaque,
        };
        pass.bind(commands, &self.opaque_io(), view, &self.light);
    }

    pub(crate) fn surface_io(&self) -> Option<SurfaceIo<'_>> {
        Some(SurfaceIo {
            vertices: self.geometry.vertices.whole(),
            indices: self.geometry.indices.whole(),
            instances: self.geometry.instances.whole(),
            surfaces: self.geometry.surfaces.as_ref()?,
        })
    }

    /// Gives what the rounds drew its colour, if it has none yet: `draw` draws all of it again.
    pub(crate) fn shade_surfaces(
        &mut self,
        executor: &PlanExecutor,
        commands: &Commands,
        view: &View,
        draw: &dyn Fn(&Commands),
    ) {
        if self.shading.is_none() {
            return;
        }
        self.prepare_blended(commands);
        self.target.prepare(commands);
        commands.pass("shade surfaces", |commands| {
            let target = self.target_of(view, None).cleared_to(DARK);
            commands.rendering(target, |commands| {
                self.draw_surfaces(commands, view, self.sky(), draw);
                self.test_blended(executor, commands, view);
            });
        });
        self.record_blended(executor, commands, view);
    }

    fn draw_surfaces(
        &self,
        commands: &Commands,
        view: &View,
        backdrop: [f32; 3],
        draw: impl FnOnce(&Commands),
    ) {
        let (Some(Shading { surfaces, sky, .. }), Some(io)) = (&self.shading, self.surface_io())
        else {
            return;
        };
        surfaces.bind(commands, &io, view, &self.light);
        draw(commands);
        sky.draw(commands, backdrop);
    }

    /// Draws all of the `draws`, of which there are so many, in their own colours, before a backdrop, to
    /// the [picture's target](FramePasses::picture_target).
    pub(crate) fn draw_all(
        &self,
        executor: &PlanExecutor,
        commands: &Commands,
        view: &View,
        (draws, count): (BufferSlice, u32),
        backdrop: [f32; 3],
    ) {
        let draw = |commands: &Commands| {
            if count > 0 {
                executor.leaves.predicates().draw_after_counted(commands, draws);
            }
        };
        self.bind_visibility(commands, view);
        draw(commands);
        self.draw_surfaces(commands, view, backdrop, draw);
    }
}
