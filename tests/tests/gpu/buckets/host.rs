//! A host with its own pipeline state per bucket, and a plain renderer of all draws beside it.

use std::collections::BTreeMap;

use cull::{Aabb, Camera, CullConfig, Culler, DrawPhases, ObjectId, Strategy, TesterSupport, View};
use glam::Vec3;
use gpu::{
    Access, Blend, Buffer, BufferSlice, Commands, DepthMode, Device, Frame, FrameRing,
    GraphicsPipeline, GraphicsPipelineInfo, IndirectDraw, MemoryBarrier, MemoryKind, Predicates,
    Predication, Readback, RenderTarget, StorageLayout, Target, vk,
};
use occlusion::{
    BucketDraw, BucketId, BucketTableInfo, DrawList, HostObject, HostScene, LeafCount, ObjectPass,
    ObjectRenderer, OcclusionPasses, ProxyBox, Rendering, ShaderSet, TransparentList,
    VisibilityState, execute, list_draws,
};

const SIZE: [u32; 2] = [96, 54];

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
const GLASS: u32 = 1000;
/// Vertices of a box as `box.glsl` makes them up: three faces of two triangles.
const BOX_INDICES: u32 = 18;
/// The boxes that the host has room for in its own buffer.
const BOXES: usize = 1 << 12;

/// A draw: boxes that are its instances.
#[derive(Clone, Debug)]
pub struct Part {
    pub bucket: u32,
    pub boxes: Vec<Aabb>,
}

/// The way that draws are recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recorder {
    /// By the engine, which calls the host back.
    Engine,
    /// By the host, from lists.
    Host,
}

/// The owner of the boxes.
struct Boxes {
    target: Target,
    pipeline: GraphicsPipeline,
    glass: GraphicsPipeline,
    /// The boxes of the frame.
    boxes: Option<BufferSlice>,
    indices: Buffer,
}

