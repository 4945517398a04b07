//! Depth first: how scenes with surfaces are drawn, so that no order of draws shows in the picture.
//!
//! ```text
//! as always   the rounds of culling, each strategy's own, with the depth alone
//! surfaces    what they drew once more, for its colour; the sky where nothing is
//! blended     what is blended, back to front
//! ```
//!
//! Real scenes have surfaces that lie in one plane or cut each other, so that several are equally
//! near at a pixel. Whoever is drawn first would win there, and culling changes who that is. Here
//! all of them pass the test against the finished depth, whoever was first, and the lightest of
//! each channel stays: a maximum knows no order. What culling left out is not among them: it is
//! farther than the depth at each of its samples, since proxies that are as near as the depth count
//! as visible.

use gpu::Device;
use occlusion::{Error, ShaderSet};

use crate::passes::{OpaquePass, SkyPass, SurfaceKind, SurfacePass};
use crate::surfaces::SurfaceResources;

/// What scenes with surfaces are drawn with.
pub(crate) struct Shading {
    pub(crate) depth: DepthPass,
    pub(crate) surfaces: SurfacePass,
    pub(crate) sky: SkyPass,
}

/// What draws the depth: with the holes of masked materials where there are any.
pub(crate) enum DepthPass {
    Whole(OpaquePass),
    Masked(SurfacePass),
}

/// Before anything is drawn, each channel is as dark as can be.
pub(crate) const DARK: [f32; 4] = [0.0; 4];

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
