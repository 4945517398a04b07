//! A host with its own pipeline state per bucket, next to a plain renderer of all draws.

use std::collections::BTreeMap;

use cull::{Aabb, Camera, CullView, DrawPhases, LeafIndex, ObjectId, Strategy};
use glam::Vec3;
use gpu::{Buffer, Device, FrameRing, MemoryKind, PredicationMode, Readback, vk};
use occlusion::{
    BucketDraw, CulledScene, CulledSceneOptions, DrawRequest, DriverQuirks, Error, HostObject,
    LeafCount, OcclusionState, ProxyBox, ShaderSet, TransparentList,
};

use super::boxes::{
    Boxes, GLASS, Part, SIZE, Shading, around, draw_all, draw_glass, draw_lists, draws_of,
    write_boxes,
};

/// The number of boxes that fit into the host's buffer.
const BOXES: usize = 1 << 12;

/// The way to record draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recorder {
    /// The engine records the draws, and calls the host back.
    Engine,
    /// The engine records the draws, depth first.
    EngineDepthFirst,
    /// The host records the draws from lists.
    Host,
    /// The host reads the visible objects from the plan, and draws revealed objects some frames
    /// later: the image is not exact.
    HostLate,
}

/// Everything that a host needs to draw its objects with our culling, and to draw all of them.
pub struct Host {
    device: Device,
    frames: FrameRing,
    scene: CulledScene,
    state: OcclusionState,
    culled: Boxes,
    all: Boxes,
    /// The boxes of all draws, by the number of the instance.
    boxes: Vec<ProxyBox>,
    next_box: usize,
    parts: BTreeMap<ObjectId, (u32, Vec<Part>)>,
    pub wall: ObjectId,
    /// Transparent objects, each with the index of its first box.
    glass: Vec<(u32, Vec<Part>)>,
    list: TransparentList,
    bucket_count: u32,
    recorder: Recorder,
    /// The numbers of revealed draws in the lists of each frame, if the device counts them.
    listed: Vec<Buffer>,
    /// The images of each frame: with our culling, and of all draws.
    pub images: Vec<[Readback; 2]>,
}

impl Host {
    /// Creates a host without objects, with little room.
    pub fn new(
        device: &Device,
        bucket_count: u32,
        predication: PredicationMode,
        recorder: Recorder,
    ) -> Self {
        Self::with_quirks(device, bucket_count, predication, recorder, DriverQuirks::default())
    }

