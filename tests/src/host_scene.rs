//! The boxes of a host in a [`CulledScene`]. Frames of the host draw them with the engine's
//! culling, and again by brute force. The images must be the same.

use std::collections::BTreeMap;

use ash::vk;
use cull::{Aabb, Camera, CullView, DrawPhases, ObjectId, Strategy};
use glam::Vec3;
use gpu::{
    Attachments, Commands, Device, Frame, HostImage, HostImages, ImageState, IndirectDraw,
    NearDepth, PredicationMode, RenderTarget, SlotIndex, Target, Tick, Viewport,
};
use occlusion::{
    BucketDraw, BucketId, CulledScene, CulledSceneOptions, DeviceCosts, DrawList, DrawRequest,
    DriverAssumption, DriverQuirks, Error, HostObject, ObjectRenderer, OcclusionState, PerView,
    ProxyBox, Rendering,
};

use crate::host_commands::Runs;
use crate::host_device::Host;
use crate::host_images::{OwnBuffer, OwnImage};
use crate::host_passes::OwnPasses;
use crate::numbered_boxes::{BOX_INDICES, NumberedBoxes};
use crate::walk::pixels_that_differ;

/// The size of the images in pixels.
pub const SIZE: [u32; 2] = [96, 54];
/// The frames in flight.
pub const IN_FLIGHT: usize = 2;

/// The buckets that boxes are drawn in, in turn.
const BUCKETS: u32 = 3;
/// The box in place of removed boxes.
const NOWHERE: Aabb = Aabb { min: Vec3::splat(1.0e6), max: Vec3::splat(1.0e6) };

/// The choices of a host with boxes.
#[derive(Clone, Copy, Debug)]
pub struct BoxOptions<'a> {
    /// The number of views.
    pub views: usize,
    /// Samples per pixel.
    pub samples: vk::SampleCountFlags,
    /// The owner of the renderings.
    pub renderings: RenderingOwner,
    /// The number of objects that fit at first.
    pub room: usize,
    /// The way that hidden draws are skipped; `None` takes the device's best.
    pub predication: Option<PredicationMode>,
    /// Two phases if the host draws from lists.
    pub draw_phases: DrawPhases,
    /// The assumptions about the driver that count as broken.
    pub disabled: &'a [DriverAssumption],
    /// The costs that decide about tests, if there are any.
    pub costs: Option<&'a DeviceCosts>,
}

/// The owner of the renderings of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RenderingOwner {
    /// The engine, by dynamic rendering.
    Engine,
    /// The host, by render pass objects.
    Host,
}

impl Default for BoxOptions<'_> {
    fn default() -> Self {
        Self {
            views: 1,
            samples: vk::SampleCountFlags::TYPE_1,
            renderings: RenderingOwner::Engine,
            room: 16,
            predication: None,
            draw_phases: DrawPhases::PerRound,
            disabled: &[],
            costs: None,
        }
    }
}

/// A scene of boxes that is compared with brute force. Destroyed by [`ComparedScene::destroy`].
pub struct ComparedScene<'a> {
    host: &'a Host,
    device: Device,
    /// The scene.
    pub scene: CulledScene,
    draw_phases: DrawPhases,
    views: Vec<ComparedView>,
    /// The boxes by instance; removed boxes are `NOWHERE`.
    boxes: Vec<Aabb>,
    unused: Vec<u32>,
    instances: BTreeMap<ObjectId, u32>,
    /// The slots whose images are to be compared.
    is_drawn: [bool; IN_FLIGHT],
}

/// A view with the images of both ways to draw it.
struct ComparedView {
    state: OcclusionState,
    culled: BoxImages,
    all: BoxImages,
    /// The copies of both images by slot.
    copies: [[OwnBuffer; 2]; IN_FLIGHT],
}

/// Images of a host, and the boxes that are drawn to them.
struct BoxImages {
    target: Target,
    boxes: NumberedBoxes,
    colour: OwnImage,
    depth: OwnImage,
    resolved: Option<OwnImage>,
    passes: Option<OwnPasses>,
}

