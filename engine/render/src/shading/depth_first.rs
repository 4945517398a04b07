//! Depth first: the draws of scenes with surfaces, so that no order of draws shows in the image.
//!
//! ```text
//! as always   the rounds of culling, each strategy's own, with the depth alone
//! surfaces    their draws once more, for the colour; the sky where nothing is
//! transparent the transparent objects, back to front
//! ```
//!
//! Real scenes have surfaces that lie in one plane or cut each other, so that several are equally
//! near at a pixel. The first one drawn would win there, and culling changes which one that is.
//! Here all of them pass the test against the finished depth in any order, and the lightest value
//! of each channel stays: a maximum has no order. Objects that culling left out are not among them:
//! they are farther than the depth at each of their samples, since proxies that are as near as the
//! depth count as visible.

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

/// The pass that draws the depth: with the holes of masked materials where there are any.
pub(crate) enum DepthPass {
    Whole(OpaquePass),
    Masked(SurfacePass),
}

/// The colour before any draw: each channel is as dark as possible.
pub(crate) const DARK: [f32; 4] = [0.0; 4];

impl Shading {
    /// Compiles the passes for renderings to `attachments`, with shadows if there are any.
    ///
    /// # Errors
    /// A failed call.
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
