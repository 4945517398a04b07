//! The proxy pass: asks whether boxes would show, and changes nothing.

use bytemuck::{Pod, Zeroable};
use cull::{Aabb, View};
use gpu::{
    Blend, BufferSlice, Commands, DepthMode, Device, GraphicsPipeline, GraphicsPipelineInfo,
    StorageLayout, VertexLayout, vk,
};

use crate::error::Error;
use crate::shaders::ShaderSet;

/// Draws the front faces of boxes against the depth so far: no colour, no depth writes, no
/// fragment shader. What is made of it (queries today) is the caller's affair.
pub struct ProxyPass {
    pipeline: GraphicsPipeline,
}

/// Reads boxes and the depth that is being rendered to; writes nothing.
#[derive(Clone, Copy)]
pub struct ProxyIo {
    /// One [`ProxyBox`] per test.
    pub boxes: BufferSlice,
}

/// A box as the shader reads it; mirrors `proxy.vert`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct ProxyBox {
    low: [f32; 4],
    high: [f32; 4],
}

impl From<Aabb> for ProxyBox {
    fn from(bounds: Aabb) -> Self {
        Self { low: bounds.min.extend(0.0).to_array(), high: bounds.max.extend(0.0).to_array() }
    }
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    view_proj: [f32; 16],
    eye: [f32; 4],
}

const _: () = assert!(size_of::<Constants>() == 80);

/// Three faces of two triangles.
const VERTICES: u32 = 18;

impl ProxyPass {
    /// Compiles the pass.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        let pipeline = GraphicsPipeline::new(
            device,
            &GraphicsPipelineInfo {
                name: "proxies",
                vertex: shaders.find("proxy.vert")?,
                fragment: None,
                vertices: VertexLayout::default(),
                storage: StorageLayout { buffers: 1, push_bytes: size_of::<Constants>() as u32 },
                topology: vk::PrimitiveTopology::TRIANGLE_LIST,
                cull: vk::CullModeFlags::NONE,
                depth: DepthMode::TestOnly,
                blend: Blend::NoColour,
            },
        )?;
        Ok(Self { pipeline })
    }

    /// Binds everything; the caller then records [`ProxyPass::draw`] for each test.
    pub fn bind(&self, commands: &Commands, io: &ProxyIo, view: &View) {
        commands.bind(&self.pipeline, &[io.boxes]);
        let (view_proj, eye) = (view.view_proj.to_cols_array(), view.eye.extend(1.0).to_array());
        commands.push_constants(&self.pipeline, &Constants { view_proj, eye });
    }

    /// Draws box `test`.
    pub fn draw(&self, commands: &Commands, test: u32) {
        commands.draw(VERTICES, test);
    }
}