impl Boxes {
    fn new(device: &Device, shaders: &ShaderSet) -> Self {
        let name = format!("antumbra-buckets-{}.frag", std::process::id());
        let file = std::env::temp_dir().join(name);
        std::fs::write(&file, COLOUR).unwrap();
        let fragment = gpu::compile(&file).unwrap();
        std::fs::remove_file(file).unwrap();
        let info = GraphicsPipelineInfo {
            fragment: Some(&fragment),
            storage: StorageLayout { buffers: 1, push_bytes: 84, ..Default::default() },
            depth: DepthMode::TestAndWrite,
            blend: Blend::Opaque,
            ..GraphicsPipelineInfo::of("host boxes", shaders.find("proxy.vert").unwrap())
        };
        let blended =
            GraphicsPipelineInfo { depth: DepthMode::TestOnly, blend: Blend::Alpha, ..info };
        let indices: Vec<u32> = (0..BOX_INDICES).collect();
        let usage = vk::BufferUsageFlags::INDEX_BUFFER | vk::BufferUsageFlags::VERTEX_BUFFER;
        Self {
            target: Target::new(device, SIZE, "host boxes").unwrap(),
            pipeline: GraphicsPipeline::new(device, &info).unwrap(),
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

    fn rendering(&self, view: &View, rendering: Rendering) -> RenderTarget {
        let clear = (rendering == Rendering::First).then_some([0.0, 0.0, 0.0, 1.0]);
        self.target.render_target(clear).within(view.origin, view.size)
    }

    fn bind(&self, commands: &Commands, view: &View, bucket: BucketId, _pass: ObjectPass) {
        let Some(boxes) = self.boxes else { return };
        let pipeline = if bucket.0 < GLASS { &self.pipeline } else { &self.glass };
        commands.bind(pipeline, &[boxes]);
        // The shader makes up its vertices: any vertex buffer does.
        commands.bind_geometry(self.indices.whole(), Some(self.indices.whole()));
        let mut constants = [0.0; 21];
        constants[..16].copy_from_slice(&view.view_proj.to_cols_array());
        constants[16..20].copy_from_slice(&view.rays.eye().to_array());
        constants[20] = f32::from_bits(bucket.0);
        commands.push_constants(pipeline, &constants);
    }
}

/// Everything that a host keeps to draw its objects by our answers, and to draw all of them.
pub struct Host {
    device: Device,
    frames: FrameRing,
    scene: HostScene,
    shaders: ShaderSet,
    state: VisibilityState,
    culled: Boxes,
    all: Boxes,
    /// The boxes of all draws, by the number of the instance.
    boxes: Vec<ProxyBox>,
    next_box: usize,
    parts: BTreeMap<ObjectId, (u32, Vec<Part>)>,
    pub wall: ObjectId,
    /// Transparent objects, and the first of the boxes of each.
    glass: Vec<(u32, Vec<Part>)>,
    list: TransparentList,
    bucket_count: u32,
    recorder: Recorder,
    /// The numbers of revealed draws in the lists of each frame, where the device counts them.
    listed: Vec<Buffer>,
    /// The images of each frame: by our answers, and of all draws.
    pub images: Vec<[Readback; 2]>,
}

impl Host {
    /// Creates a host without objects, with little room.
    pub fn new(
        device: &Device,
        bucket_count: u32,
        predication: Predication,
        recorder: Recorder,
    ) -> Self {
        let shaders = ShaderSet::embedded().unwrap();
        let [mut culled, all] = [(); 2].map(|()| Boxes::new(device, &shaders));
        let passes = OcclusionPasses::new(device, &shaders, culled.target.attachments()).unwrap();
        let info = BucketTableInfo {
            bucket_count,
            draw_capacity: 16,
            predication: Some(predication),
            frames_in_flight: 2,
        };
        let scene = HostScene::new(device, passes, 20, info).unwrap();
        let draw_phases = match recorder {
            Recorder::Engine => DrawPhases::PerRound,
            Recorder::Host => DrawPhases::Two,
        };
        let testers = scene.executor().testers(device, culled.target());
        let testers = TesterSupport { draw_phases, ..testers };
        let culler = Culler::with_testers(CullConfig::default(), testers);
        let leaves = &scene.executor().leaves;
        Self {
            state: VisibilityState::new(device, scene.hierarchy(), leaves, 2, culler).unwrap(),
            device: device.clone(),
            frames: FrameRing::new(device, 2).unwrap(),
            scene,
            shaders,
            culled,
            all,
            boxes: vec![ProxyBox::from(Aabb::EMPTY); BOXES],
            next_box: 0,
            parts: BTreeMap::new(),
            wall: ObjectId(0),
            glass: Vec::new(),
            list: TransparentList::new(device).unwrap(),
            bucket_count,
            recorder,
            listed: Vec::new(),
            images: Vec::new(),
        }
    }

    pub fn objects(&self) -> impl Iterator<Item = ObjectId> {
        self.parts.keys().copied()
    }

    /// Adds objects in bulk.
    pub fn add(&mut self, things: Vec<Vec<Part>>) -> Vec<ObjectId> {
        let firsts: Vec<u32> = things.iter().map(|parts| self.take_boxes(parts)).collect();
        let draws: Vec<Vec<BucketDraw>> =
            firsts.iter().zip(&things).map(|(first, parts)| draws_of(*first, parts)).collect();
        let objects = things.iter().zip(&draws);
        let objects: Vec<HostObject<'_>> =
            objects.map(|(parts, draws)| HostObject { bounds: around(parts), draws }).collect();
        let mut added = Vec::new();
        self.scene.add(&objects, &mut added).unwrap();
        self.parts.extend(added.iter().copied().zip(firsts.into_iter().zip(things)));
        added
    }

    /// Adds transparent objects, which hide nothing.
    pub fn add_glass(&mut self, things: Vec<Vec<Part>>) {
        for mut parts in things {
            parts.iter_mut().for_each(|part| part.bucket += GLASS);
            let first = self.take_boxes(&parts);
            self.glass.push((first, parts));
        }
    }

    pub fn remove(&mut self, objects: &[ObjectId]) {
        self.scene.remove(objects).unwrap();
        objects.iter().for_each(|object| drop(self.parts.remove(object)));
    }

    /// Moves objects, whose draws stay the same.
    pub fn move_by(&mut self, objects: &[ObjectId], by: Vec3) {
        let mut moved = Vec::new();
        for object in objects {
            let (first, parts) = self.parts.get_mut(object).unwrap();
            for bounds in parts.iter_mut().flat_map(|part| &mut part.boxes) {
                *bounds = Aabb::new(bounds.min + by, bounds.max + by);
            }
            moved.push((*object, around(parts)));
            write_boxes(&mut self.boxes, *first, parts);
        }
        self.scene.move_to(&moved).unwrap();
    }

    /// Gives an object other draws at another place.
    pub fn replace(&mut self, object: ObjectId, parts: Vec<Part>) {
        let first = self.take_boxes(&parts);
        self.scene.move_to(&[(object, around(&parts))]).unwrap();
        self.scene.set_draws(object, &draws_of(first, &parts)).unwrap();
        self.parts.insert(object, (first, parts));
    }

    /// Takes instances for all boxes of some parts.
    fn take_boxes(&mut self, parts: &[Part]) -> u32 {
        let first = self.next_box;
        self.next_box += parts.iter().map(|part| part.boxes.len()).sum::<usize>();
        write_boxes(&mut self.boxes, first as u32, parts);
        first as u32
    }

    /// Draws a frame by our answers, and all draws to another image. Nothing waits in between.
    pub fn draw(&mut self, strategy: Strategy, camera: &Camera) {
        let view = View::new(camera, SIZE, self.device.adapter().limits.sub_pixel_precision_bits);
        let mut frame = self.frames.begin().unwrap();
        let boxes = frame.uploads().push(&self.boxes).unwrap();
        (self.culled.boxes, self.all.boxes) = (Some(boxes), Some(boxes));
        self.scene.upload(&mut frame).unwrap();
        let (hierarchy, executor) = self.scene.parts_mut();
        let state = &mut self.state;
        state.collect(self.device.completed().unwrap(), hierarchy, &executor.leaves);
        state.plan_frame(hierarchy, &executor.leaves, strategy, (&view, 4096));
        match self.recorder {
            Recorder::Engine => {
                let io = (&self.shaders, &view);
                execute(&mut frame, executor, state, &mut self.culled, io).unwrap();
            }
            Recorder::Host => {
                let tests = list_draws(&mut frame, executor, state, &view).unwrap();
                draw_lists(&mut frame, &mut self.culled, state.visible_lists(), &view, None);
                let io = (&mut self.culled.target, &self.shaders);
                tests.record(&mut frame, executor, state, io).unwrap();
                let bytes = u64::from(self.bucket_count) * 4;
                let usage = vk::BufferUsageFlags::TRANSFER_DST;
                let name = "listed draws read back";
                let listed =
                    Buffer::new(&self.device, name, bytes, usage, MemoryKind::ReadBack).unwrap();
                let lists = state.revealed_lists();
                draw_lists(&mut frame, &mut self.culled, lists, &view, Some(&listed));
                self.listed.push(listed);
            }
        }
        draw_all(&mut frame, &mut self.all, &self.parts, &view);
        let middle =
            |(_, parts): &(u32, Vec<Part>)| around(parts).centre().distance(view.rays.origin);
        self.glass.sort_by(|a, b| middle(b).total_cmp(&middle(a)));
        let passes = &executor.passes;
        let predicates = executor.leaves.predicates();
        for (boxes, is_tested) in [(&mut self.culled, true), (&mut self.all, false)] {
            self.list.clear();
            for (first, parts) in &self.glass {
                let bounds = is_tested.then(|| around(parts));
                self.list.push(&view, bounds, &draws_of(*first, parts));
            }
            self.list.write(&mut frame).unwrap();
            draw_glass(&frame, boxes, (&self.list, passes, predicates), &view);
        }
        let images = [&mut self.culled, &mut self.all].map(|boxes| {
            let image = Readback::new(&self.device, SIZE).unwrap();
            boxes.target.copy_to(frame.commands(), &image);
            image
        });
        self.images.push(images);
        let tick = frame.submit(None).unwrap();
        state.submitted(tick, &executor.leaves, None);
        self.scene.submitted(tick);
    }

    /// Returns the number of revealed draws in the lists of all frames, which are over.
    pub fn listed(&self) -> u64 {
        let counts = self.listed.iter().flat_map(|it| it.read(0..self.bucket_count as usize));
        counts.map(|count: &u32| u64::from(*count)).sum()
    }

    /// Returns the fewest draws of a frame, and those of the scene.
    pub fn fewest_and_all(&mut self) -> (u64, u64) {
        let (hierarchy, executor) = self.scene.parts_mut();
        self.state.collect(self.device.completed().unwrap(), hierarchy, &executor.leaves);
        let leaves = (0..hierarchy.leaf_objects().len() as u32).map(cull::LeafIndex);
        let count = |first| executor.leaves.count(cull::LeafRange { first, count: 1 });
        let there: u64 = leaves.map(count).map(|count: LeafCount| count.draws).sum();
        let all: usize = self.parts.values().map(|(_, parts)| parts.len()).sum();
        assert_eq!(there, all as u64);
        (self.state.take_outcomes().map(|outcome| outcome.draws).min().unwrap(), there)
    }
}

/// Returns the box around all parts.
fn around(parts: &[Part]) -> Aabb {
    parts.iter().flat_map(|part| &part.boxes).fold(Aabb::EMPTY, |all, it| all.union(it))
}

/// Returns the draws of parts whose boxes begin with an instance.
fn draws_of(first: u32, parts: &[Part]) -> Vec<BucketDraw> {
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

fn write_boxes(boxes: &mut [ProxyBox], first: u32, parts: &[Part]) {
    let places = boxes.iter_mut().skip(first as usize);
    let new = parts.iter().flat_map(|part| &part.boxes);
    places.zip(new).for_each(|(place, bounds)| *place = ProxyBox::from(*bounds));
}

/// Draws what is listed, as a host does between commands of the engine, and copies the counts of
/// the lists.
fn draw_lists(
    frame: &mut Frame<'_>,
    boxes: &mut Boxes,
    lists: &[DrawList],
    view: &View,
    counts: Option<&Buffer>,
) {
    let commands = frame.commands();
    let rendering = if counts.is_some() { Rendering::Next } else { Rendering::First };
    boxes.target.prepare(commands);
    commands.rendering(boxes.rendering(view, rendering), |commands| {
        for list in lists {
            assert!(list.most > 0 && list.commands.size_bytes == u64::from(list.most) * 20);
            boxes.bind(commands, view, list.bucket, ObjectPass::Visibility);
            match list.count {
                Some(count) => commands.draw_indirect_count(list.commands, count),
                None => commands.draw_indirect(list.commands),
            }
        }
    });
    let Some(counts) = counts else { return };
    commands.fill(counts.whole(), 0);
    let (copied, read) = ([Access::CopyWrite], [Access::HostRead, Access::CopyWrite]);
    commands.barrier(MemoryBarrier::between(&copied, &read));
    commands.barrier(MemoryBarrier::between(&[Access::ComputeWrite], &[Access::CopyRead]));
    for (number, count) in lists.iter().filter_map(|list| list.count).enumerate() {
        commands.copy_buffer(count, counts.whole().part(number as u64 * 4, 4));
    }
    commands.barrier(MemoryBarrier::between(&copied, &read));
}

/// Draws all objects, bucket by bucket, without a table.
fn draw_all(
    frame: &mut Frame<'_>,
    boxes: &mut Boxes,
    parts: &BTreeMap<ObjectId, (u32, Vec<Part>)>,
    view: &View,
) {
    let mut draws: Vec<BucketDraw> =
        parts.values().flat_map(|(first, parts)| draws_of(*first, parts)).collect();
    draws.sort_by_key(|draw| draw.bucket);
    let commands = frame.commands();
    boxes.target.prepare(commands);
    commands.rendering(boxes.rendering(view, Rendering::First), |commands| {
        for draws in draws.chunk_by(|a, b| a.bucket == b.bucket) {
            boxes.bind(commands, view, draws[0].bucket, ObjectPass::Visibility);
            draws.iter().for_each(|draw| commands.draw_indexed(&draw.draw));
        }
    });
}

/// Draws transparent objects over a finished image.
fn draw_glass(
    frame: &Frame<'_>,
    boxes: &mut Boxes,
    (list, passes, predicates): (&TransparentList, &OcclusionPasses, &Predicates),
    view: &View,
) {
    let commands = frame.commands();
    list.prepare(commands);
    boxes.target.prepare(commands);
    commands.rendering(boxes.rendering(view, Rendering::Next), |commands| {
        list.test(passes, commands, (view, boxes.viewport(view)));
    });
    list.decide(commands);
    boxes.target.prepare(commands);
    commands.rendering(boxes.rendering(view, Rendering::Next), |commands| {
        list.draw(predicates, commands, &|commands, bucket| {
            boxes.bind(commands, view, bucket, ObjectPass::Visibility);
        });
    });
}
