//! The surface pass: the depth and the colour of objects made of metallic-roughness materials.

use ::shadows::ShadowFilter;
use bytemuck::{Pod, Zeroable};
use cull::{CullView, ProjectionKind};
use gpu::{
    Attachments, Blend, BufferSlice, Commands, DepthMode, Device, GraphicsPipeline,
    GraphicsPipelineInfo, SampledArrays, SpecializationConstant, StorageLayout, VertexLayout, vk,
};
use scene::limits::MAX_PAGES;
use scene::{Light, SurfaceVertex};

use crate::passes::caster::CasterSide;
use crate::passes::opaque::POSITIONS;
use crate::passes::section::{SectionIo, culled_faces, section_buffers, with_section};
use crate::resources::instance::Instance;
use crate::shading::surfaces::{SurfaceResources, SurfaceTextures};
use crate::shadows::ShadowIo;
use occlusion::{Error, SectionShaders, ShaderSet};

/// The output of a surface pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// Only depth, with the holes of masked materials. In scenes without holes,
    /// [`OpaquePass::depth_only`](crate::passes::OpaquePass::depth_only) draws the same depth at
    /// less cost.
    Depth,
    /// The colour of the surfaces that own a pixel of the finished depth, whichever pass drew the
    /// depth. Where surfaces are equally near, the larger value of each channel is kept, so the
    /// order of draws does not matter: clear to black before.
    Colour,
    /// Transparent objects over the finished image, hidden by nearer surfaces. Draw them back to
    /// front.
    Transparent,
    /// Transparent objects in any order. Their fragments are stored and sorted later. For devices
    /// with [`gpu::OptionalFeature::FragmentStores`] and [`gpu::OptionalFeature::SectionBuffers`].
    Fragments,
    /// The depth of shadow casters, with the holes of masked materials, to
    /// [`DepthLayers`](gpu::DepthLayers).
    Casters(CasterSide),
    /// The light of lens flares that transparent objects take, added up in a buffer in any order.
    /// For devices with [`gpu::OptionalFeature::FragmentStores`].
    Transmittance,
}

/// The pass that draws objects of a scene with surfaces. It is compiled for the features that the
/// materials and lights of the scene use.
pub struct SurfacePass {
    pipeline: GraphicsPipeline,
    inputs: Inputs,
}

/// The shadows that a pass draws with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceShadows {
    /// Shadow maps, with a filter.
    Maps(ShadowFilter),
    /// Shadow volumes. They belong to the surfaces that own a pixel, so transparent surfaces do not
    /// receive them.
    Volumes,
}

/// The inputs of a pass.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Inputs {
    /// Materials and their textures, which cut holes.
    Holes,
    /// All inputs except shadows.
    Lights,
    /// All inputs, with shadow maps.
    Maps,
    /// All inputs, with a mask of shadow volumes.
    Mask,
}

impl Inputs {
    fn of(kind: SurfaceKind, shadows: Option<SurfaceShadows>) -> Self {
        match (kind, shadows) {
            (SurfaceKind::Depth | SurfaceKind::Casters(_) | SurfaceKind::Transmittance, _) => {
                Self::Holes
            }
            (_, None)
            | (SurfaceKind::Transparent | SurfaceKind::Fragments, Some(SurfaceShadows::Volumes)) => {
                Self::Lights
            }
            (_, Some(SurfaceShadows::Maps(_))) => Self::Maps,
            (_, Some(SurfaceShadows::Volumes)) => Self::Mask,
        }
    }

    /// Returns the number of storage buffers.
    fn buffers(self) -> u32 {
        match self {
            Self::Holes | Self::Lights => 5,
            Self::Maps | Self::Mask => 7,
        }
    }

    /// Returns the number of textures besides pages: the environment, and for shadow maps the maps
    /// twice and the samples of filters.
    fn textures(self) -> u32 {
        match self {
            Self::Holes => 0,
            Self::Lights | Self::Mask => 1,
            Self::Maps => 4,
        }
    }
}

