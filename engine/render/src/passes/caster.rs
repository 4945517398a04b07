//! The caster pass: the depth of objects seen from lights.

use ::shadows::ShadowBias;
use cull::CullView;
use gpu::{
    BufferSlice, Commands, DepthLayers, DepthMode, Device, GraphicsPipeline, GraphicsPipelineInfo,
    StorageLayout, vk,
};
use occlusion::{Error, ShaderSet};
use scene::Light;

use crate::passes::opaque::POSITIONS;
use crate::passes::section::{SectionIo, cut_depth_stages, section_buffers, with_section};
use crate::passes::seen::SeenConstants;
use crate::passes::{MidpointPass, SurfaceIo, SurfaceKind, SurfacePass};
use crate::resources::instance::Instance;
use crate::shading::surfaces::SurfaceResources;

/// The pass that draws casters of shadows to [`DepthLayers`] and keeps the nearest depth. It cuts
/// the holes of masked materials, if there are any.
pub enum CasterPass {
    /// Without holes.
    Whole(WholeCasters),
    /// With the holes of masked materials.
    Masked(SurfacePass),
}

/// The inputs of the pass: positions, indices, instances, and the data of surfaces that cuts holes
/// are read.
#[derive(Clone, Copy)]
pub struct CasterIo<'a> {
    /// [`Vertex`](scene::Vertex)es of all meshes.
    pub vertices: BufferSlice,
    /// The 32-bit indices of all meshes, three per triangle.
    pub indices: BufferSlice,
    /// An instance per leaf.
    pub instances: BufferSlice,
    /// The scene's surfaces.
    pub surfaces: &'a SurfaceResources,
    /// Section planes in the light's view, for passes that were compiled with section planes.
    pub section: Option<SectionIo>,
}

/// The pass that draws casters without holes. It reads only positions.
pub struct WholeCasters {
    pipeline: GraphicsPipeline,
}

impl WholeCasters {
    fn new(device: &Device, shaders: &ShaderSet, side: CasterSide) -> Result<Self, Error> {
        let section = shaders.section();
        let (vertex, fragment) = cut_depth_stages(shaders)?;
        let info = GraphicsPipelineInfo {
            vertices: POSITIONS,
            fragment,
            storage: StorageLayout::new::<SeenConstants>(1 + section_buffers(section)),
            cull: side.culled_faces(),
            depth: DepthMode::TestAndWrite,
            attachments: DepthLayers::attachments(),
            ..GraphicsPipelineInfo::of(side.name(), vertex).numbered::<Instance>()
        };
        Ok(Self { pipeline: GraphicsPipeline::new(device, &info)? })
    }
}

impl CasterIo<'_> {
    fn surface(&self) -> SurfaceIo<'_> {
        let Self { vertices, indices, instances, surfaces, section } = *self;
        SurfaceIo {
            vertices,
            indices,
            instances,
            surfaces,
            shadows: None,
            section,
            fragments: None,
        }
    }
}

/// The side of casters that is drawn, seen from a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CasterSide {
    /// All triangles: a wall stops light from both sides.
    Both,
    /// Triangles that face the light.
    Fronts,
    /// Triangles that face away from the light.
    Backs,
}

impl CasterSide {
    pub(super) fn culled_faces(self) -> vk::CullModeFlags {
        match self {
            Self::Both => vk::CullModeFlags::NONE,
            Self::Fronts => vk::CullModeFlags::BACK,
            Self::Backs => vk::CullModeFlags::FRONT,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Both => "casters",
            Self::Fronts => "fronts of casters",
            Self::Backs => "backs of casters",
        }
    }

    pub(super) fn name_masked(self) -> &'static str {
        match self {
            Self::Both => "masked casters",
            Self::Fronts => "fronts of masked casters",
            Self::Backs => "backs of masked casters",
        }
    }
}

/// The passes that draw shadow maps.
pub(crate) struct MapPasses {
    /// The pass for the side of casters that maps hold, or for the fronts of midpoints.
    pub(crate) casters: CasterPass,
    /// The pass for the backs of midpoints, and the pass that writes midpoints.
    pub(crate) midpoints: Option<(CasterPass, MidpointPass)>,
}

impl MapPasses {
    /// Compiles the passes for a scene.
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        surfaces: &SurfaceResources,
        bias: ShadowBias,
    ) -> Result<Self, Error> {
        let casters = |side| CasterPass::new(device, shaders, surfaces, side);
        let (side, midpoints) = match bias {
            ShadowBias::Plane => (CasterSide::Both, None),
            ShadowBias::BackFaces => (CasterSide::Backs, None),
            ShadowBias::Midpoint => {
                let backs = casters(CasterSide::Backs)?;
                (CasterSide::Fronts, Some((backs, MidpointPass::new(device, shaders)?)))
            }
        };
        Ok(Self { casters: casters(side)?, midpoints })
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
        side: CasterSide,
    ) -> Result<Self, Error> {
        Ok(if surfaces.is_masked() {
            let kind = SurfaceKind::Casters(side);
            let shaders_attachments = DepthLayers::attachments();
            Self::Masked(SurfacePass::new(
                device,
                shaders,
                shaders_attachments,
                kind,
                surfaces,
                None,
            )?)
        } else {
            Self::Whole(WholeCasters::new(device, shaders, side)?)
        })
    }

    /// Binds everything except the view.
    pub fn bind(&self, commands: &Commands, io: &CasterIo<'_>) {
        match self {
            Self::Whole(WholeCasters { pipeline }) => {
                with_section(&[io.instances], io.section, |all| commands.bind(pipeline, all));
                commands.bind_geometry(io.vertices, Some(io.indices));
            }
            Self::Masked(pass) => pass.bind_inputs(commands, &io.surface()),
        }
    }

    /// Sets the light's view of a map. The caller then records draws.
    pub fn set_view(&self, commands: &Commands, io: &CasterIo<'_>, view: &CullView) {
        match self {
            Self::Whole(WholeCasters { pipeline }) => {
                commands.push_constants(pipeline, &SeenConstants::of(view));
            }
            // Only depth is drawn, so any light will do.
            Self::Masked(pass) => {
                pass.set_view(commands, &io.surface(), view, &Light::afternoon());
            }
        }
    }
}
