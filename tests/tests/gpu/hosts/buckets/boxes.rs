//! The boxes of a host: their pipelines and images, and the commands that the host records.

use cull::{Aabb, CullView};
use gpu::{
    Access, Blend, Buffer, BufferSlice, Commands, DepthMode, Device, GraphicsPipeline,
    GraphicsPipelineInfo, IndirectDraw, MemoryBarrier, RenderTarget, StorageLayout, Target, vk,
};
use occlusion::{
    BucketDraw, BucketId, CulledScene, DrawBuckets, DrawList, FrameScope, ObjectRenderer, ProxyBox,
    Rendering, ShadedObjects, ShaderSet, TransparentList,
};

pub const SIZE: [u32; 2] = [96, 54];

/// Colours a box by its number and by its bucket, so that a draw under the wrong pipeline shows.
const COLOUR: &str = "#version 460
layout(location = 0) flat in uint number;
layout(location = 0) out vec4 colour;
layout(push_constant) uniform Constants { layout(offset = 80) uint bucket; };
void main() {
    uint mixed = (number + 1) * 2654435761u ^ (bucket + 1) * 2246822519u;
    colour = vec4(vec3((uvec3(mixed) >> uvec3(8, 16, 24)) & 255u) / 255.0, bucket < 1000 ? 1 : 0.5);
}
";

/// The first bucket of draws that blend.
pub const GLASS: u32 = 1000;

/// Vertices of a box as `box.glsl` generates them: three faces of two triangles.
const BOX_INDICES: u32 = 18;

/// A draw: boxes that are its instances.
#[derive(Clone, Debug)]
pub struct Part {
    pub bucket: u32,
    pub boxes: Vec<Aabb>,
}

/// The time of the colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// With the depth.
    AtOnce,
    /// Behind the depth of all boxes.
    Later,
}

/// The owner of the boxes.
pub struct Boxes {
    pub target: Target,
    pipeline: GraphicsPipeline,
    /// The pipelines of depth alone, and of colour where the depth is the same.
    depth_first: Option<[GraphicsPipeline; 2]>,
    glass: GraphicsPipeline,
    /// The boxes of the frame.
    pub boxes: Option<BufferSlice>,
    indices: Buffer,
}

impl Boxes {
    /// Compiles the pipelines.
    pub fn new(device: &Device, shaders: &ShaderSet, shading: Shading) -> Self {
        let name = format!("antumbra-buckets-{}.frag", std::process::id());
        let file = std::env::temp_dir().join(name);
        std::fs::write(&file, COLOUR).unwrap();
        let fragment = gpu::compile(&file).unwrap();
        std::fs::remove_file(file).unwrap();
        let vertex = shaders.find("proxy.vert").unwrap();
        let info = GraphicsPipelineInfo {
            fragment: Some(&fragment),
            storage: StorageLayout { buffers: 1, push_bytes: 84, ..Default::default() },
            depth: DepthMode::TestAndWrite,
            blend: Blend::Opaque,
            ..GraphicsPipelineInfo::of("host boxes", vertex).numbered::<ProxyBox>()
        };
        let blended =
            GraphicsPipelineInfo { depth: DepthMode::TestOnly, blend: Blend::Alpha, ..info };
        let depth = GraphicsPipelineInfo { fragment: None, blend: Blend::NoColour, ..info };
        let colour = GraphicsPipelineInfo { depth: DepthMode::Equal, ..info };
        let depth_first = [depth, colour].map(|info| GraphicsPipeline::new(device, &info).unwrap());
        let indices: Vec<u32> = (0..BOX_INDICES).collect();
        let usage = vk::BufferUsageFlags::INDEX_BUFFER | vk::BufferUsageFlags::VERTEX_BUFFER;
        Self {
            target: Target::new(device, SIZE, "host boxes").unwrap(),
            pipeline: GraphicsPipeline::new(device, &info).unwrap(),
            depth_first: (shading == Shading::Later).then_some(depth_first),
            glass: GraphicsPipeline::new(device, &blended).unwrap(),
            boxes: None,
            indices: device.upload("box indices", &indices, usage).unwrap(),
        }
    }
}

impl ObjectRenderer for Boxes {
    fn target(&mut self) -> &mut Target {
        &mut self.target
    }

    fn rendering(&self, view: &CullView, rendering: Rendering) -> RenderTarget {
        let clear = (rendering == Rendering::First).then_some([0.0, 0.0, 0.0, 1.0]);
        self.target.render_target(clear).within(view.origin, view.size)
    }

    fn bind(&self, commands: &Commands, view: &CullView, bucket: BucketId) {
        let pipeline = match &self.depth_first {
            _ if bucket.0 >= GLASS => &self.glass,
            Some([depth, _]) => depth,
            None => &self.pipeline,
        };
        self.bind_pipeline(commands, view, bucket, pipeline);
    }
}