/// The inputs of the pass. Positions, surface vertices, indices, instances, materials, textures,
/// lights and their lists are read; the colour and depth that are being rendered to are written.
#[derive(Clone, Copy)]
pub struct SurfaceIo<'a> {
    /// [`Vertex`](scene::Vertex)es of all meshes.
    pub vertices: BufferSlice,
    /// The 32-bit indices of all meshes, three per triangle.
    pub indices: BufferSlice,
    /// An instance per leaf, or per transparent object. The last values of an instance are
    /// [`SurfaceResources::instance_tail`]s.
    pub instances: BufferSlice,
    /// The scene's surfaces, with the surface half of its vertices.
    pub surfaces: &'a SurfaceResources,
    /// The shadows of its lights, for passes that were compiled with shadows.
    pub shadows: Option<ShadowIo<'a>>,
    /// Section planes, for passes that were compiled with section planes.
    pub section: Option<SectionIo>,
    /// The lists of fragments, for [`SurfaceKind::Fragments`].
    pub fragments: Option<BufferSlice>,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    from_anchor: [f32; 16],
    anchor: [f32; 3],
    exposure: f32,
    towards_eye: [f32; 3],
    shadow_view: u32,
    ambient_above: [f32; 4],
    ambient_below: [f32; 4],
}

const _: () = assert!(size_of::<Constants>() == 128);

/// The specialisation constant of `surface_constants.glsl` that selects a filter.
const SHADOW_FILTER: u32 = 14;

/// The specialisation constant of `surface_constants.glsl` for the pages with pictures of spot
/// lights.
const PICTURE_PAGES: u32 = 16;

/// The specialisation constant of `surface_constants.glsl` for the light of an environment.
const ENVIRONMENT: u32 = 15;

/// The specialisation constant of `surface_constants.glsl` for several samples per pixel.
const SEVERAL_SAMPLES: u32 = 17;

/// The attributes of a [`SurfaceVertex`]: normal, tangent, both sets of texture coordinates,
/// colour.
const ATTRIBUTES: [(vk::Format, u32); 5] = [
    (vk::Format::R16G16B16A16_SNORM, 0),
    (vk::Format::R16G16B16A16_SNORM, 8),
    (vk::Format::R32G32_SFLOAT, 16),
    (vk::Format::R32G32_SFLOAT, 24),
    (vk::Format::R16G16B16A16_UNORM, 32),
];

/// The positions of [`Vertex`](scene::Vertex)es, and their colours, which contain the share of the
/// object's tint.
const POSITIONS_AND_TINTS: VertexLayout<'static> = VertexLayout {
    attributes: &[(vk::Format::R32G32B32_SFLOAT, 0), (vk::Format::R8G8B8A8_UNORM, 16)],
    ..POSITIONS
};

