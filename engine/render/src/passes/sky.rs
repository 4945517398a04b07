//! The sky pass: a colour for the pixels where nothing was drawn.

use bytemuck::{Pod, Zeroable};
use gpu::{
    Blend, Commands, DepthMode, Device, GraphicsPipeline, GraphicsPipelineInfo, Polygon,
    StorageLayout, VertexLayout, vk,
};

use crate::error::Error;
use crate::shaders::ShaderSet;

/// Colours what nothing is nearer than. Reads the depth and writes the colour that are being rendered to.
pub struct SkyPass {
    pipeline: GraphicsPipeline,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    sky: [f32; 4],
}

const _: () = assert!(size_of::<Constants>() == 16);

impl SkyPass {
    /// Compiles the pass.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        let info = GraphicsPipelineInfo {
            name: "sky",
            vertex: shaders.find("sky.vert")?,
            fragment: Some(shaders.find("sky.frag")?),
            vertices: VertexLayout::default(),
            storage: StorageLayout {
                buffers: 0,
                textures: 0,
                push_bytes: size_of::<Constants>() as u32,
            },
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            polygon: Polygon::Filled,
            cull: vk::CullModeFlags::NONE,
            // As near or nearer: only depths of 0 are as far away as this.
            depth: DepthMode::TestOnly,
            blend: Blend::Opaque,
        };
        Ok(Self { pipeline: GraphicsPipeline::new(device, &info)? })
    }

    /// Draws it in a linear colour.
    pub fn record(&self, commands: &Commands, sky: [f32; 4]) {
        commands.bind(&self.pipeline, &[]);
        commands.push_constants(&self.pipeline, &Constants { sky });
        commands.draw(3, 0);
    }
}