impl Boxes {
    fn bind_pipeline(
        &self,
        commands: &Commands,
        view: &CullView,
        bucket: BucketId,
        pipeline: &GraphicsPipeline,
    ) {
        let Some(boxes) = self.boxes else { return };
        commands.bind(pipeline, &[boxes]);
        // The shader generates its vertices, so any vertex buffer will do.
        commands.bind_geometry(self.indices.whole(), Some(self.indices.whole()));
        let mut constants = [0.0; 21];
        constants[..16].copy_from_slice(&view.view_proj.to_cols_array());
        constants[16..20].copy_from_slice(&view.rays.eye().to_array());
        constants[20] = f32::from_bits(bucket.0);
        commands.push_constants(pipeline, &constants);
    }
}

impl ShadedObjects for Boxes {
    fn shades_later(&self) -> bool {
        self.depth_first.is_some()
    }

    fn shade(
        &mut self,
        _scene: &CulledScene,
        commands: &Commands,
        view: &CullView,
        draw: DrawBuckets<'_>,
    ) {
        self.target.prepare(commands);
        let Some([_, colour]) = &self.depth_first else { return };
        commands.pass("host colours", |commands| {
            commands.rendering(self.colour_rendering(view), |commands| {
                draw(commands, &|commands, bucket| {
                    self.bind_pipeline(commands, view, bucket, colour);
                });
            });
        });
    }
}

/// Returns the box around all parts.
pub fn around(parts: &[Part]) -> Aabb {
    parts.iter().flat_map(|part| &part.boxes).fold(Aabb::EMPTY, |all, bounds| all.union(bounds))
}

/// Returns the draws of parts whose boxes begin with an instance.
pub fn draws_of(first: u32, parts: &[Part]) -> Vec<BucketDraw> {
    let mut next = first;
    let draw = |part: &Part| {
        let count = part.boxes.len() as u32;
        let draw = IndirectDraw {
            index_count: BOX_INDICES,
            instance_count: count,
            first_instance: next,
            ..Default::default()
        };
        next += count;
        BucketDraw { bucket: BucketId(part.bucket), draw, triangles: count * BOX_INDICES / 3 }
    };
    parts.iter().map(draw).collect()
}

/// Writes the boxes of parts, from an instance on.
pub fn write_boxes(boxes: &mut [ProxyBox], first: u32, parts: &[Part]) {
    let places = boxes.iter_mut().skip(first as usize);
    let new = parts.iter().flat_map(|part| &part.boxes);
    places.zip(new).for_each(|(place, bounds)| *place = ProxyBox::from(*bounds));
}

/// Draws the lists, as a host does between commands of the engine, and copies their counts.
pub fn draw_lists(
    commands: &Commands,
    boxes: &mut Boxes,
    lists: &[DrawList],
    view: &CullView,
    counts: Option<&Buffer>,
) {
    let rendering = if counts.is_some() { Rendering::Next } else { Rendering::First };
    boxes.target.prepare(commands);
    commands.rendering(boxes.rendering(view, rendering), |commands| {
        for list in lists {
            assert!(list.most > 0 && list.commands.size_bytes == u64::from(list.most) * 20);
            boxes.bind(commands, view, list.bucket);
            match list.count {
                Some(count) => commands.draw_indirect_count(list.commands, count),
                None => commands.draw_indirect(list.commands),
            }
        }
    });
    let Some(counts) = counts else { return };
    commands.fill(counts.whole(), 0);
    let copied = [Access::CopyWrite];
    let read = [Access::HostRead, Access::CopyWrite];
    commands.barrier(MemoryBarrier::between(&copied, &read));
    commands.barrier(MemoryBarrier::between(&[Access::ComputeWrite], &[Access::CopyRead]));
    for (number, count) in lists.iter().filter_map(|list| list.count).enumerate() {
        commands.copy_buffer(count, counts.whole().part(number as u64 * 4, 4));
    }
    commands.barrier(MemoryBarrier::between(&copied, &read));
}

/// Draws objects, bucket by bucket, without a table.
pub fn draw_all<'a>(
    commands: &Commands,
    boxes: &mut Boxes,
    parts: impl Iterator<Item = &'a (u32, Vec<Part>)>,
    view: &CullView,
) {
    let mut draws: Vec<BucketDraw> =
        parts.flat_map(|(first, parts)| draws_of(*first, parts)).collect();
    draws.sort_by_key(|draw| draw.bucket);
    boxes.target.prepare(commands);
    commands.rendering(boxes.rendering(view, Rendering::First), |commands| {
        for draws in draws.chunk_by(|a, b| a.bucket == b.bucket) {
            boxes.bind(commands, view, draws[0].bucket);
            draws.iter().for_each(|draw| commands.draw_indexed(&draw.draw));
        }
    });
}

/// Draws transparent objects over a finished image.
pub fn draw_glass(
    scope: &FrameScope<'_, '_>,
    boxes: &mut Boxes,
    list: &TransparentList,
    view: &CullView,
) {
    let commands = scope.commands();
    list.prepare(commands);
    boxes.target.prepare(commands);
    commands.rendering(boxes.rendering(view, Rendering::Next), |commands| {
        list.test(scope.scene().passes(), commands, view);
    });
    list.decide(commands);
    boxes.target.prepare(commands);
    commands.rendering(boxes.rendering(view, Rendering::Next), |commands| {
        list.draw(scope.scene().leaves().predicates(), commands, &|commands, bucket| {
            boxes.bind(commands, view, bucket);
        });
    });
}