impl<'a> ComparedScene<'a> {
    /// Creates a scene without boxes.
    pub fn new(host: &'a Host, device: &Device, options: &BoxOptions<'_>) -> Self {
        let mut images = Vec::new();
        images.resize_with(options.views, || [(); 2].map(|()| images_of(host, device, options)));
        let target = &images[0][0].0;
        let passes = images[0][0].3.as_ref();
        let attachments = attachments_of(target, passes);
        let quirks = DriverQuirks::new(options.disabled);
        let scene_options = CulledSceneOptions {
            object_capacity: options.room,
            draw_capacity: options.room as u32,
            bucket_count: BUCKETS,
            frames_in_flight: IN_FLIGHT,
            predication: options.predication,
            draw_phases: options.draw_phases,
            quirks,
            costs: options.costs,
            ..Default::default()
        };
        let scene = CulledScene::new(device, attachments, &scene_options).unwrap();
        let view = |images: [_; 2]| {
            let [culled, all] = images.map(|image| BoxImages::new(device, &scene, image));
            let state = scene.new_view(&culled.target);
            let bytes = u64::from(SIZE[0] * SIZE[1] * 4);
            let copies = [(); IN_FLIGHT].map(|()| [(); 2].map(|()| OwnBuffer::new(host, bytes)));
            ComparedView { state: state.unwrap(), culled, all, copies }
        };
        let views = images.into_iter().map(view).collect();
        Self {
            host,
            device: device.clone(),
            scene,
            draw_phases: options.draw_phases,
            views,
            boxes: Vec::new(),
            unused: Vec::new(),
            instances: BTreeMap::new(),
            is_drawn: [false; IN_FLIGHT],
        }
    }

    /// Returns the objects, in the order of their ids.
    pub fn objects(&self) -> impl Iterator<Item = ObjectId> {
        self.instances.keys().copied()
    }

    /// Adds several boxes at once.
    ///
    /// # Errors
    /// The error of [`CulledScene::add`]. Brute force then draws none of these boxes.
    pub fn add(&mut self, boxes: &[Aabb]) -> Result<Vec<ObjectId>, Error> {
        let mut instance = || {
            self.unused.pop().unwrap_or_else(|| {
                self.boxes.push(NOWHERE);
                self.boxes.len() as u32 - 1
            })
        };
        let instances: Vec<u32> = boxes.iter().map(|_| instance()).collect();
        let draw = |instance: &u32| BucketDraw {
            bucket: BucketId(instance % BUCKETS),
            draw: IndirectDraw {
                index_count: BOX_INDICES,
                instance_count: 1,
                first_instance: *instance,
                ..Default::default()
            },
            triangles: BOX_INDICES / 3,
        };
        let draws: Vec<[BucketDraw; 1]> =
            instances.iter().map(|instance| [draw(instance)]).collect();
        let objects = boxes.iter().zip(&draws);
        let objects: Vec<HostObject<'_>> =
            objects.map(|(bounds, draws)| HostObject { bounds: *bounds, draws }).collect();
        let mut ids = Vec::new();
        if let Err(error) = self.scene.add(&objects, &mut ids) {
            self.unused.extend(instances);
            return Err(error);
        }
        for ((id, instance), bounds) in ids.iter().zip(instances).zip(boxes) {
            self.boxes[instance as usize] = *bounds;
            self.instances.insert(*id, instance);
        }
        Ok(ids)
    }

    /// Removes boxes.
    pub fn remove(&mut self, objects: &[ObjectId]) {
        self.scene.remove(objects).unwrap();
        for object in objects {
            let instance = self.instances.remove(object).unwrap();
            self.boxes[instance as usize] = NOWHERE;
            self.unused.push(instance);
        }
    }

    /// Moves boxes.
    pub fn move_by(&mut self, objects: &[ObjectId], by: Vec3) {
        let mut moved = Vec::new();
        for object in objects {
            let bounds = &mut self.boxes[self.instances[object] as usize];
            *bounds = Aabb::new(bounds.min + by, bounds.max + by);
            moved.push((*object, *bounds));
        }
        self.scene.move_to(&moved).unwrap();
    }

