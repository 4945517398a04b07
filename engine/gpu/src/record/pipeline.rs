//! Pipelines: the few states that the engine varies; all others are fixed in one place.

use ash::vk;

use crate::core::capabilities::OptionalFeature;
use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::ownership::of_device;
use crate::memory::texture_table::TextureTable;
use crate::record::attachments::Attachments;
use crate::record::graphics_state::create_graphics;
use crate::record::shader::Spirv;

/// The depth test of a pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DepthMode {
    /// Passes nearer depths and stores them.
    TestAndWrite,
    /// Passes equal or nearer depths and stores them. The final depth is the same as with
    /// [`DepthMode::TestAndWrite`], but all objects at this depth count as visible, in any order.
    TestEqualAndWrite,
    /// Passes equal or nearer depths and stores nothing. Proxies use it, because equal depth counts
    /// as visible.
    TestOnly,
    /// Passes nearer depths and stores nothing.
    TestNearer,
    /// Passes farther depths and stores nothing: a fragment passes either this test or
    /// [`DepthMode::TestOnly`]. For objects that are drawn where they are hidden.
    TestFarther,
    /// Passes equal depths and stores nothing, for objects that are drawn a second time.
    Equal,
    /// Passes all depths and stores nothing.
    Ignored,
}

/// The colour output of a pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blend {
    /// The fragment's colour replaces the old one.
    Opaque,
    /// The colour is blended by alpha.
    Alpha,
    /// The colour, which is already multiplied by alpha, is blended by alpha.
    Premultiplied,
    /// The larger value of each channel is kept, in any order of draws.
    Max,
    /// There is no colour output. Do not give a fragment shader then: a masked one would still run.
    NoColour,
}

/// The stencil operation of a pipeline, if the attachments have a stencil.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum StencilMode {
    /// No stencil test and no change.
    #[default]
    Ignored,
    /// Counts front faces minus back faces whose fragments pass the depth test, modulo 256.
    CountPassing,
    /// Counts back faces minus front faces whose fragments fail the depth test, modulo 256.
    CountFailing,
    /// Passes if the count is not 0, and keeps it.
    Counted,
    /// Writes the mark 1 where a fragment passes the depth test.
    Mark,
    /// Passes if the stencil is 0, and keeps it.
    Unmarked,
    /// Inverts a bit with each fragment, so that it is set if the number of fragments is odd.
    Parity,
    /// Passes if the number is odd. Every fragment, drawn or not, resets it to 0.
    Odd,
    /// Passes if the number is odd. Fragments that fail the depth test reset it to 0.
    OddDrawn,
}

/// The depths that a pipeline draws.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum DepthRange {
    /// Depths between the near and the far plane; the rest is clipped.
    #[default]
    Clipped,
    /// All depths; depths beyond a plane are clamped to it. For devices with
    /// [`OptionalFeature::DepthClamp`](crate::OptionalFeature::DepthClamp).
    Clamped,
}

/// The choice of fragments that are drawn, of the fragments of a triangle that pass the depth test.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum FragmentChoice {
    /// All fragments.
    #[default]
    All,
    /// At least one fragment, which is enough for a flag, on devices with
    /// [`RepresentativeFragments`](crate::OptionalFeature::RepresentativeFragments); otherwise all.
    /// Only for early tests, and never within a query that counts.
    Representative,
    /// The fragments that cover the first sample of their pixel. If fragments of several objects
    /// share a pixel, they cover different samples, so the first sample selects one of them.
    FirstSample,
}

/// The rasterisation of triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polygon {
    /// The whole triangle.
    Filled,
    /// The edges of the triangle, slightly nearer than the triangle. For devices with
    /// [`OptionalFeature::Wireframe`](crate::OptionalFeature::Wireframe).
    Wireframe,
}

/// The layout of vertices in their buffer. An empty layout is for shaders that generate their
/// vertices.
#[derive(Debug, Clone, Copy, Default)]
pub struct VertexLayout<'a> {
    /// The distance between vertices in bytes.
    pub stride_bytes: u32,
    /// The format and offset of the attribute at each location.
    pub attributes: &'a [(vk::Format, u32)],
    /// A second buffer with further attributes of the same vertices; its locations follow the ones
    /// here.
    pub beside: Option<&'a VertexLayout<'a>>,
}

/// The buffers and constants that the shaders of a pipeline can access.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StorageLayout {
    /// The number of storage buffers, at bindings 0, 1, … of set 0.
    pub buffers: u32,
    /// The number of sampled textures, at the bindings after the storage buffers.
    pub textures: u32,
    /// The number of sampled [`TextureArray`](crate::TextureArray)s, in one descriptor array at the
    /// binding after the textures.
    pub texture_arrays: u32,
    /// The size of the push constants in bytes.
    pub push_bytes: u32,
}

