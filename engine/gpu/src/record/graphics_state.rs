//! The fixed states of a graphics pipeline, derived from its description.

use ash::vk;

use crate::core::capabilities::OptionalFeature;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::memory::instance_numbers::{NUMBER_BINDING, NUMBER_LOCATION};
use crate::record::attachments::{Attachments, COLOURS_MAX, NearDepth};
use crate::record::pipeline::{
    Blend, DepthMode, DepthRange, FragmentChoice, GraphicsPipelineInfo, Polygon, StencilMode,
    VertexLayout,
};

/// Compiles a graphics pipeline with all its fixed states.
pub(super) fn create_graphics(
    device: &Device,
    info: &GraphicsPipelineInfo<'_>,
    layout: vk::PipelineLayout,
    stages: &[vk::PipelineShaderStageCreateInfo<'_>],
) -> Result<vk::Pipeline, Error> {
    let (bindings, attributes) = vertex_input(info);
    let mut vertices = vk::PipelineVertexInputStateCreateInfo::default();
    if !attributes.is_empty() {
        vertices = vertices
            .vertex_binding_descriptions(&bindings)
            .vertex_attribute_descriptions(&attributes);
    }
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(info.topology);
    let viewport =
        vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let Attachments { colours, depth: depth_format, near_depth, .. } = info.attachments;
    let raster = rasterisation(info);
    let first_sample: [vk::SampleMask; 1] = [1];
    let samples = vk::PipelineMultisampleStateCreateInfo::default()
        .rasterization_samples(info.attachments.samples);
    let samples = if info.fragments == FragmentChoice::FirstSample {
        samples.sample_mask(&first_sample)
    } else {
        samples
    };
    let depth = depth_stencil(info, near_depth);
    let blends = [blend_state(info.blend); COLOURS_MAX];
    let blends = blends.get(..colours.as_slice().len()).unwrap_or(&blends);
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(blends);
    let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
    let mut rendering = vk::PipelineRenderingCreateInfo::default()
        .view_mask(info.attachments.view_mask())
        .color_attachment_formats(colours.as_slice())
        .depth_attachment_format(depth_format)
        .stencil_attachment_format(info.attachments.stencil());
    let create = vk::GraphicsPipelineCreateInfo::default()
        .stages(stages)
        .vertex_input_state(&vertices)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&samples)
        .depth_stencil_state(&depth)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout);
    let create = match info.attachments.pass {
        Some(pass) => create.render_pass(pass.render_pass).subpass(pass.subpass),
        None => create.push_next(&mut rendering),
    };
    let mut one = vk::PipelineRepresentativeFragmentTestStateCreateInfoNV::default()
        .representative_fragment_test_enable(true);
    let has_one = device.capabilities().has(OptionalFeature::RepresentativeFragments);
    let create = match info.fragments {
        FragmentChoice::Representative if has_one => create.push_next(&mut one),
        FragmentChoice::Representative | FragmentChoice::FirstSample | FragmentChoice::All => {
            create
        }
    };
    let cache = device.pipeline_cache();
    let callbacks = device.callbacks();
    // SAFETY: modules and layout are alive, and all states are given.
    unsafe { device.raw().create_graphics_pipelines(cache, &[create], callbacks) }
        .map_err(|(_, code)| code)
        .called("vkCreateGraphicsPipelines")
        .map(|pipelines| pipelines.first().copied().unwrap_or_default())
}

/// Returns the rasterisation state.
fn rasterisation(
    info: &GraphicsPipelineInfo<'_>,
) -> vk::PipelineRasterizationStateCreateInfo<'static> {
    let mode = match info.polygon {
        Polygon::Filled => vk::PolygonMode::FILL,
        Polygon::Wireframe => vk::PolygonMode::LINE,
    };
    let (constant, slope) = depth_bias(info);
    vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(mode)
        .depth_clamp_enable(info.range == DepthRange::Clamped)
        .depth_bias_enable(constant != 0.0)
        .depth_bias_constant_factor(constant)
        .depth_bias_slope_factor(slope)
        .cull_mode(info.cull)
        .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
        .line_width(1.0)
}