    /// Records the views into a frame, with one camera per view, and returns the frame.
    ///
    /// # Errors
    /// The errors of [`CulledScene::begin`] and of [`occlusion::FrameScope::record`].
    pub fn record<'ring>(
        &mut self,
        mut frame: Frame<'ring>,
        cameras: &[Camera],
        strategy: Strategy,
    ) -> Result<Frame<'ring>, Error> {
        let boxes = frame.uploads().push_iter(self.boxes.iter().copied().map(ProxyBox::from))?;
        let bits = self.device.adapter().limits.sub_pixel_precision_bits;
        let mut scope = self.scene.begin(frame)?;
        let mut listed = PerView::new();
        for (ComparedView { state, culled, all, .. }, camera) in self.views.iter_mut().zip(cameras)
        {
            let view = CullView::new(camera, SIZE, bits);
            culled.boxes.set_boxes(boxes);
            all.boxes.set_boxes(boxes);
            let request = DrawRequest { strategy, ..DrawRequest::from(&view) };
            let planned = scope.plan(state, request)?;
            match self.draw_phases {
                DrawPhases::PerRound => scope.record(planned, culled)?,
                DrawPhases::Two => listed.push((scope.list(planned)?, culled, view)),
            }
        }
        // All views are listed before the tests of the first are recorded, as by a host that first
        // draws the visible objects of all views.
        for (listed, culled, view) in listed {
            let revealed: PerView<DrawList> = listed.revealed().iter().copied().collect();
            culled.draw_lists(scope.commands(), listed.visible(), &view, Rendering::First);
            listed.record(&mut scope, &mut culled.target)?;
            culled.draw_lists(scope.commands(), &revealed, &view, Rendering::Next);
            culled.target.restore(scope.commands());
        }
        scope.into_frame()
    }

    /// Records the same views again, by brute force, and the copies of all images. The frame runs
    /// later, or never.
    pub fn record_all(&mut self, frame: &Frame<'_>, cameras: &[Camera]) {
        let commands = frame.commands();
        let SlotIndex(slot) = frame.slot();
        let bits = self.device.adapter().limits.sub_pixel_precision_bits;
        let every_box = IndirectDraw {
            index_count: BOX_INDICES,
            instance_count: self.boxes.len() as u32,
            ..Default::default()
        };
        for (ComparedView { culled, all, copies, .. }, camera) in self.views.iter_mut().zip(cameras)
        {
            let view = CullView::new(camera, SIZE, bits);
            all.target.prepare(commands);
            all.begin_rendering(commands, &view, Rendering::First);
            all.bind(commands, &view, BucketId(0));
            commands.draw_indexed(&every_box);
            all.end_rendering(commands);
            all.target.restore(commands);
            for (images, copy) in [culled, all].into_iter().zip(&copies[slot]) {
                let resolved = images.resolved.as_ref();
                images.colour.record_copy(self.host, commands.raw(), resolved, copy);
            }
        }
    }

    /// Notes that the frame has ended. Its images are compared later if it runs.
    pub fn ended(&mut self, tick: Tick, SlotIndex(slot): SlotIndex, runs: Runs) {
        let scene = &self.scene;
        self.views.iter_mut().for_each(|view| view.state.submitted(tick, scene, None));
        self.scene.submitted(tick);
        self.is_drawn[slot] = runs == Runs::Once;
    }

    /// Compares the images of the last frame in a slot, which is over. Returns false if it never
    /// ran.
    pub fn compare(&mut self, slot: usize, what: &str) -> bool {
        let is_drawn = std::mem::take(&mut self.is_drawn[slot]);
        for (number, view) in self.views.iter().enumerate().filter(|_| is_drawn) {
            let [culled, all] = view.copies[slot].each_ref().map(|copy| copy.bytes(self.host));
            let wrong = pixels_that_differ(&culled, &all);
            assert_eq!(wrong, 0, "view {number} of {what}");
            let seen = all.chunks_exact(4).any(|pixel| pixel[..3] != [0; 3]);
            assert!(seen || self.instances.is_empty(), "nothing in view {number} of {what}");
        }
        is_drawn
    }

    /// Returns the views, each with its newest plan.
    pub fn states(&self) -> impl Iterator<Item = &OcclusionState> {
        self.views.iter().map(|view| &view.state)
    }

    /// Takes the smallest number of draws in a frame of any view. Frames that never ran do not
    /// count.
    pub fn fewest_draws(&mut self) -> Option<u64> {
        let completed = self.device.completed().unwrap();
        let drawn = self.views.iter_mut().flat_map(|view| {
            view.state.collect(completed, &self.scene);
            view.state.drain_stats().map(|outcome| outcome.draws).filter(|draws| *draws > 0)
        });
        drawn.min()
    }

    /// Destroys what the host owns. All frames are over.
    pub fn destroy(self) {
        let Self { host, views, .. } = self;
        for ComparedView { culled, all, copies, .. } in views {
            copies.into_iter().flatten().for_each(|copy| copy.destroy(host));
            for BoxImages { colour, depth, resolved, passes, .. } in [culled, all] {
                passes.into_iter().for_each(OwnPasses::destroy);
                [colour, depth].into_iter().chain(resolved).for_each(|image| image.destroy(host));
            }
        }
    }
}