/// The description of a graphics pipeline.
#[derive(Debug, Clone, Copy)]
pub struct GraphicsPipelineInfo<'a> {
    /// The name in messages and debuggers.
    pub name: &'a str,
    /// The SPIR-V of the vertex stage.
    pub vertex: &'a Spirv,
    /// The geometry shader, if there is one. For devices with
    /// [`OptionalFeature::GeometryShaders`](crate::OptionalFeature::GeometryShaders).
    pub geometry: Option<&'a Spirv>,
    /// The fragment shader; `None` draws depth only.
    pub fragment: Option<&'a Spirv>,
    /// The layout of the vertices in their buffers.
    pub vertices: VertexLayout<'a>,
    /// The buffers and constants of the shaders.
    pub storage: StorageLayout,
    /// A table with the layout of the tables that draws bind; shaders access its textures by index,
    /// at binding 0 of set 1.
    pub table: Option<&'a TextureTable>,
    /// The bytes per instance in the first storage buffer, for vertex shaders that take the
    /// instance index from `instance_number.glsl`; 0 for others.
    pub instance_bytes: u32,
    /// The primitive topology: points, lines or triangles, with adjacency for some geometry
    /// shaders.
    pub topology: vk::PrimitiveTopology,
    /// The rasterisation of triangles.
    pub polygon: Polygon,
    /// The faces that are not drawn; counter-clockwise is front.
    pub cull: vk::CullModeFlags,
    /// The depth test, and the storage of the depth.
    pub depth: DepthMode,
    /// The depths that are drawn.
    pub range: DepthRange,
    /// The fragments that are drawn.
    pub fragments: FragmentChoice,
    /// The use of the stencil.
    pub stencil: StencilMode,
    /// The combination of the new colour with the old one.
    pub blend: Blend,
    /// The attachments that the pipeline draws to.
    pub attachments: Attachments,
}

impl StorageLayout {
    /// Describes a number of storage buffers, and push constants of type `C`.
    pub fn new<C>(buffers: u32) -> Self {
        Self { buffers, push_bytes: size_of::<C>() as u32, ..Self::default() }
    }
}

impl<'a> GraphicsPipelineInfo<'a> {
    /// Describes the simplest pipeline: both sides of triangles that the shader generates, tested
    /// for equal or nearer depth, with nothing stored.
    pub fn of(name: &'a str, vertex: &'a Spirv) -> Self {
        Self {
            name,
            vertex,
            geometry: None,
            fragment: None,
            vertices: VertexLayout::default(),
            storage: StorageLayout::default(),
            table: None,
            instance_bytes: 0,
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            polygon: Polygon::Filled,
            cull: vk::CullModeFlags::NONE,
            depth: DepthMode::TestOnly,
            range: DepthRange::Clipped,
            fragments: FragmentChoice::All,
            stencil: StencilMode::Ignored,
            blend: Blend::NoColour,
            attachments: Attachments::default(),
        }
    }

    /// Describes the same pipeline for a vertex shader that takes the instance index from
    /// `instance_number.glsl` and reads a `T` at this index in the first storage buffer.
    #[must_use]
    pub fn numbered<T>(self) -> Self {
        Self { instance_bytes: size_of::<T>() as u32, ..self }
    }
}

/// A graphics pipeline.
pub struct GraphicsPipeline(pub(crate) PipelineKind);

/// A compute pipeline.
pub struct ComputePipeline(pub(crate) PipelineKind);

/// The objects that both kinds of pipelines own.
pub(crate) struct PipelineKind {
    device: Device,
    pub(crate) raw: vk::Pipeline,
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) storage: vk::DescriptorSetLayout,
    pub(crate) buffers: u32,
    pub(crate) textures: u32,
    pub(crate) texture_arrays: u32,
    /// True if set 1 is a table of textures.
    pub(crate) has_table: bool,
    pub(crate) push_bytes: u32,
    /// The value of [`GraphicsPipelineInfo::instance_bytes`].
    pub(crate) instance_bytes: u32,
    /// The stages that can access buffers and constants.
    pub(crate) stages: vk::ShaderStageFlags,
}

of_device!(PipelineKind: "a pipeline");

impl GraphicsPipeline {
    /// Compiles a pipeline.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a wireframe, several views, a geometry shader or clamped depths
    /// that the device does not support; [`Error::Foreign`] for a table of another device; a failed
    /// call.
    pub fn new(device: &Device, info: &GraphicsPipelineInfo<'_>) -> Result<Self, Error> {
        info.attachments.check(device)?;
        if let Some(table) = info.table {
            device.check(table, "pipelines (`GraphicsPipeline`)")?;
        }
        let needs = [
            (info.polygon == Polygon::Wireframe, OptionalFeature::Wireframe, "drawing a wireframe"),
            (
                info.attachments.views > 1,
                OptionalFeature::Multiview,
                "drawing several views at once",
            ),
            (info.geometry.is_some(), OptionalFeature::GeometryShaders, "a geometry shader"),
            (info.range == DepthRange::Clamped, OptionalFeature::DepthClamp, "clamped depths"),
        ];
        for (is_needed, optional, wanted) in needs {
            if is_needed {
                device.require(optional, wanted)?;
            }
        }
        use vk::ShaderStageFlags as Stage;
        let mut stages = Stage::VERTEX | Stage::FRAGMENT;
        if info.geometry.is_some() {
            stages |= Stage::GEOMETRY;
        }

        PipelineKind::new(device, info.name, info.storage, info.table, stages, |layout| {
            info.vertex.with_stage(device, Stage::VERTEX, |vertex| {
                with_optional(device, info.geometry, Stage::GEOMETRY, |geometry| {
                    with_optional(device, info.fragment, Stage::FRAGMENT, |fragment| {
                        let all = [Some(vertex), geometry, fragment];
                        let all: Vec<_> = all.into_iter().flatten().collect();
                        create_graphics(device, info, layout, &all)
                    })
                })
            })
        })
        .map(|mut kind| {
            kind.instance_bytes = info.instance_bytes;
            Self(kind)
        })
    }
}

