//! Pipelines that tessellate patches without drawing: their triangles are captured in a buffer.

use ash::vk;

use crate::core::capabilities::OptionalFeature;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::record::pipeline::{PipelineKind, StorageLayout};
use crate::record::shader::Spirv;

/// The number of control points per patch.
pub(crate) const PATCH_POINTS: u32 = 16;

/// The description of a pipeline that captures tessellated triangles.
#[derive(Debug, Clone, Copy)]
pub struct CapturePipelineInfo<'a> {
    /// The name in messages and debuggers.
    pub name: &'a str,
    /// The vertex shader, which reads the control points by their index, 16 per patch.
    pub vertex: &'a Spirv,
    /// The tessellation control shader, which sets the levels.
    pub control: &'a Spirv,
    /// The tessellation evaluation shader. Its outputs declare their offsets in the captured vertex
    /// (`xfb_offset`). Triangles are stored consecutively, with three vertices each.
    pub evaluation: &'a Spirv,
    /// The buffers and constants of the shaders.
    pub storage: StorageLayout,
}

/// A pipeline for [`Commands::capture`](crate::Commands::capture).
pub struct CapturePipeline(pub(crate) PipelineKind);

impl CapturePipeline {
    /// Compiles a pipeline.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device lacks [`OptionalFeature::TessellationCapture`]; a
    /// failed call.
    pub fn new(device: &Device, info: &CapturePipelineInfo<'_>) -> Result<Self, Error> {
        let wanted = "a capture of tessellated triangles";
        device.require(OptionalFeature::TessellationCapture, wanted)?;
        use vk::ShaderStageFlags as Stage;
        let stages = Stage::VERTEX | Stage::TESSELLATION_CONTROL | Stage::TESSELLATION_EVALUATION;
        PipelineKind::new(device, info.name, info.storage, None, stages, |layout| {
            info.vertex.with_stage(device, Stage::VERTEX, |vertex| {
                info.control.with_stage(device, Stage::TESSELLATION_CONTROL, |control| {
                    info.evaluation.with_stage(
                        device,
                        Stage::TESSELLATION_EVALUATION,
                        |evaluation| create(device, layout, &[vertex, control, evaluation]),
                    )
                })
            })
        })
        .map(Self)
    }
}

fn create(
    device: &Device,
    layout: vk::PipelineLayout,
    stages: &[vk::PipelineShaderStageCreateInfo<'_>],
) -> Result<vk::Pipeline, Error> {
    let vertices = vk::PipelineVertexInputStateCreateInfo::default();
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
        .topology(vk::PrimitiveTopology::PATCH_LIST);
    let tessellation =
        vk::PipelineTessellationStateCreateInfo::default().patch_control_points(PATCH_POINTS);
    let raster = vk::PipelineRasterizationStateCreateInfo::default()
        .rasterizer_discard_enable(true)
        .line_width(1.0);
    let mut rendering = vk::PipelineRenderingCreateInfo::default();
    let create = vk::GraphicsPipelineCreateInfo::default()
        .stages(stages)
        .vertex_input_state(&vertices)
        .input_assembly_state(&assembly)
        .tessellation_state(&tessellation)
        .rasterization_state(&raster)
        .layout(layout)
        .push_next(&mut rendering);
    let cache = device.pipeline_cache();
    // SAFETY: modules and layout are alive; nothing is rasterised, so no other state is read.
    unsafe { device.raw().create_graphics_pipelines(cache, &[create], device.callbacks()) }
        .map_err(|(_, code)| code)
        .called("vkCreateGraphicsPipelines")
        .map(|pipelines| pipelines.first().copied().unwrap_or_default())
}
