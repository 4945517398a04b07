//! The passes that draw a scene's objects, as the executor and the methods see them.

use cull::View;
use gpu::{Commands, Device, RenderTarget, Target};
use occlusion::{Error, ObjectPass, ObjectRenderer, PlanExecutor, Rendering, ShaderSet};
use scene::Light;

use crate::blended::Blended;
use crate::deformers::Deformers;
use crate::geometry::Geometry;
use crate::passes::{CountPass, OpaqueIo, OpaquePass};
use crate::shading::Shading;

/// Everything that the objects of a scene are drawn with.
pub(crate) struct FramePasses {
    pub(crate) device: Device,
    pub(crate) target: Target,
    pub(crate) geometry: Geometry,
    pub(crate) opaque: OpaquePass,
    /// Made for the first method that draws depth first.
    pub(crate) depth_first: Option<DepthFirst>,
    /// Made for the first frame that counts.
    pub(crate) counts: Option<CountPass>,
    pub(crate) light: Light,
    /// Where meshes change their form.
    pub(crate) deformers: Option<Deformers>,
    /// Where objects are blended.
    pub(crate) blended: Option<Blended>,
    /// For scenes with surfaces.
    pub(crate) shading: Option<Shading>,
}

/// The opaque pass in two: depth, then colour.
pub(crate) struct DepthFirst {
    depth: OpaquePass,
    colour: OpaquePass,
}

impl DepthFirst {
    pub(crate) fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        Ok(Self {
            depth: OpaquePass::depth_only(device, shaders)?,
            colour: OpaquePass::colour_only(device, shaders)?,
        })
    }
}

impl ObjectRenderer for FramePasses {
    fn target(&mut self) -> &mut Target {
        &mut self.target
    }

    fn rendering(&self, view: &View, rendering: Rendering) -> RenderTarget {
        let target = match rendering {
            Rendering::First => self.picture_target(view, self.sky()),
            Rendering::Next => self.target_of(view, None),
        };
        if self.shading.is_some() { target.depth_only() } else { target }
    }

    fn colour_rendering(&self, view: &View) -> RenderTarget {
        self.target_of(view, None)
    }

    fn prepare(&mut self, pass: ObjectPass, shaders: &ShaderSet) -> Result<(), Error> {
        if pass != ObjectPass::Visibility && self.depth_first.is_none() {
            self.depth_first = Some(DepthFirst::new(&self.device, shaders)?);
        }
        Ok(())
    }

    fn bind(&self, commands: &Commands, view: &View, pass: ObjectPass) {
        let pass = match (pass, &self.depth_first) {
            (ObjectPass::Depth, Some(DepthFirst { depth, .. })) => depth,
            (ObjectPass::Colour, Some(DepthFirst { colour, .. })) => colour,
            _ => return self.bind_visibility(commands, view),
        };
        pass.bind(commands, &self.opaque_io(), view, &self.light);
    }

    fn shades_later(&self) -> bool {
        self.shading.is_some()
    }

    fn shade(
        &mut self,
        executor: &PlanExecutor,
        commands: &Commands,
        view: &View,
        draw: &dyn Fn(&Commands),
    ) {
        self.shade_surfaces(executor, commands, view, draw);
    }
}

impl FramePasses {
    /// Returns where a view is drawn: its part of the target.
    pub(crate) fn target_of(&self, view: &View, clear: Option<[f32; 4]>) -> RenderTarget {
        self.target.render_target(clear).within(view.origin, view.size)
    }

    pub(crate) fn opaque_io(&self) -> OpaqueIo {
        OpaqueIo {
            vertices: self.geometry.vertices.whole(),
            indices: self.geometry.indices.whole(),
            instances: self.geometry.instances.whole(),
        }
    }
}
