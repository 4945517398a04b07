//! The overlay pass: coloured triangles and lines in the world, for images that explain.

use bytemuck::{Pod, Zeroable};
use cull::CullView;
use gpu::{
    Attachments, Blend, BufferSlice, Commands, DepthMode, Device, GraphicsPipeline,
    GraphicsPipelineInfo, StorageLayout, VertexLayout, vk,
};

use occlusion::{Error, ShaderSet};

/// The pass that draws translucent triangles and lines over a finished image, with or without a
/// depth test.
pub struct OverlayPass {
    triangles: GraphicsPipeline,
    lines: GraphicsPipeline,
    lines_through: GraphicsPipeline,
}

/// The buffers of the pass. Vertices are read; the colour that is being rendered to is blended
/// with.
#[derive(Clone, Copy)]
pub struct OverlayIo {
    /// [`OverlayVertex`]es, three per triangle, and their number.
    pub triangles: (BufferSlice, u32),
    /// [`OverlayVertex`]es, two per line, and their number.
    pub lines: (BufferSlice, u32),
    /// [`OverlayVertex`]es of lines drawn over everything, two per line, and their number.
    pub lines_through: (BufferSlice, u32),
}

/// A coloured point in the world.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct OverlayVertex {
    /// The position in the world, in metres.
    pub position: [f32; 3],
    /// Linear red, green, blue and opacity as unorm8x4, red in the lowest byte.
    pub colour: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    from_anchor: [f32; 16],
    anchor: [f32; 4],
}

const _: () = assert!(size_of::<Constants>() == 80);

impl OverlayPass {
    /// Compiles the pass for renderings to `attachments`.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        let pipeline = |name, topology, depth| {
            GraphicsPipeline::new(
                device,
                &GraphicsPipelineInfo {
                    fragment: Some(shaders.find("overlay.frag")?),
                    vertices: VertexLayout {
                        stride_bytes: size_of::<OverlayVertex>() as u32,
                        beside: None,
                        attributes: &[
                            (vk::Format::R32G32B32_SFLOAT, 0),
                            (vk::Format::R8G8B8A8_UNORM, 12),
                        ],
                    },
                    storage: StorageLayout::new::<Constants>(0),
                    topology,
                    depth,
                    blend: Blend::Alpha,
                    attachments,
                    ..GraphicsPipelineInfo::of(name, shaders.find("overlay.vert")?)
                },
            )
            .map_err(Error::from)
        };
        let triangles = vk::PrimitiveTopology::TRIANGLE_LIST;
        let lines = vk::PrimitiveTopology::LINE_LIST;
        Ok(Self {
            triangles: pipeline("overlay triangles", triangles, DepthMode::TestOnly)?,
            lines: pipeline("overlay lines", lines, DepthMode::TestOnly)?,
            lines_through: pipeline("overlay lines through all", lines, DepthMode::Ignored)?,
        })
    }

    /// Draws the triangles in their order, then the lines.
    pub fn record(&self, commands: &Commands, io: &OverlayIo, view: &CullView) {
        let constants = Constants {
            from_anchor: view.from_anchor.to_cols_array(),
            anchor: view.anchor.extend(0.0).to_array(),
        };
        for (pipeline, (vertices, count)) in [
            (&self.triangles, io.triangles),
            (&self.lines, io.lines),
            (&self.lines_through, io.lines_through),
        ] {
            if count > 0 {
                commands.bind(pipeline, &[]);
                commands.push_constants(pipeline, &constants);
                commands.bind_geometry(vertices, None);
                commands.draw(count, 0);
            }
        }
    }
}
