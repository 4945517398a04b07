//! The simplest things to draw: boxes through the engine's own proxy shader, as occluders and tests.

use bytemuck::{Pod, Zeroable};
use cull::{Aabb, Camera, View};
use glam::Vec3;
use gpu::{
    Blend, BufferSlice, Commands, DepthMode, Device, GraphicsPipeline, GraphicsPipelineInfo, Spirv,
    StorageLayout, VertexLayout, vk,
};
use render::{ProxyPass, ShaderSet};

/// Draws boxes into the depth buffer only.
pub struct DepthBoxes {
    pipeline: GraphicsPipeline,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    view_proj: [f32; 16],
    eye: [f32; 4],
}

impl DepthBoxes {
    /// Compiles it.
    pub fn new(device: &Device) -> Self {
        let shader = render::SHADERS.iter().find(|shader| shader.name == "proxy.vert");
        let spirv = Spirv::from_bytes("proxy.vert", shader.expect("the shader").spirv);
        let info = GraphicsPipelineInfo {
            name: "depth boxes",
            vertex: &spirv.expect("SPIR-V"),
            fragment: None,
            vertices: VertexLayout::default(),
            storage: StorageLayout { buffers: 1, push_bytes: size_of::<Constants>() as u32 },
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            cull: vk::CullModeFlags::NONE,
            depth: DepthMode::TestAndWrite,
            blend: Blend::NoColour,
        };
        Self { pipeline: GraphicsPipeline::new(device, &info).expect("a pipeline") }
    }

    /// Draws box `index` of `boxes`.
    pub fn draw(&self, commands: &Commands, boxes: BufferSlice, view: &View, index: u32) {
        let (view_proj, eye) = (view.view_proj.to_cols_array(), view.eye.extend(1.0).to_array());
        commands.bind(&self.pipeline, &[boxes]);
        commands.push_constants(&self.pipeline, &Constants { view_proj, eye });
        commands.draw(18, index);
    }
}

/// The engine's own proxy pass.
pub fn proxy_pass(device: &Device) -> ProxyPass {
    ProxyPass::new(device, &ShaderSet::embedded().expect("shaders")).expect("a pipeline")
}

/// A camera at the origin that looks along -z, on a square picture.
pub fn square_view(device: &Device, side: u32) -> View {
    let camera = Camera {
        eye: Vec3::ZERO,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        fov_y: std::f32::consts::FRAC_PI_2,
        near: 0.1,
    };
    View::new(&camera, [side, side], device.adapter().limits.sub_pixel_precision_bits)
}

/// A box around `centre`.
pub fn box_at(centre: Vec3, half: Vec3) -> Aabb {
    Aabb { min: centre - half, max: centre + half }
}