impl ComputePipeline {
    /// Compiles a compute pipeline.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(
        device: &Device,
        name: &str,
        shader: &Spirv,
        storage: StorageLayout,
    ) -> Result<Self, Error> {
        PipelineKind::new(device, name, storage, None, vk::ShaderStageFlags::COMPUTE, |layout| {
            shader.with_stage(device, vk::ShaderStageFlags::COMPUTE, |stage| {
                let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout);
                let cache = device.pipeline_cache();
                // SAFETY: module and layout are alive.
                unsafe { device.raw().create_compute_pipelines(cache, &[info], device.callbacks()) }
                    .map_err(|(_, code)| code)
                    .called("vkCreateComputePipelines")
                    .map(|pipelines| pipelines.first().copied().unwrap_or_default())
            })
        })
        .map(Self)
    }
}

/// Calls `make` with the module of a shader, or with `None` without a shader.
fn with_optional<R>(
    device: &Device,
    shader: Option<&Spirv>,
    stage: vk::ShaderStageFlags,
    make: impl FnOnce(Option<vk::PipelineShaderStageCreateInfo<'_>>) -> Result<R, Error>,
) -> Result<R, Error> {
    match shader {
        None => make(None),
        Some(shader) => shader.with_stage(device, stage, |stage| make(Some(stage))),
    }
}

impl PipelineKind {
    pub(super) fn new(
        device: &Device,
        name: &str,
        layout: StorageLayout,
        table: Option<&TextureTable>,
        stages: vk::ShaderStageFlags,
        make: impl FnOnce(vk::PipelineLayout) -> Result<vk::Pipeline, Error>,
    ) -> Result<Self, Error> {
        let storage = create_set_layout(device, layout, stages)?;
        // Owned from here on: if it is dropped while incomplete, it retires its existing objects,
        // and destroying null is allowed.
        let mut kind = Self {
            device: device.clone(),
            raw: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            storage,
            buffers: layout.buffers,
            textures: layout.textures,
            texture_arrays: layout.texture_arrays,
            has_table: table.is_some(),
            push_bytes: layout.push_bytes,
            instance_bytes: 0,
            stages,
        };
        let sets = [Some(storage), table.map(|table| table.layout)];
        let sets: Vec<_> = sets.into_iter().flatten().collect();
        let constants =
            [vk::PushConstantRange { stage_flags: stages, offset: 0, size: layout.push_bytes }];
        let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
        if layout.push_bytes > 0 {
            info = info.push_constant_ranges(&constants);
        }
        // SAFETY: the set layouts are alive.
        kind.layout = unsafe { device.raw().create_pipeline_layout(&info, device.callbacks()) }
            .called("vkCreatePipelineLayout")?;
        kind.raw = make(kind.layout)?;
        device.name(kind.storage, name);
        device.name(kind.layout, name);
        device.name(kind.raw, name);
        Ok(kind)
    }
}

impl Drop for PipelineKind {
    fn drop(&mut self) {
        self.device.retire(Retired::Pipeline(self.raw));
        self.device.retire(Retired::PipelineLayout(self.layout));
        self.device.retire(Retired::SetLayout(self.storage));
    }
}

fn create_set_layout(
    device: &Device,
    layout: StorageLayout,
    stages: vk::ShaderStageFlags,
) -> Result<vk::DescriptorSetLayout, Error> {
    let binding = |binding: u32| {
        let kind = if binding < layout.buffers {
            vk::DescriptorType::STORAGE_BUFFER
        } else {
            vk::DescriptorType::COMBINED_IMAGE_SAMPLER
        };
        let is_single = binding < layout.buffers + layout.textures;
        vk::DescriptorSetLayoutBinding::default()
            .binding(binding)
            .descriptor_type(kind)
            .descriptor_count(if is_single { 1 } else { layout.texture_arrays })
            .stage_flags(stages)
    };
    let count = layout.buffers + layout.textures + u32::from(layout.texture_arrays > 0);
    let bindings: Vec<_> = (0..count).map(binding).collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    // SAFETY: plain bindings of storage buffers and textures.
    unsafe { device.raw().create_descriptor_set_layout(&info, device.callbacks()) }
        .called("vkCreateDescriptorSetLayout")
}