impl SurfacePass {
    /// Compiles the pass for a scene and its shadows, and for renderings to `attachments`. Passes
    /// of depth have no shadows.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
        kind: SurfaceKind,
        surfaces: &SurfaceResources,
        shadows: Option<SurfaceShadows>,
    ) -> Result<Self, Error> {
        let (name, shader, depth, blend) = look_of(kind);
        let inputs = Inputs::of(kind, shadows);
        let is_depth = inputs == Inputs::Holes;
        let fragment = fragment_shader(kind, inputs, shader);
        let cull = match kind {
            SurfaceKind::Casters(side) => side.culled_faces(),
            _ => vk::CullModeFlags::BACK,
        };
        let section = shaders.section();
        let is_transparent = matches!(
            kind,
            SurfaceKind::Transparent | SurfaceKind::Fragments | SurfaceKind::Transmittance
        );
        let mut constants = surfaces.features(is_transparent).constants(is_transparent).to_vec();
        let constant = |id, value| SpecializationConstant { id, value };
        constants.push(constant(PICTURE_PAGES, surfaces.features(is_transparent).pictures));
        constants.push(constant(ENVIRONMENT, u32::from(surfaces.environment.is_there())));
        let has_several = attachments.samples != vk::SampleCountFlags::TYPE_1;
        constants.push(constant(SEVERAL_SAMPLES, u32::from(has_several)));
        constants.extend(shadows.filter(|_| inputs == Inputs::Maps).and_then(filter_constant));
        let stage = |name: &str, end: &str| {
            shaders.find_of_objects(name, end).map(|shader| shader.specialised(&constants))
        };
        // Holes depend only on texture coordinates and colours, the last three attributes.
        let (first, attributes) = if is_depth {
            (POSITIONS, &ATTRIBUTES[2..])
        } else {
            (POSITIONS_AND_TINTS, &ATTRIBUTES[..])
        };
        let surface_vertices = VertexLayout {
            stride_bytes: size_of::<SurfaceVertex>() as u32,
            attributes,
            beside: None,
        };
        let vertex = match (section, kind, inputs) {
            (SectionShaders::Cut, SurfaceKind::Fragments, _) => "surface_sorted",
            (SectionShaders::Cut, _, Inputs::Maps | Inputs::Mask) => "surface_shadowed",
            _ => shader,
        };
        let vertex = stage(vertex, "vert")?;
        let (fragment, texture_arrays, table) = match &surfaces.textures {
            SurfaceTextures::Pages { .. } => (fragment.to_owned(), MAX_PAGES as u32, None),
            SurfaceTextures::Images(images) => {
                (format!("{fragment}_bindless"), 0, Some(images.table()))
            }
        };
        let info = GraphicsPipelineInfo {
            fragment: Some(&stage(&fragment, "frag")?),
            vertices: VertexLayout { beside: Some(&surface_vertices), ..first },
            storage: StorageLayout {
                textures: inputs.textures(),
                texture_arrays,
                ..StorageLayout::new::<Constants>(inputs.buffers() + other_buffers(kind, section))
            },
            table,
            cull: culled_faces(section, cull),
            depth,
            blend,
            attachments,
            ..GraphicsPipelineInfo::of(name, &vertex).numbered::<Instance>()
        };
        Ok(Self { pipeline: GraphicsPipeline::new(device, &info)?, inputs })
    }

    /// Binds everything. The caller then records draws with one instance each, since a draw has one
    /// material.
    pub fn bind(&self, commands: &Commands, io: &SurfaceIo<'_>, view: &CullView, light: &Light) {
        self.bind_inputs(commands, io);
        self.set_view(commands, io, view, light);
    }

    /// Binds everything except the view.
    pub(super) fn bind_inputs(&self, commands: &Commands, io: &SurfaceIo<'_>) {
        let [materials, transforms, lights, lists] = io.surfaces.buffers();
        let own = SurfaceBuffers { instances: io.instances, materials, transforms, lights, lists };
        self.bind_buffers(commands, io, own);
    }

    /// Binds everything for [`SurfaceKind::Transmittance`]. The blocks of flares and their
    /// transmittance are bound in place of the lights and their lists.
    pub fn bind_transmittance(
        &self,
        commands: &Commands,
        io: &SurfaceIo<'_>,
        blocks: BufferSlice,
        transmittance: BufferSlice,
        view: &CullView,
        light: &Light,
    ) {
        let [materials, transforms, ..] = io.surfaces.buffers();
        let own = SurfaceBuffers {
            instances: io.instances,
            materials,
            transforms,
            lights: blocks,
            lists: transmittance,
        };
        self.bind_buffers(commands, &SurfaceIo { shadows: None, ..*io }, own);
        self.set_view(commands, io, view, light);
    }

    fn bind_buffers(&self, commands: &Commands, io: &SurfaceIo<'_>, own: SurfaceBuffers) {
        io.surfaces.textures.bound(|pages| self.bind_inputs_with(commands, io, own, pages));
        commands.bind_geometry_beside([io.vertices, io.surfaces.vertices()], io.indices);
    }

    fn bind_inputs_with(
        &self,
        commands: &Commands,
        io: &SurfaceIo<'_>,
        own: SurfaceBuffers,
        pages: SampledArrays<'_>,
    ) {
        let around = io.surfaces.environment.sampled();
        let SurfaceBuffers { instances, materials, transforms, lights, lists } = own;
        let own = [instances, materials, transforms, lights, lists];
        match (self.inputs, &io.shadows) {
            (Inputs::Holes, _) => with_others(&own, io, |all| {
                commands.bind_sampled(&self.pipeline, all, &[], pages);
            }),
            (Inputs::Maps, Some(ShadowIo::Maps(shadows))) => {
                let of_lights = shadows.lights;
                let of_faces = shadows.faces;
                let all = [instances, materials, transforms, lights, lists, of_lights, of_faces];
                let textures = [shadows.maps, shadows.depths, shadows.disks, around];
                with_others(&all, io, |all| {
                    commands.bind_sampled(&self.pipeline, all, &textures, pages);
                });
            }
            (Inputs::Mask, Some(ShadowIo::Mask(mask))) => {
                let all = [instances, materials, transforms, lights, lists, mask.lights, mask.mask];
                with_others(&all, io, |all| {
                    commands.bind_sampled(&self.pipeline, all, &[around], pages);
                });
            }
            (Inputs::Lights | Inputs::Maps | Inputs::Mask, _) => {
                with_others(&own, io, |all| {
                    commands.bind_sampled(&self.pipeline, all, &[around], pages);
                });
            }
        }
    }

    /// Sets the view of the draws that follow.
    pub(super) fn set_view(
        &self,
        commands: &Commands,
        io: &SurfaceIo<'_>,
        view: &CullView,
        light: &Light,
    ) {
        let with = |[x, y, z]: [f32; 3], w| [x, y, z, w];
        let [steps_across, steps_up] = view.snap_steps;
        commands.push_constants(
            &self.pipeline,
            &Constants {
                from_anchor: view.from_anchor.to_cols_array(),
                anchor: view.anchor.to_array(),
                exposure: io.surfaces.exposure(),
                towards_eye: match view.rays.kind {
                    ProjectionKind::Perspective => [0.0; 3],
                    ProjectionKind::Orthographic => (-view.rays.middle).to_array(),
                },
                shadow_view: match &io.shadows {
                    Some(ShadowIo::Maps(maps)) => maps.view,
                    Some(ShadowIo::Mask(_)) | None => 0,
                },
                ambient_above: with(light.ambient_above, steps_across),
                ambient_below: with(light.ambient_below, steps_up),
            },
        );
    }
}

