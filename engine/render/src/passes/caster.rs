//! The caster pass: the depth of objects as lights see them.

use ::shadows::ShadowBias;
use cull::View;
use gpu::{BufferSlice, Commands, DepthLayers, Device, vk};
use occlusion::{Error, ShaderSet};
use scene::Light;

use crate::passes::{OpaqueIo, OpaquePass, SurfaceIo, SurfaceKind, SurfacePass};
use crate::shading::surfaces::SurfaceResources;

/// The pass that draws casters of shadows to [`DepthLayers`], nearest depths
/// first: with the holes of masked materials where there are any.
pub enum CasterPass {
    /// Without holes.
    Whole(OpaquePass),
    /// With the holes of masked materials.
    Masked(SurfacePass),
}

/// The inputs of the pass: reads positions, indices, instances, and of surfaces what cuts holes.
#[derive(Clone, Copy)]
pub struct CasterIo<'a> {
    /// [`Vertex`](scene::Vertex)es of all meshes.
    pub vertices: BufferSlice,
    /// The 32-bit indices of all meshes, three per triangle.
    pub indices: BufferSlice,
    /// One instance per leaf.
    pub instances: BufferSlice,
    /// The scene's surfaces.
    pub surfaces: &'a SurfaceResources,
}

impl CasterIo<'_> {
    fn opaque(&self) -> OpaqueIo {
        let Self { vertices, indices, instances, .. } = *self;
        OpaqueIo { vertices, indices, instances }
    }

    fn surface(&self) -> SurfaceIo<'_> {
        let Self { vertices, indices, instances, surfaces } = *self;
        SurfaceIo { vertices, indices, instances, surfaces, shadows: None }
    }
}

/// Returns the faces of triangles that maps leave out.
pub(super) fn culled_faces(bias: ShadowBias) -> vk::CullModeFlags {
    match bias {
        ShadowBias::Plane => vk::CullModeFlags::BACK,
        ShadowBias::BackFaces => vk::CullModeFlags::FRONT,
    }
}

impl CasterPass {
    /// Compiles the pass for a scene.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        surfaces: &SurfaceResources,
        bias: ShadowBias,
    ) -> Result<Self, Error> {
        Ok(match surfaces.is_masked() {
            true => {
                let kind = SurfaceKind::Casters(bias);
                let shaders = (shaders, DepthLayers::attachments());
                Self::Masked(SurfacePass::new(device, shaders, kind, surfaces, None)?)
            }
            false => Self::Whole(OpaquePass::casters(device, shaders, bias)?),
        })
    }

    /// Binds everything but the view.
    pub fn bind(&self, commands: &Commands, io: &CasterIo<'_>) {
        match self {
            Self::Whole(pass) => pass.bind_inputs(commands, &io.opaque()),
            Self::Masked(pass) => pass.bind_inputs(commands, &io.surface()),
        }
    }

    /// Sets the light's view of a map; the caller then records draws.
    pub fn set_view(&self, commands: &Commands, io: &CasterIo<'_>, view: &View) {
        // Neither of the two shades anything here.
        let light = Light::afternoon();
        match self {
            Self::Whole(pass) => pass.set_view(commands, view, &light),
            Self::Masked(pass) => pass.set_view(commands, &io.surface(), view, &light),
        }
    }
}
