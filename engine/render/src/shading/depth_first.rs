//! Depth first: the draws of scenes with surfaces, whose order does not affect the image.
//!
//! ```text
//! as always   the rounds of culling, each strategy's own, with the depth alone
//! surfaces    their draws once more, for the colour; the sky where nothing is
//! transparent the transparent objects, back to front
//! ```
//!
//! Real scenes have surfaces that lie in the same plane or intersect, so several are equally near
//! at a pixel. With a normal depth test the first one drawn would win, and culling changes the
//! order. Here all of them pass the test against the finished depth in any order, and the highest
//! value of each channel is kept: a maximum does not depend on order. Culled objects cannot be
//! among them. They are farther than the depth at each of their samples, since a proxy that is as
//! near as the depth counts as visible.

use gpu::{Attachments, Device};
use occlusion::{Error, ShaderSet};

use crate::passes::{OpaquePass, SkyPass, SurfaceKind, SurfacePass, SurfaceShadows};
use crate::shading::surfaces::SurfaceResources;

/// The passes of scenes with surfaces.
pub(crate) struct Shading {
    pub(crate) depth: DepthPass,
    pub(crate) surfaces: SurfacePass,
    pub(crate) sky: SkyPass,
}

/// The pass that draws the depth, with the holes of masked materials if there are any.
pub(crate) enum DepthPass {
    Whole(OpaquePass),
    Masked(SurfacePass),
}

/// The colour before any draw: the lowest value of each channel.
pub(crate) const DARK: [f32; 4] = [0.0; 4];

impl Shading {
    /// Compiles the passes for renderings to `attachments`, with shadows if there are any.
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
        surfaces: &SurfaceResources,
        shadows: Option<SurfaceShadows>,
    ) -> Result<Self, Error> {
        let pass = |kind| SurfacePass::new(device, shaders, attachments, kind, surfaces, shadows);
        let depth = if surfaces.is_masked() {
            DepthPass::Masked(pass(SurfaceKind::Depth)?)
        } else {
            DepthPass::Whole(OpaquePass::depth_only(device, shaders, attachments)?)
        };
        Ok(Self {
            depth,
            surfaces: pass(SurfaceKind::Colour)?,
            sky: SkyPass::new(device, shaders, attachments)?,
        })
    }
}
