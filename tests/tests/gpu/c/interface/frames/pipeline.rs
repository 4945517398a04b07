//! The pipeline of a host in C: boxes that are instances, in colours of their instance and bucket.

use ash::vk;
use cull::{Aabb, CullView};
use tests::host_device::Host;
use tests::host_images::OwnBuffer;

use super::images::has_stencil;

/// The indices of a box.
pub const INDICES: u32 = 36;

const SNAP: &str = include_str!("../../../../../../shaders/snap.glsl");

const VERTEX: &str = "
layout(location = 0) in vec3 low;
layout(location = 1) in vec3 high;
layout(location = 0) flat out uint number;
layout(push_constant) uniform Constants { mat4 clip_from_world; vec2 snap_steps; uint bucket; };
invariant gl_Position;
void main() {
    bvec3 is_high = notEqual(uvec3(gl_VertexIndex) & uvec3(1, 2, 4), uvec3(0));
    vec4 clip = clip_from_world * vec4(mix(low, high, is_high), 1.0);
    gl_Position = snapped(clip, snap_steps);
    number = (gl_InstanceIndex + 1) * 2654435761u ^ (bucket + 1) * 2246822519u;
}
";

const FRAGMENT: &str = "#version 460
layout(location = 0) flat in uint number;
layout(location = 0) out vec4 colour;
void main() { colour = vec4(vec3((uvec3(number) >> uvec3(8, 16, 24)) & 255u) / 255.0, 1.0); }
";

/// The corners of the triangles of a box, whose bits are x, y and z.
const CORNERS: [u16; INDICES as usize] = [
    0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 3,
    7, 1, 7, 5,
];

/// The sizes of the indices and the constants in bytes.
const INDEX_BYTES: u64 = INDICES as u64 * 2;
const CONSTANT_BYTES: u32 = 76;

/// A pipeline with its boxes. Destroyed by [`BoxPipeline::destroy`].
pub struct BoxPipeline {
    device: ash::Device,
    pipeline: vk::Pipeline,
    layout: vk::PipelineLayout,
    buffer: OwnBuffer,
}

impl BoxPipeline {
    /// Creates the pipeline for renderings to a colour and a depth of these formats, or for a pass.
    pub fn new(
        host: &Host,
        formats: [vk::Format; 2],
        samples: vk::SampleCountFlags,
        pass: Option<vk::RenderPass>,
        boxes: &[Aabb],
    ) -> Self {
        let device = host.device.clone();
        let range = vk::PushConstantRange {
            stage_flags: vk::ShaderStageFlags::VERTEX,
            offset: 0,
            size: CONSTANT_BYTES,
        };
        let info = vk::PipelineLayoutCreateInfo::default()
            .push_constant_ranges(std::slice::from_ref(&range));
        // SAFETY: a plain layout.
        let layout = unsafe { device.create_pipeline_layout(&info, None) }.unwrap();
        let pipeline = create(&device, layout, formats, samples, pass);
        let corners = CORNERS.iter().flat_map(|corner| corner.to_ne_bytes());
        let places = boxes
            .iter()
            .flat_map(|bounds| [bounds.min, bounds.max])
            .flat_map(|bounds| bounds.to_array());
        let bytes: Vec<u8> = corners.chain(places.flat_map(f32::to_ne_bytes)).collect();
        let usage = vk::BufferUsageFlags::INDEX_BUFFER | vk::BufferUsageFlags::VERTEX_BUFFER;
        let buffer = OwnBuffer::filled(host, &bytes, usage);
        Self { device, pipeline, layout, buffer }
    }

    /// Binds everything that the draws of a bucket need.
    pub fn bind(&self, commands: vk::CommandBuffer, view: &CullView, bucket: u32) {
        let floats = view.view_proj.to_cols_array().into_iter().chain(view.snap_steps);
        let words = floats.map(f32::to_bits).chain([bucket]);
        let constants: Vec<u8> = words.flat_map(u32::to_ne_bytes).collect();
        let device = &self.device;
        let buffer = self.buffer.buffer;
        let point = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: the host's own objects, in a rendering that fits the pipeline.
        unsafe {
            device.cmd_bind_pipeline(commands, point, self.pipeline);
            device.cmd_bind_index_buffer(commands, buffer, 0, vk::IndexType::UINT16);
            device.cmd_bind_vertex_buffers(commands, 0, &[buffer], &[INDEX_BYTES]);
            let stage = vk::ShaderStageFlags::VERTEX;
            device.cmd_push_constants(commands, self.layout, stage, 0, &constants);
        }
    }

