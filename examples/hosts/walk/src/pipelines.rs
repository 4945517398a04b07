//! The pipelines of hosts that record with raw Vulkan: one per bucket.

use std::error::Error;

use ash::vk;
use bytemuck::{Pod, Zeroable};

/// A pipeline per bucket, for dynamic rendering.
pub struct BoxPipelines {
    device: ash::Device,
    layout: vk::PipelineLayout,
    buckets: Vec<vk::Pipeline>,
}

/// The geometry of all boxes.
#[derive(Clone, Copy, Debug)]
pub struct BoxGeometry {
    /// The corners of each box.
    pub corners: vk::Buffer,
    /// The indices of any box.
    pub indices: vk::Buffer,
}

/// The push constants of the vertex shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ViewConstants {
    /// World to clip space.
    pub view_proj: [f32; 16],
    /// Steps of the sub-pixel grid from the middle of the image to its edges.
    pub snap_steps: [f32; 2],
}

impl BoxPipelines {
    /// Creates the pipelines for a colour and a depth format.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(device: &ash::Device, formats: [vk::Format; 2]) -> Result<Self, Box<dyn Error>> {
        let range = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::VERTEX)
            .size(size_of::<ViewConstants>() as u32)];
        let layout = vk::PipelineLayoutCreateInfo::default().push_constant_ranges(&range);
        // SAFETY: a plain object of the host's own device.
        let layout = unsafe { device.create_pipeline_layout(&layout, None) }?;
        let [colour, depth] = formats;
        let buckets = crate::FRAGMENTS.iter();
        let buckets = buckets.map(|code| create_pipeline(device, layout, code, colour, depth));
        let buckets = buckets.collect::<Result<_, _>>()?;
        Ok(Self { device: device.clone(), layout, buckets })
    }

    /// Binds the pipeline of a bucket with the geometry of all boxes.
    ///
    /// # Safety
    /// The command buffer is being recorded, and all lives until it is over on the GPU.
    pub unsafe fn bind(
        &self,
        commands: vk::CommandBuffer,
        bucket: u32,
        geometry: BoxGeometry,
        constants: &ViewConstants,
    ) {
        let device = &self.device;
        let bytes = bytemuck::bytes_of(constants);
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        let stage = vk::ShaderStageFlags::VERTEX;
        // SAFETY: the caller's promise.
        unsafe {
            device.cmd_bind_pipeline(commands, graphics, self.buckets[bucket as usize]);
            device.cmd_bind_vertex_buffers(commands, 0, &[geometry.corners], &[0]);
            device.cmd_bind_index_buffer(commands, geometry.indices, 0, vk::IndexType::UINT32);
            device.cmd_push_constants(commands, self.layout, stage, 0, bytes);
        }
    }

    /// Destroys them. The GPU is done with them.
    pub fn destroy(self) {
        // SAFETY: the caller says that nothing is used any more.
        unsafe {
            self.buckets.iter().for_each(|bucket| self.device.destroy_pipeline(*bucket, None));
            self.device.destroy_pipeline_layout(self.layout, None);
        }
    }
}

fn create_pipeline(
    device: &ash::Device,
    layout: vk::PipelineLayout,
    fragment: &[u8],
    colour: vk::Format,
    depth: vk::Format,
) -> Result<vk::Pipeline, Box<dyn Error>> {
    let modules = [create_module(device, crate::BOX_VERT)?, create_module(device, fragment)?];
    let stages = [vk::ShaderStageFlags::VERTEX, vk::ShaderStageFlags::FRAGMENT];
    let stage = |(flag, module)| {
        vk::PipelineShaderStageCreateInfo::default().stage(flag).module(module).name(c"main")
    };
    let stages: Vec<_> = stages.into_iter().zip(modules).map(stage).collect();
    let bindings = [vk::VertexInputBindingDescription {
        binding: 0,
        stride: 24,
        input_rate: vk::VertexInputRate::INSTANCE,
    }];
    let format = vk::Format::R32G32B32_SFLOAT;
    let attributes = [0, 1].map(|location| vk::VertexInputAttributeDescription {
        location,
        binding: 0,
        format,
        offset: location * 12,
    });
    let input = vk::PipelineVertexInputStateCreateInfo::default()
        .vertex_binding_descriptions(&bindings)
        .vertex_attribute_descriptions(&attributes);
    let triangles = vk::PrimitiveTopology::TRIANGLE_LIST;
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(triangles);
    let viewport =
        vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
    let one = vk::SampleCountFlags::TYPE_1;
    let samples = vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(one);
    let depth_test = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(true)
        .depth_write_enable(true)
        .depth_compare_op(vk::CompareOp::GREATER);
    let targets = [vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::RGBA)];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&targets);
    let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
    let formats = [colour];
    let mut rendering = vk::PipelineRenderingCreateInfo::default()
        .color_attachment_formats(&formats)
        .depth_attachment_format(depth);
    let info = vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&samples)
        .depth_stencil_state(&depth_test)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout)
        .push_next(&mut rendering);
    let cache = vk::PipelineCache::null();
    // SAFETY: the stages fit the layout; the modules are not used after the creation.
    unsafe {
        let made = device.create_graphics_pipelines(cache, &[info], None);
        modules.into_iter().for_each(|module| device.destroy_shader_module(module, None));
        made.map_err(|(_, code)| code)?.pop().ok_or_else(|| "no pipeline was made".into())
    }
}

fn create_module(device: &ash::Device, spirv: &[u8]) -> Result<vk::ShaderModule, vk::Result> {
    let code = bytemuck::pod_collect_to_vec::<u8, u32>(spirv);
    let info = vk::ShaderModuleCreateInfo::default().code(&code);
    // SAFETY: valid SPIR-V, compiled from the shaders of the walk.
    unsafe { device.create_shader_module(&info, None) }
}
