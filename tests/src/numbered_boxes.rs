//! Boxes drawn by a pipeline outside the renderer, each in its own colour.

use cull::{Aabb, CullView, Hierarchy};
use gpu::{
    Attachments, Blend, Buffer, BufferSlice, Commands, DepthMode, Device, GraphicsPipeline,
    GraphicsPipelineInfo, IndirectDraw, PredicationMode, RenderTarget, StorageLayout, Target, vk,
};
use occlusion::{
    BucketId, CulledScene, LeafTable, LeafTableInfo, MeshDraw, MeshDrawId, ObjectRenderer,
    OcclusionPasses, ProxyBox, Rendering, ShadedObjects, ShaderSet,
};

/// The indices of a box as `box.glsl` generates it: three faces of two triangles.
pub const BOX_INDICES: u32 = 18;

/// Colours a box by its number, so that no two look the same.
const NUMBER: &str = "#version 460
layout(location = 0) flat in uint number;
layout(location = 0) out vec4 colour;
void main() {
    uvec3 bytes = (uvec3(number + 1) * 2654435761u >> uvec3(8, 16, 24)) & 255u;
    colour = vec4(vec3(bytes) / 255.0, 1.0);
}
";

/// Returns a scene of boxes, each a leaf with one draw, for two frames in flight.
///
/// # Errors
/// A call that failed.
pub fn scene_of_boxes(
    device: &Device,
    boxes: &[Aabb],
    attachments: Attachments,
    predication: Option<PredicationMode>,
) -> Result<CulledScene, occlusion::Error> {
    let shaders = ShaderSet::embedded()?;
    let passes = OcclusionPasses::new(device, &shaders, attachments)?;
    let draw = IndirectDraw { index_count: BOX_INDICES, instance_count: 1, ..Default::default() };
    let info = LeafTableInfo {
        mesh_draws: [MeshDraw { draw, triangles: BOX_INDICES / 3 }].into(),
        predication,
        frames_in_flight: 2,
    };
    let hierarchy = Hierarchy::build(boxes).unwrap();
    CulledScene::of_meshes(device, passes, hierarchy, info, |_| MeshDrawId(0))
}

/// The owner of the boxes, with the target that it draws them to.
pub struct TargetBoxes {
    /// The target.
    pub target: Target,
    /// The boxes.
    pub boxes: NumberedBoxes,
}

impl ObjectRenderer for TargetBoxes {
    fn target(&mut self) -> &mut Target {
        &mut self.target
    }

    fn rendering(&self, _view: &CullView, rendering: Rendering) -> RenderTarget {
        let clear = (rendering == Rendering::First).then_some([0.0, 0.0, 0.0, 1.0]);
        self.target.render_target(clear)
    }

    fn bind(&self, commands: &Commands, view: &CullView, _bucket: BucketId) {
        self.boxes.bind(commands, view);
    }
}

impl ShadedObjects for TargetBoxes {}

/// A pipeline that draws the box of a leaf, and its buffers.
pub struct NumberedBoxes {
    pipeline: GraphicsPipeline,
    boxes: BufferSlice,
    indices: Buffer,
    /// The constants of the views, if several are drawn at once.
    eyes: Option<Buffer>,
}

impl NumberedBoxes {
    /// Compiles the pipeline for renderings to `attachments`.
    ///
    /// # Errors
    /// A call that failed.
    pub fn new(
        device: &Device,
        leaves: &LeafTable,
        attachments: Attachments,
    ) -> Result<Self, gpu::Error> {
        let indices: Vec<u32> = (0..BOX_INDICES).collect();
        let usage = vk::BufferUsageFlags::INDEX_BUFFER | vk::BufferUsageFlags::VERTEX_BUFFER;
        Ok(Self {
            pipeline: pipeline(device, attachments)?,
            boxes: leaves.boxes(),
            indices: device.upload("box indices", &indices, usage)?,
            eyes: None,
        })
    }

    /// Compiles the pipeline again, for other attachments.
    pub fn take_attachments(&mut self, device: &Device, attachments: Attachments) {
        self.pipeline = pipeline(device, attachments).expect("a pipeline");
    }

    /// Reads the boxes of other instances from now on.
    pub fn set_boxes(&mut self, boxes: BufferSlice) {
        self.boxes = boxes;
    }

    /// Sets the views that are drawn at once from the next frame on: as many as the pipeline has.
    pub fn take_views(&mut self, device: &Device, views: &[CullView]) {
        // As in `eye.glsl`; the shader reads only this.
        let eye = |view: &CullView| {
            let mut eye = [0.0_f32; 28];
            eye[..16].copy_from_slice(&view.view_proj.to_cols_array());
            eye[16..20].copy_from_slice(&view.rays.eye().to_array());
            eye
        };
        let eyes: Vec<_> = views.iter().map(eye).collect();
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        self.eyes = Some(device.upload("eyes", &eyes, usage).unwrap());
    }

    /// Binds everything; draws of leaves follow.
    pub fn bind(&self, commands: &Commands, view: &CullView) {
        match &self.eyes {
            Some(eyes) => commands.bind(&self.pipeline, &[self.boxes, self.boxes, eyes.whole()]),
            None => commands.bind(&self.pipeline, &[self.boxes]),
        }
        // The shader generates its vertices, so any vertex buffer will do.
        commands.bind_geometry(self.indices.whole(), Some(self.indices.whole()));
        if self.eyes.is_some() {
            return;
        }
        let mut constants = [0.0; 20];
        constants[..16].copy_from_slice(&view.view_proj.to_cols_array());
        constants[16..].copy_from_slice(&view.rays.eye().to_array());
        commands.push_constants(&self.pipeline, &constants);
    }
}

fn pipeline(device: &Device, attachments: Attachments) -> Result<GraphicsPipeline, gpu::Error> {
    let name = format!("antumbra-numbered-boxes-{}.frag", std::process::id());
    let file = std::env::temp_dir().join(name);
    std::fs::write(&file, NUMBER).unwrap();
    let fragment = gpu::compile(&file).unwrap();
    std::fs::remove_file(file).unwrap();
    let shaders = ShaderSet::embedded().unwrap();
    let (vertex, buffers, push_bytes) = match attachments.views {
        1 => ("proxy.vert", 1, 80),
        _ => ("proxy_multiview.vert", 3, 0),
    };
    let vertex = shaders.find(vertex).unwrap();
    let storage = StorageLayout { buffers, push_bytes, ..Default::default() };
    let info = GraphicsPipelineInfo {
        fragment: Some(&fragment),
        storage,
        depth: DepthMode::TestAndWrite,
        blend: Blend::Opaque,
        attachments,
        ..GraphicsPipelineInfo::of("numbered boxes", vertex).numbered::<ProxyBox>()
    };
    GraphicsPipeline::new(device, &info)
}