    /// Destroys the pipeline. The GPU must not use it any more.
    pub fn destroy(self, host: &Host) {
        // SAFETY: created by this host, and no longer used, as the caller promises.
        unsafe {
            self.device.destroy_pipeline(self.pipeline, None);
            self.device.destroy_pipeline_layout(self.layout, None);
        }
        self.buffer.destroy(host);
    }
}

fn create(
    device: &ash::Device,
    layout: vk::PipelineLayout,
    formats: [vk::Format; 2],
    samples: vk::SampleCountFlags,
    pass: Option<vk::RenderPass>,
) -> vk::Pipeline {
    let [colour, depth] = formats;
    let modules =
        [("vert", format!("#version 460\n{SNAP}{VERTEX}")), ("frag", FRAGMENT.to_owned())]
            .map(|(stage, source)| module(device, stage, &source));
    let stages = [vk::ShaderStageFlags::VERTEX, vk::ShaderStageFlags::FRAGMENT];
    let stage = |n: usize| {
        let info = vk::PipelineShaderStageCreateInfo::default().name(c"main");
        info.stage(stages[n]).module(modules[n])
    };
    let stages = [stage(0), stage(1)];
    let attribute = |location, offset| vk::VertexInputAttributeDescription {
        location,
        binding: 0,
        format: vk::Format::R32G32B32_SFLOAT,
        offset,
    };
    let attributes = [attribute(0, 0), attribute(1, 12)];
    let bindings = [vk::VertexInputBindingDescription {
        binding: 0,
        stride: 24,
        input_rate: vk::VertexInputRate::INSTANCE,
    }];
    let input = vk::PipelineVertexInputStateCreateInfo::default()
        .vertex_binding_descriptions(&bindings)
        .vertex_attribute_descriptions(&attributes);
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
        .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let area = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
    let several = vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(samples);
    let tested = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(true)
        .depth_write_enable(true)
        .depth_compare_op(vk::CompareOp::GREATER_OR_EQUAL);
    let blends = [vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::RGBA)];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
    let states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&states);
    let formats = [colour];
    let mut rendering = vk::PipelineRenderingCreateInfo::default()
        .color_attachment_formats(&formats)
        .depth_attachment_format(depth);
    if has_stencil(depth) {
        rendering = rendering.stencil_attachment_format(depth);
    }
    let mut info = vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&input)
        .input_assembly_state(&assembly)
        .viewport_state(&area)
        .rasterization_state(&raster)
        .multisample_state(&several)
        .depth_stencil_state(&tested)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout);
    info = match pass {
        Some(pass) => info.render_pass(pass),
        None => info.push_next(&mut rendering),
    };
    // SAFETY: everything lives until the call returns; the modules are not needed afterwards.
    unsafe {
        let cache = vk::PipelineCache::null();
        let pipeline = device.create_graphics_pipelines(cache, &[info], None).unwrap()[0];
        modules.iter().for_each(|module| device.destroy_shader_module(*module, None));
        pipeline
    }
}

fn module(device: &ash::Device, stage: &str, source: &str) -> vk::ShaderModule {
    let name = format!("antumbra-c-boxes-{}.{stage}", std::process::id());
    let file = std::env::temp_dir().join(name);
    std::fs::write(&file, source).unwrap();
    let bytes = gpu::compile(&file).unwrap().to_bytes();
    std::fs::remove_file(file).unwrap();
    let word = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap());
    let words: Vec<u32> = bytes.chunks_exact(4).map(word).collect();
    let info = vk::ShaderModuleCreateInfo::default().code(&words);
    // SAFETY: words of the compiler.
    unsafe { device.create_shader_module(&info, None) }.unwrap()
}