/// Returns the name of a pass and of its shaders, its depth test, and its use of colour.
fn look_of(kind: SurfaceKind) -> (&'static str, &'static str, DepthMode, Blend) {
    match kind {
        SurfaceKind::Depth => {
            ("surface depth", "surface_depth", DepthMode::TestEqualAndWrite, Blend::NoColour)
        }
        SurfaceKind::Colour => ("surface", "surface", DepthMode::Equal, Blend::Max),
        SurfaceKind::Transparent => {
            ("transparent surface", "surface", DepthMode::TestOnly, Blend::Alpha)
        }
        SurfaceKind::Fragments => {
            ("stored surface", "surface", DepthMode::TestOnly, Blend::NoColour)
        }
        SurfaceKind::Casters(side) => {
            (side.name_masked(), "surface_depth", DepthMode::TestAndWrite, Blend::NoColour)
        }
        SurfaceKind::Transmittance => {
            ("transmittance of flares", "surface_depth", DepthMode::TestOnly, Blend::NoColour)
        }
    }
}

/// Calls `bind` with the buffers of a pass, followed by the buffers of section planes and of
/// fragments. Section planes cut all transparent objects, which have no states.
fn with_others(own: &[BufferSlice], io: &SurfaceIo<'_>, bind: impl FnOnce(&[BufferSlice])) {
    let Some(fragments) = io.fragments else { return with_section(own, io.section, bind) };
    let planes = io.section.map(|section| section.planes);
    bind(&own.iter().copied().chain(planes).chain([fragments]).collect::<Vec<_>>());
}

/// The storage buffers that each kind of pass binds first.
#[derive(Clone, Copy)]
struct SurfaceBuffers {
    instances: BufferSlice,
    materials: BufferSlice,
    transforms: BufferSlice,
    /// The lights; for transmittance, the blocks of flares.
    lights: BufferSlice,
    /// The lists of lights of objects; for transmittance, the transmittance of flares.
    lists: BufferSlice,
}

/// Returns the name of the fragment shader of a pass with these inputs. `shader` is the name of its
/// other shaders.
fn fragment_shader(kind: SurfaceKind, inputs: Inputs, shader: &'static str) -> &'static str {
    match (kind, inputs) {
        (SurfaceKind::Transmittance, _) => "flare_transmittance",
        (SurfaceKind::Fragments, Inputs::Maps) => "surface_shadowed_sorted",
        (SurfaceKind::Fragments, _) => "surface_sorted",
        (_, Inputs::Maps) => "surface_shadowed",
        (_, Inputs::Mask) => "surface_volumes",
        (_, Inputs::Holes | Inputs::Lights) => shader,
    }
}

/// Returns the number of buffers after the buffers of the inputs.
fn other_buffers(kind: SurfaceKind, section: SectionShaders) -> u32 {
    match (kind, section) {
        // The lists of fragments, and planes without states.
        (SurfaceKind::Fragments, SectionShaders::Whole) => 1,
        (SurfaceKind::Fragments, SectionShaders::Cut) => 2,
        _ => section_buffers(section),
    }
}

/// Returns the specialisation constant for the filter of shadow maps.
fn filter_constant(shadows: SurfaceShadows) -> Option<SpecializationConstant> {
    match shadows {
        SurfaceShadows::Maps(filter) => {
            Some(SpecializationConstant { id: SHADOW_FILTER, value: filter_number(filter) })
        }
        SurfaceShadows::Volumes => None,
    }
}

/// Returns the number of a filter in `shadows.glsl`.
fn filter_number(filter: ShadowFilter) -> u32 {
    match filter {
        ShadowFilter::Single => 0,
        ShadowFilter::Pcf3 => 1,
        ShadowFilter::Adaptive => 2,
        ShadowFilter::Pcss12 => 3,
        ShadowFilter::Fixed64 => 4,
        ShadowFilter::Pcss64 => 5,
    }
}