/// Returns the state of the depth test and the stencil test.
fn depth_stencil(
    info: &GraphicsPipelineInfo<'_>,
    near_depth: NearDepth,
) -> vk::PipelineDepthStencilStateCreateInfo<'static> {
    let (write, compare) = depth_test(info.depth, near_depth);
    let [front, back] = stencil_of_faces(info.stencil);
    vk::PipelineDepthStencilStateCreateInfo::default()
        .stencil_test_enable(info.stencil != StencilMode::Ignored)
        .front(front)
        .back(back)
        .depth_test_enable(true)
        .depth_write_enable(write)
        .depth_compare_op(compare)
}

/// Returns true if depth is written, and the comparison of the depth test.
fn depth_test(mode: DepthMode, near_depth: NearDepth) -> (bool, vk::CompareOp) {
    use vk::CompareOp as Op;
    let (nearer, as_near, farther) = match near_depth {
        NearDepth::One => (Op::GREATER, Op::GREATER_OR_EQUAL, Op::LESS),
        NearDepth::Zero => (Op::LESS, Op::LESS_OR_EQUAL, Op::GREATER),
    };
    match mode {
        DepthMode::TestAndWrite => (true, nearer),
        DepthMode::TestEqualAndWrite => (true, as_near),
        DepthMode::TestOnly => (false, as_near),
        DepthMode::TestNearer => (false, nearer),
        DepthMode::TestFarther => (false, farther),
        DepthMode::Equal => (false, Op::EQUAL),
        DepthMode::Ignored => (false, Op::ALWAYS),
    }
}

/// The stencil bit that is set for an odd number.
const PARITY: u32 = 1;

/// Returns the test for an odd number, with the operation on it if the depth test passes.
fn odd(pass_op: vk::StencilOp) -> vk::StencilOpState {
    vk::StencilOpState {
        compare_op: vk::CompareOp::NOT_EQUAL,
        compare_mask: PARITY,
        write_mask: PARITY,
        pass_op,
        depth_fail_op: vk::StencilOp::ZERO,
        ..Default::default()
    }
}

/// Returns the stencil states of front and back faces.
fn stencil_of_faces(mode: StencilMode) -> [vk::StencilOpState; 2] {
    use vk::StencilOp as Op;
    let ignored = vk::StencilOpState { compare_mask: 0xFF, ..Default::default() };
    let counted =
        vk::StencilOpState { compare_op: vk::CompareOp::ALWAYS, write_mask: 0xFF, ..ignored };
    let more = Op::INCREMENT_AND_WRAP;
    let less = Op::DECREMENT_AND_WRAP;
    match mode {
        StencilMode::Ignored => [ignored; 2],
        StencilMode::CountPassing => {
            [more, less].map(|pass_op| vk::StencilOpState { pass_op, ..counted })
        }
        StencilMode::CountFailing => {
            [less, more].map(|depth_fail_op| vk::StencilOpState { depth_fail_op, ..counted })
        }
        StencilMode::Counted => {
            [vk::StencilOpState { compare_op: vk::CompareOp::NOT_EQUAL, ..ignored }; 2]
        }
        StencilMode::Mark => {
            [vk::StencilOpState { pass_op: Op::REPLACE, reference: 1, ..counted }; 2]
        }
        StencilMode::Unmarked => {
            [vk::StencilOpState { compare_op: vk::CompareOp::EQUAL, ..ignored }; 2]
        }
        StencilMode::Parity => {
            let pass_op = Op::INVERT;
            let write_mask = PARITY;
            [vk::StencilOpState { pass_op, write_mask, ..counted }; 2]
        }
        StencilMode::Odd => [odd(Op::ZERO); 2],
        StencilMode::OddDrawn => [odd(Op::KEEP); 2],
    }
}

/// Returns the constant depth bias towards the eye and the bias per slope; 0 for none.
///
/// Proxies get a bias if depth is an integer: the margin of a proxy exceeds the rounding of a
/// float, but far away it is less than a step of 16 bits. Two steps cover the rounding of both
/// depths, of the proxy and of the object in it.
fn depth_bias(info: &GraphicsPipelineInfo<'_>) -> (f32, f32) {
    let nearer = match info.attachments.near_depth {
        NearDepth::One => 1.0,
        NearDepth::Zero => -1.0,
    };
    let is_proxy = info.depth == DepthMode::TestOnly && info.blend == Blend::NoColour;
    match info.polygon {
        Polygon::Wireframe => (16.0 * nearer, nearer),
        Polygon::Filled if is_proxy && info.attachments.has_integer_depth() => (2.0 * nearer, 0.0),
        Polygon::Filled => (0.0, 0.0),
    }
}

