//! The flat pass: triangles in pixels over a finished image, for text and graphs.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use gpu::{
    Attachments, Blend, BufferSlice, Commands, DepthMode, Device, DynamicTexture, GraphicsPipeline,
    GraphicsPipelineInfo, IndirectDraw, SampledArrays, StorageLayout, VertexLayout, vk,
};

use occlusion::{Error, ShaderSet};

/// The pass that draws flat triangles out of one atlas, in their order, at any depth.
pub struct FlatPass {
    pipeline: GraphicsPipeline,
}

/// The inputs of the pass: reads vertices, indices and the atlas; blends into the colour that is
/// being rendered to.
#[derive(Clone, Copy)]
pub struct FlatIo<'a> {
    /// The corners of the triangles, one [`FlatVertex`] each.
    pub vertices: BufferSlice,
    /// 32-bit indices into them, three per triangle.
    pub indices: BufferSlice,
    /// The image that all of them sample.
    pub atlas: &'a DynamicTexture,
}

/// A corner of a flat triangle.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct FlatVertex {
    /// Pixels from the upper left corner of the image.
    pub position: [f32; 2],
    /// Place in the atlas, 0 to 1 from its upper left.
    pub texture_position: [f32; 2],
    /// sRGB-encoded red, green and blue, multiplied by alpha, and alpha.
    pub colour: [u8; 4],
}

/// Triangles that are cut to the same part of the image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FlatDraw {
    /// Upper left corner of the part (pixels).
    pub origin: [u32; 2],
    /// Its size (pixels).
    pub size: [u32; 2],
    /// The indices of their corners, three per triangle.
    pub indices: Range<u32>,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    clip_per_pixel: [f32; 2],
}

const _: () = assert!(size_of::<Constants>() == 8);
const _: () = assert!(size_of::<FlatVertex>() == 20);

impl FlatPass {
    /// Compiles the pass for renderings to `attachments`.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        let info = GraphicsPipelineInfo {
            fragment: Some(shaders.find("flat.frag")?),
            vertices: VertexLayout {
                stride_bytes: size_of::<FlatVertex>() as u32,
                beside: None,
                attributes: &[
                    (vk::Format::R32G32_SFLOAT, 0),
                    (vk::Format::R32G32_SFLOAT, 8),
                    (vk::Format::R8G8B8A8_UNORM, 16),
                ],
            },
            storage: StorageLayout { textures: 1, ..StorageLayout::new::<Constants>(0) },
            depth: DepthMode::Ignored,
            blend: Blend::Premultiplied,
            attachments,
            ..GraphicsPipelineInfo::of("flat", shaders.find("flat.vert")?)
        };
        Ok(Self { pipeline: GraphicsPipeline::new(device, &info)? })
    }

    /// Draws `draws` in their order, each cut to its part, in an image of `size` pixels.
    pub fn record(&self, commands: &Commands, io: &FlatIo<'_>, draws: &[FlatDraw], size: [u32; 2]) {
        let constants = Constants { clip_per_pixel: size.map(|side| 2.0 / side as f32) };
        commands.bind_sampled(&self.pipeline, &[], &[io.atlas.sampled()], SampledArrays::NONE);
        commands.push_constants(&self.pipeline, &constants);
        commands.bind_geometry(io.vertices, Some(io.indices));
        for draw in draws {
            commands.clip(draw.origin, draw.size);
            commands.draw_indexed(&IndirectDraw {
                index_count: draw.indices.end.saturating_sub(draw.indices.start),
                instance_count: 1,
                first_index: draw.indices.start,
                ..IndirectDraw::default()
            });
        }
    }
}