/// The target of a host with its colour, depth, render passes, and resolved colour.
type HostTarget = (Target, OwnImage, OwnImage, Option<OwnPasses>, Option<OwnImage>);

/// Creates images, and the target over them.
fn images_of(host: &Host, device: &Device, options: &BoxOptions<'_>) -> HostTarget {
    use vk::{AccessFlags2 as A, ImageUsageFlags as U, PipelineStageFlags2 as S};
    let format = vk::Format::R8G8B8A8_UNORM;
    let one = vk::SampleCountFlags::TYPE_1;
    let samples = options.samples;
    let usage = U::COLOR_ATTACHMENT | U::TRANSFER_SRC | U::TRANSFER_DST;
    let colour = OwnImage::new(host, SIZE, format, samples, usage);
    let resolved = (samples != one).then(|| OwnImage::new(host, SIZE, format, one, usage));
    let usage = if samples == one {
        U::DEPTH_STENCIL_ATTACHMENT | U::TRANSFER_SRC
    } else {
        U::DEPTH_STENCIL_ATTACHMENT
    };
    let depth = OwnImage::new(host, SIZE, vk::Format::D32_SFLOAT, samples, usage);
    let fresh = |own: &OwnImage, ImageState { stages, access, .. }, exit| HostImage {
        image: own.image,
        view: own.view,
        format: own.format,
        usage: own.usage,
        entry: ImageState { layout: vk::ImageLayout::UNDEFINED, stages, access },
        exit,
    };
    let copied = ImageState {
        layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
        stages: S::ALL_TRANSFER,
        access: A::TRANSFER_READ,
    };
    let written = ImageState::depth_attachment();
    let written = ImageState { stages: written.stages | S::ALL_TRANSFER, ..written };
    let images = HostImages {
        depth: fresh(&depth, written, None),
        colours: &[fresh(&colour, copied, Some(copied))],
        samples,
        near_depth: NearDepth::One,
        views: 1,
        size: SIZE,
    };
    // SAFETY: the images live until all frames are over, and nothing else uses them in between.
    let target = unsafe { Target::of_host(device, &images) }.unwrap();
    let passes = (options.renderings == RenderingOwner::Host)
        .then(|| OwnPasses::new(host, &colour, &depth, samples, SIZE));
    (target, colour, depth, passes, resolved)
}

fn attachments_of(target: &Target, passes: Option<&OwnPasses>) -> Attachments {
    passes.map_or(target.attachments(), |passes| passes.attachments(target.attachments()))
}

impl BoxImages {
    fn new(device: &Device, scene: &CulledScene, images: HostTarget) -> Self {
        let (target, colour, depth, passes, resolved) = images;
        let attachments = attachments_of(&target, passes.as_ref());
        let boxes = NumberedBoxes::new(device, scene.leaves(), attachments).unwrap();
        Self { target, boxes, colour, depth, resolved, passes }
    }

    /// Draws lists in a rendering of the host.
    fn draw_lists(
        &mut self,
        commands: &Commands,
        lists: &[DrawList],
        view: &CullView,
        rendering: Rendering,
    ) {
        self.target.prepare(commands);
        self.begin_rendering(commands, view, rendering);
        for list in lists {
            self.bind(commands, view, list.bucket);
            match list.count {
                Some(count) => commands.draw_indirect_count(list.commands, count),
                None => commands.draw_indirect(list.commands),
            }
        }
        self.end_rendering(commands);
    }
}

impl ObjectRenderer for BoxImages {
    fn target(&mut self) -> &mut Target {
        &mut self.target
    }

    fn rendering(&self, _view: &CullView, rendering: Rendering) -> RenderTarget {
        self.target.render_target((rendering == Rendering::First).then_some([0.0, 0.0, 0.0, 1.0]))
    }

    fn begin_rendering(
        &mut self,
        commands: &Commands,
        view: &CullView,
        rendering: Rendering,
    ) -> bool {
        let Some(passes) = &self.passes else {
            return commands.begin_rendering(self.rendering(view, rendering));
        };
        passes.begin(commands.raw(), rendering);
        commands.set_viewport(&Viewport::covering(view.origin, view.size));
        true
    }

    fn end_rendering(&mut self, commands: &Commands) {
        match &self.passes {
            None => commands.end_rendering(),
            Some(passes) => passes.end(commands.raw()),
        }
    }

    fn bind(&self, commands: &Commands, view: &CullView, _bucket: BucketId) {
        self.boxes.bind(commands, view);
    }
}