/// Returns the vertex bindings and their attributes, with the instance index last.
fn vertex_input(
    info: &GraphicsPipelineInfo<'_>,
) -> (Vec<vk::VertexInputBindingDescription>, Vec<vk::VertexInputAttributeDescription>) {
    let mut bindings = Vec::new();
    let mut attributes = Vec::new();
    // A binding without attributes would still have to be bound.
    let mut next: Option<&VertexLayout<'_>> =
        Some(&info.vertices).filter(|layout| !layout.attributes.is_empty());
    while let Some(layout) = next {
        let binding = bindings.len() as u32;
        bindings.push(vk::VertexInputBindingDescription {
            binding,
            stride: layout.stride_bytes,
            input_rate: vk::VertexInputRate::VERTEX,
        });
        for &(format, offset) in layout.attributes {
            let location = attributes.len() as u32;
            attributes.push(vk::VertexInputAttributeDescription {
                location,
                binding,
                format,
                offset,
            });
        }
        next = layout.beside;
    }
    if info.instance_bytes > 0 {
        bindings.push(vk::VertexInputBindingDescription {
            binding: NUMBER_BINDING,
            stride: size_of::<u32>() as u32,
            input_rate: vk::VertexInputRate::INSTANCE,
        });
        attributes.push(vk::VertexInputAttributeDescription {
            location: NUMBER_LOCATION,
            binding: NUMBER_BINDING,
            format: vk::Format::R32_UINT,
            offset: 0,
        });
    }
    (bindings, attributes)
}

fn blend_state(blend: Blend) -> vk::PipelineColorBlendAttachmentState {
    let all = vk::ColorComponentFlags::RGBA;
    let state = vk::PipelineColorBlendAttachmentState::default();
    match blend {
        Blend::NoColour => state.color_write_mask(vk::ColorComponentFlags::empty()),
        Blend::Opaque => state.color_write_mask(all),
        Blend::Alpha => state
            .color_write_mask(all)
            .blend_enable(true)
            .src_color_blend_factor(vk::BlendFactor::SRC_ALPHA)
            .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .color_blend_op(vk::BlendOp::ADD)
            .src_alpha_blend_factor(vk::BlendFactor::ZERO)
            .dst_alpha_blend_factor(vk::BlendFactor::ONE)
            .alpha_blend_op(vk::BlendOp::ADD),
        // The blend factors are not used.
        Blend::Max => state
            .color_write_mask(all)
            .blend_enable(true)
            .color_blend_op(vk::BlendOp::MAX)
            .alpha_blend_op(vk::BlendOp::MAX),
        Blend::Premultiplied => {
            blend_state(Blend::Alpha).src_color_blend_factor(vk::BlendFactor::ONE)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::shader::Spirv;

    #[test]
    fn what_is_not_hidden_is_visible() {
        use vk::CompareOp as Op;
        let test = |mode, near| depth_test(mode, near).1;
        for (near, visible, hidden) in [
            (NearDepth::One, Op::GREATER_OR_EQUAL, Op::LESS),
            (NearDepth::Zero, Op::LESS_OR_EQUAL, Op::GREATER),
        ] {
            assert_eq!(test(DepthMode::TestOnly, near), visible);
            assert_eq!(test(DepthMode::TestFarther, near), hidden);
        }
    }

    #[test]
    fn proxies_are_moved_towards_the_eye_where_depth_has_steps() {
        let mut bytes = 0x0723_0203_u32.to_le_bytes().to_vec();
        bytes.extend([0; 16]);
        let shader = Spirv::from_bytes("x", &bytes).unwrap();
        let bias = |depth, near_depth, mode| {
            let mut info = GraphicsPipelineInfo::of("x", &shader);
            info.attachments = Attachments { depth, near_depth, ..Attachments::default() };
            info.depth = mode;
            depth_bias(&info).0
        };
        let float = vk::Format::D32_SFLOAT;
        let steps = vk::Format::D16_UNORM;
        assert_eq!(bias(float, NearDepth::One, DepthMode::TestOnly), 0.0);
        assert_eq!(bias(steps, NearDepth::One, DepthMode::TestOnly), 2.0);
        assert_eq!(bias(steps, NearDepth::Zero, DepthMode::TestOnly), -2.0);
        assert_eq!(bias(steps, NearDepth::One, DepthMode::TestAndWrite), 0.0);
    }
}