    /// Creates a host as [`Self::new`] does, on a driver with these quirks.
    pub fn with_quirks(
        device: &Device,
        bucket_count: u32,
        predication: PredicationMode,
        recorder: Recorder,
        quirks: DriverQuirks,
    ) -> Self {
        let shaders = ShaderSet::embedded().unwrap();
        let shading = match recorder {
            Recorder::EngineDepthFirst => Shading::Later,
            _ => Shading::AtOnce,
        };
        let [culled, all] =
            [shading, Shading::AtOnce].map(|shading| Boxes::new(device, &shaders, shading));
        let attachments = culled.target.attachments();
        let draw_phases = match recorder {
            Recorder::Engine | Recorder::EngineDepthFirst => DrawPhases::PerRound,
            Recorder::Host | Recorder::HostLate => DrawPhases::Two,
        };
        let options = CulledSceneOptions {
            object_capacity: 20,
            draw_capacity: 16,
            bucket_count,
            predication: Some(predication),
            draw_phases,
            quirks,
            ..Default::default()
        };
        let scene = CulledScene::new(device, attachments, &options).unwrap();
        Self {
            state: scene.new_view(&culled.target).unwrap(),
            device: device.clone(),
            frames: FrameRing::new(device, 2).unwrap(),
            scene,
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

    /// Adds several objects at once.
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

    /// Draws a frame with our culling, and all draws to another image, without a wait in between.
    pub fn draw(&mut self, strategy: Strategy, camera: &Camera) {
        let view =
            CullView::new(camera, SIZE, self.device.adapter().limits.sub_pixel_precision_bits);
        let mut frame = self.frames.begin().unwrap();
        let boxes = frame.uploads().push(&self.boxes).unwrap();
        self.culled.boxes = Some(boxes);
        self.all.boxes = Some(boxes);
        let mut scope = self.scene.begin(frame).unwrap();
        let request = DrawRequest { strategy, ..DrawRequest::from(&view) };
        let planned = scope.plan(&mut self.state, request).unwrap();
        match self.recorder {
            Recorder::Engine => scope.record(planned, &mut self.culled).unwrap(),
            Recorder::EngineDepthFirst => scope.record_shaded(planned, &mut self.culled).unwrap(),
            Recorder::Host => {
                let listed = scope.list(planned).unwrap();
                let revealed = listed.revealed().to_vec();
                draw_lists(scope.commands(), &mut self.culled, listed.visible(), &view, None);
                listed.record(&mut scope, &mut self.culled.target).unwrap();
                let bytes = u64::from(self.bucket_count) * 4;
                let usage = vk::BufferUsageFlags::TRANSFER_DST;
                let name = "listed draws read back";
                let counts =
                    Buffer::new(&self.device, name, bytes, usage, MemoryKind::ReadBack).unwrap();
                draw_lists(scope.commands(), &mut self.culled, &revealed, &view, Some(&counts));
                self.listed.push(counts);
            }
            Recorder::HostLate => {
                let objects = scope.scene().hierarchy().leaf_objects();
                let visible = planned.state().plan().draws.iter();
                let visible = visible.map(|leaf: &LeafIndex| objects[leaf.0 as usize]);
                let parts: Vec<_> = visible.filter_map(|object| self.parts.get(&object)).collect();
                let listed = scope.list(planned).unwrap();
                draw_all(scope.commands(), &mut self.culled, parts.into_iter(), &view);
                listed.record(&mut scope, &mut self.culled.target).unwrap();
            }
        }
        draw_all(scope.commands(), &mut self.all, self.parts.values(), &view);
        let middle =
            |(_, parts): &(u32, Vec<Part>)| around(parts).centre().distance(view.rays.origin);
        self.glass.sort_by(|a, b| middle(b).total_cmp(&middle(a)));
        for (boxes, is_tested) in [(&mut self.culled, true), (&mut self.all, false)] {
            self.list.clear();
            for (first, parts) in &self.glass {
                let bounds = is_tested.then(|| around(parts));
                self.list.push(&view, bounds, &draws_of(*first, parts));
            }
            scope.upload_transparent(&mut self.list).unwrap();
            draw_glass(&scope, boxes, &self.list, &view);
        }
        let images = [&mut self.culled, &mut self.all].map(|boxes| {
            let image = Readback::new(&self.device, SIZE).unwrap();
            boxes.target.copy_to(scope.commands(), &image);
            image
        });
        self.images.push(images);
        scope.submit(None).unwrap();
    }

    /// Draws a frame of a view of `state` and gives the frame up. The view's size differs from the
    /// target if it is large. Returns the error.
    pub fn refused(&mut self, view: &CullView, state: &mut OcclusionState) -> Error {
        let mut scope = self.scene.begin(self.frames.begin().unwrap()).unwrap();
        scope.draw(state, view, &mut self.culled).unwrap_err()
    }

    /// Creates another view of the scene.
    pub fn new_view(&self) -> OcclusionState {
        self.scene.new_view(&self.culled.target).unwrap()
    }

    /// Uploads the changes of the scene in a frame of their own.
    pub fn upload(&mut self) -> Result<(), Error> {
        self.scene.begin(self.frames.begin().unwrap())?.submit(None).map(drop)
    }

    /// Returns the number of revealed draws in the lists of all frames, which are over.
    pub fn listed(&self) -> u64 {
        let counts =
            self.listed.iter().flat_map(|listed| listed.read(0..self.bucket_count as usize));
        counts.map(|count: &u32| u64::from(*count)).sum()
    }

    /// Returns the smallest number of draws in a frame, and the number of draws of the scene.
    pub fn fewest_and_all(&mut self) -> (u64, u64) {
        self.state.collect(self.device.completed().unwrap(), &self.scene);
        let hierarchy = self.scene.hierarchy();
        let leaves = (0..hierarchy.leaf_objects().len() as u32).map(cull::LeafIndex);
        let count = |first| self.scene.leaves().count(cull::LeafRange { first, count: 1 });
        let there: u64 = leaves.map(count).map(|count: LeafCount| count.draws).sum();
        let all: usize = self.parts.values().map(|(_, parts)| parts.len()).sum();
        assert_eq!(there, all as u64);
        (self.state.drain_stats().map(|outcome| outcome.draws).min().unwrap(), there)
    }
}
