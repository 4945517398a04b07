//! The sky pass: a colour where nothing was drawn.

use bytemuck::{Pod, Zeroable};
use gpu::{Blend, Commands, Device, GraphicsPipeline, GraphicsPipelineInfo, StorageLayout};

use occlusion::{Error, ShaderSet};

/// The pass that draws one triangle over all of the area at the farthest depth: it shows where
/// nothing is nearer.
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
            fragment: Some(shaders.find("sky.frag")?),
            storage: StorageLayout::new::<Constants>(0),
            blend: Blend::Opaque,
            ..GraphicsPipelineInfo::of("sky", shaders.find("sky.vert")?)
        };
        Ok(Self { pipeline: GraphicsPipeline::new(device, &info)? })
    }

    /// Draws the sky in a linear colour, against the depth that is there.
    pub fn draw(&self, commands: &Commands, sky: [f32; 3]) {
        let [red, green, blue] = sky;
        commands.bind(&self.pipeline, &[]);
        commands.push_constants(&self.pipeline, &Constants { sky: [red, green, blue, 1.0] });
        commands.draw(3, 0);
    }
}
