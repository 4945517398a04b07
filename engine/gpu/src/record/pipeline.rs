//! Pipelines: the few states that the engine varies, with all others fixed in one place.

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

/// The use of depth by a pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DepthMode {
    /// A test for nearer, with the depth stored.
    TestAndWrite,
    /// A test for as near or nearer, with the depth stored. The final depth is the same, but all
    /// objects at that depth count as visible, in any order.
    TestEqualAndWrite,
    /// A test for as near or nearer, with nothing stored. Proxies use it: equal depth counts as
    /// visible.
    TestOnly,
    /// A test for nearer, with nothing stored.
    TestNearer,
    /// A test for farther, with nothing stored: a fragment passes either this or
    /// [`DepthMode::TestOnly`]. For what is drawn where it is hidden.
    TestFarther,
    /// A test for the same depth, with nothing stored, for objects that are drawn a second time.
    Equal,
    /// No test; nothing is stored.
    Ignored,
}

/// The use of colour by a pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blend {
    /// Replacement of the colour by the fragment's.
    Opaque,
    /// Blending by alpha.
    Alpha,
    /// Blending by alpha, of colours multiplied by alpha already.
    Premultiplied,
    /// The larger value of each channel, in any order of draws.
    Max,
    /// No colour output. Give no fragment shader then: a masked one would still run.
    NoColour,
}

/// The use of a stencil by a pipeline, where the attachments have one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum StencilMode {
    /// None.
    #[default]
    Ignored,
    /// A count of front faces less back faces whose fragments pass the depth test, modulo 256.
    CountPassing,
    /// A count of back faces less front faces whose fragments fail the depth test, modulo 256.
    CountFailing,
    /// A test for a count other than 0, which stays as it is.
    Counted,
    /// A mark, 1, where a fragment passes the depth test.
    Mark,
    /// A test for 0, which stays as it is.
    Unmarked,
    /// A bit that each fragment turns over, so that it says if their number is odd.
    Parity,
    /// A test for an odd number, which every fragment sets to 0, drawn or not.
    Odd,
    /// A test for an odd number, which fragments set to 0 where they fail the depth test.
    OddDrawn,
}

/// The depths that a pipeline draws.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum DepthRange {
    /// Those between the near and the far plane; what is beyond is cut off.
    #[default]
    Clipped,
    /// All: what is beyond has the depth of the plane. For devices with
    /// [`OptionalFeature::DepthClamp`](crate::OptionalFeature::DepthClamp).
    Clamped,
}

/// The fragments of a triangle that are drawn of those that pass the depth test.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum FragmentChoice {
    /// All.
    #[default]
    All,
    /// One at least, which is enough for a flag, on devices with
    /// [`RepresentativeFragments`](crate::OptionalFeature::RepresentativeFragments);
    /// else all. For early tests alone, and never within a query that counts.
    Representative,
    /// Those that cover the first sample of their pixel. Fragments of objects that meet in a pixel
    /// cover different samples, and one sample has one owner.
    FirstSample,
}

/// The rasterisation of triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polygon {
    /// The whole triangle.
    Filled,
    /// Its edges, a little nearer than the triangle. For devices with
    /// [`OptionalFeature::Wireframe`](crate::OptionalFeature::Wireframe).
    Wireframe,
}

/// The layout of vertices in their buffer. An empty layout is for shaders that make up their
/// vertices.
#[derive(Debug, Clone, Copy, Default)]
pub struct VertexLayout<'a> {
    /// The distance between vertices in bytes.
    pub stride_bytes: u32,
    /// The format and offset of the attribute at each location.
    pub attributes: &'a [(vk::Format, u32)],
    /// Another buffer with more of the same vertices; its locations follow those here.
    pub beside: Option<&'a VertexLayout<'a>>,
}

/// The buffers and constants a pipeline's shaders see.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StorageLayout {
    /// Storage buffers at bindings 0, 1, … of set 0.
    pub buffers: u32,
    /// Sampled textures at the bindings after those.
    pub textures: u32,
    /// Sampled [`TextureArray`](crate::TextureArray)s: one array of so many, at the binding after
    /// those.
    pub texture_arrays: u32,
    /// Bytes of push constants.
    pub push_bytes: u32,
}

