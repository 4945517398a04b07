//! The owner of the objects: boxes, and the pipeline that draws their depth.

use antumbra_occlusion::{BucketId, Error, ObjectRenderer, ProxyBox, Rendering, ShaderSet};
use cull::{Aabb, CullView};
use gpu::{
    Buffer, Commands, DepthMode, Device, GraphicsPipeline, GraphicsPipelineInfo, RenderTarget,
    StorageLayout, Target, vk,
};

pub const INDICES: u32 = 18; // of the three faces of a box that can face the eye

pub struct Boxes {
    target: Target,
    pipeline: GraphicsPipeline,
    boxes: Buffer,
    indices: Buffer,
}

impl Boxes {
    pub fn new(device: &Device, shaders: &ShaderSet, bounds: &[Aabb]) -> Result<Self, Error> {
        let boxes: Vec<ProxyBox> = bounds.iter().map(|bounds| ProxyBox::from(*bounds)).collect();
        let vertex = shaders.find("proxy.vert")?;
        let info = GraphicsPipelineInfo {
            storage: StorageLayout { buffers: 1, push_bytes: 80, ..Default::default() },
            depth: DepthMode::TestAndWrite,
            ..GraphicsPipelineInfo::of("boxes", vertex).numbered::<ProxyBox>()
        };
        let indices: Vec<u32> = (0..INDICES).collect();
        let usage = vk::BufferUsageFlags::INDEX_BUFFER | vk::BufferUsageFlags::VERTEX_BUFFER;
        Ok(Self {
            target: Target::new(device, [640, 360], "boxes")?,
            pipeline: GraphicsPipeline::new(device, &info)?,
            boxes: device.upload("boxes", &boxes, vk::BufferUsageFlags::STORAGE_BUFFER)?,
            indices: device.upload("indices", &indices, usage)?,
        })
    }
}

impl ObjectRenderer for Boxes {
    fn target(&mut self) -> &mut Target {
        &mut self.target
    }

    fn rendering(&self, _view: &CullView, rendering: Rendering) -> RenderTarget {
        self.target.render_target((rendering == Rendering::First).then_some([0.0; 4]))
    }

    fn bind(&self, commands: &Commands, view: &CullView, _bucket: BucketId) {
        let [x, y, z, w] = view.view_proj.to_cols_array_2d();
        commands.bind(&self.pipeline, &[self.boxes.whole()]);
        // The shader generates its vertices from the boxes, so any buffer serves as the vertex
        // buffer.
        commands.bind_geometry(self.indices.whole(), Some(self.indices.whole()));
        commands.push_constants(&self.pipeline, &[x, y, z, w, view.rays.eye().to_array()]);
    }
}