/// The description of a graphics pipeline.
#[derive(Debug, Clone, Copy)]
pub struct GraphicsPipelineInfo<'a> {
    /// The name in messages and debuggers.
    pub name: &'a str,
    /// The SPIR-V of the vertex stage.
    pub vertex: &'a Spirv,
    /// Geometry shader, if there is one. For devices with
    /// [`OptionalFeature::GeometryShaders`](crate::OptionalFeature::GeometryShaders).
    pub geometry: Option<&'a Spirv>,
    /// Fragment shader; `None` draws depth only.
    pub fragment: Option<&'a Spirv>,
    /// The layout of the vertices in their buffers.
    pub vertices: VertexLayout<'a>,
    /// Buffers and constants.
    pub storage: StorageLayout,
    /// A table of textures like the ones that draws find textures in by number, at binding 0 of set
    /// 1.
    pub table: Option<&'a TextureTable>,
    /// The bytes per instance in the first of the buffers, for vertex shaders that take the number
    /// of the instance from `instance_number.glsl`; 0 for others.
    pub instance_bytes: u32,
    /// Points, lines or triangles, for geometry shaders with adjacency.
    pub topology: vk::PrimitiveTopology,
    /// The rasterisation of triangles.
    pub polygon: Polygon,
    /// Faces that are not drawn; counter-clockwise is front.
    pub cull: vk::CullModeFlags,
    /// The test of the depth, and its storage.
    pub depth: DepthMode,
    /// The depths that are drawn.
    pub range: DepthRange,
    /// The fragments that are drawn.
    pub fragments: FragmentChoice,
    /// The use of the stencil.
    pub stencil: StencilMode,
    /// The combination of the colour with the one that is there.
    pub blend: Blend,
    /// The attachments that it draws to.
    pub attachments: Attachments,
}

impl StorageLayout {
    /// Describes so many buffers, and push constants of type `C`.
    pub fn new<C>(buffers: u32) -> Self {
        Self { buffers, push_bytes: size_of::<C>() as u32, ..Self::default() }
    }
}

impl<'a> GraphicsPipelineInfo<'a> {
    /// Describes the plainest pipeline: both sides of triangles that the shader makes up, tested
    /// for as near or nearer, with nothing stored.
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

    /// Describes the same for a vertex shader that takes the number of the instance from
    /// `instance_number.glsl` and finds a `T` by it in the first buffer.
    #[must_use]
    pub fn numbered<T>(self) -> Self {
        Self { instance_bytes: size_of::<T>() as u32, ..self }
    }
}

/// A graphics pipeline.
pub struct GraphicsPipeline(pub(crate) PipelineKind);

/// A compute pipeline.
pub struct ComputePipeline(pub(crate) PipelineKind);

/// The objects that both kinds own.
pub(crate) struct PipelineKind {
    device: Device,
    pub(crate) raw: vk::Pipeline,
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) storage: vk::DescriptorSetLayout,
    pub(crate) buffers: u32,
    pub(crate) textures: u32,
    pub(crate) texture_arrays: u32,
    /// True if there is a set 1, a table of textures.
    pub(crate) has_table: bool,
    pub(crate) push_bytes: u32,
    /// As in [`GraphicsPipelineInfo::instance_bytes`].
    pub(crate) instance_bytes: u32,
    /// The stages that see buffers and constants.
    pub(crate) stages: vk::ShaderStageFlags,
}

of_device!(PipelineKind: "a pipeline");

impl GraphicsPipeline {
    /// Compiles a pipeline.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a wireframe, several views, a geometry shader or clamped depths
    /// where the device has no such thing; [`Error::Foreign`] for a table of another device; a
    /// failed call.
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
            if is_needed && !device.capabilities().has(optional) {
                let device = device.adapter().name.clone();
                return Err(Error::Unsupported { device, missing: optional.name(), wanted });
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

/// Calls `make` with the module of a shader, if there is one.
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
        // Owned from here on: dropped incomplete, it retires what is there; destroying null is
        // fine.
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
