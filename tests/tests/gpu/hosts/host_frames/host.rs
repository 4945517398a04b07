//! A host with boxes, with its own images, command buffers and submits, and our culling in between.
#![allow(unsafe_code, reason = "a host calls Vulkan itself")]

use ash::vk;
use cull::{Aabb, Camera, DepthConvention, ObjectId, Projection, Strategy};
use glam::Vec3;
use gpu::{
    Device, FrameNumbers, FrameRing, NearDepth, PredicationMode, Purpose, Resubmission, Tick,
};
use occlusion::{CulledScene, DrawRequest, OcclusionState};
use tests::Driver;
use tests::host_device::Host;
use tests::host_images::{OwnBuffer, OwnImage};
use tests::host_passes::OwnPasses;
use tests::host_walk::{boxes, camera};
use tests::numbered_boxes::{NumberedBoxes, scene_of_boxes};
use tests::projections::Lens;
use tests::walk::pixels_that_differ;

use super::boxes::{Boxes, target_of};

pub const SIZE: [u32; 2] = [160, 90];
pub const FRAMES: u64 = 24;
const IN_FLIGHT: u64 = 2;
const COLOUR: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// The choices of a host.
#[derive(Clone, Copy, Debug)]
pub struct HostOptions {
    pub depth: vk::Format,
    pub samples: vk::SampleCountFlags,
    pub passes: Passes,
    pub lens: Lens,
    pub projection: Projection,
    pub strategy: Strategy,
    /// The way that hidden draws are skipped; `None` takes the device's best.
    pub predication: Option<PredicationMode>,
    /// The number of the first frame.
    pub first: u64,
    pub resubmission: Resubmission,
}

/// The owner of the render passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passes {
    /// The engine begins dynamic rendering.
    Engine,
    /// The host begins its render pass object.
    Host,
}

impl Default for HostOptions {
    fn default() -> Self {
        let depth = vk::Format::D32_SFLOAT;
        let samples = vk::SampleCountFlags::TYPE_1;
        Self {
            depth,
            samples,
            passes: Passes::Engine,
            lens: Lens::PLAIN,
            projection: Projection::perspective(0.9),
            strategy: Strategy::ANTUMBRA,
            predication: None,
            first: 1,
            resubmission: Resubmission::Never,
        }
    }
}

/// The submits of the command buffer of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Submits {
    Once,
    Never,
    Twice,
    /// Submitted after the next frame.
    Late,
}

/// The draws of the last frames with and without culling.
#[derive(Clone, Copy, Debug)]
pub struct Draws {
    pub plain: u64,
    pub culled: u64,
}

/// A host with its objects of the engine.
pub struct HostLoop<'a> {
    pub host: &'a Host,
    pub device: Device,
    pool: vk::CommandPool,
    fences: Vec<vk::Fence>,
    pub frames: FrameRing,
    pub scene: CulledScene,
    objects: Boxes,
    pub state: OcclusionState,
    colour: OwnImage,
    depth: OwnImage,
    resolved: Option<OwnImage>,
    images: Vec<OwnBuffer>,
    lens: Lens,
    next: u64,
    first: u64,
    /// A frame that is submitted after the next one.
    late: Option<(vk::CommandBuffer, vk::Fence)>,
}

/// Draws the walk with and without culling, and compares the image of every frame that ran.
pub fn compare(driver: Driver, options: &HostOptions, submits: impl Fn(u64) -> Submits) -> Draws {
    let host = Host::new(driver, Purpose::Executor);
    let draws = {
        let [mut plain, mut culled] = [(); 2].map(|()| HostLoop::new(&host, options));
        for frame in 0..FRAMES {
            let camera = Camera { projection: options.projection, ..camera(frame) };
            plain.move_boxes(frame);
            plain.draw(Strategy::FRUSTUM, &camera, Submits::Once).unwrap();
            culled.move_boxes(frame);
            culled.draw(options.strategy, &camera, submits(frame)).unwrap();
        }
        let [all, few] = [&mut plain, &mut culled].map(HostLoop::finish_draws);
        // A frame that runs after a later frame shows boxes where the later frame left them.
        let ran = |frame: &u64| matches!(submits(*frame), Submits::Once | Submits::Twice);
        for frame in (0..FRAMES).filter(ran) {
            let [plain, culled] = [&plain, &culled].map(|images| images.image(frame));
            let wrong = pixels_that_differ(&plain, &culled);
            assert_eq!(wrong, 0, "{driver:?}, {options:?}, frame {frame}");
        }
        plain.destroy();
        culled.destroy();
        Draws { plain: all, culled: few }
    };
    host.finish();
    draws
}

impl<'a> HostLoop<'a> {
    pub fn new(host: &'a Host, options: &HostOptions) -> Self {
        let device = host.adopt(None);
        use vk::ImageUsageFlags as U;
        let HostOptions { depth, samples, passes, lens, first, .. } = *options;
        let transfers = U::TRANSFER_SRC | U::TRANSFER_DST;
        let colour = OwnImage::new(host, SIZE, COLOUR, samples, U::COLOR_ATTACHMENT | transfers);
        let usage = match samples {
            vk::SampleCountFlags::TYPE_1 => U::DEPTH_STENCIL_ATTACHMENT | U::TRANSFER_SRC,
            _ => U::DEPTH_STENCIL_ATTACHMENT,
        };
        let depth = OwnImage::new(host, SIZE, depth, samples, usage);
        let is_resolved = samples != vk::SampleCountFlags::TYPE_1;
        let one = vk::SampleCountFlags::TYPE_1;
        let resolved = is_resolved
            .then(|| OwnImage::new(host, SIZE, COLOUR, one, U::COLOR_ATTACHMENT | transfers));
        let near_depth = match lens.depth {
            DepthConvention::Reversed => NearDepth::One,
            DepthConvention::Standard => NearDepth::Zero,
        };

        let target = target_of(&device, &colour, &depth, samples, near_depth);
        let passes =
            (passes == Passes::Host).then(|| OwnPasses::new(host, &colour, &depth, samples, SIZE));
        let attachments = target.attachments();
        let attachments =
            passes.as_ref().map_or(attachments, |passes| passes.attachments(attachments));
        let scene = scene_of_boxes(&device, &boxes(), attachments, options.predication).unwrap();
        let state = scene.new_view(&target).unwrap();
        let boxes = NumberedBoxes::new(&device, scene.leaves(), attachments).unwrap();
        let objects = Boxes { target, boxes, passes };
        let pool = vk::CommandPoolCreateInfo::default()
            .queue_family_index(host.needs.queue_family.unwrap());
        // SAFETY: the family of the host's queue.
        let pool = unsafe { host.device.create_command_pool(&pool, None) }.unwrap();
        let mut frames = FrameRing::new(&device, IN_FLIGHT as usize).unwrap();
        frames.set_resubmission(options.resubmission);
        let fences = Vec::new();
        let images = Vec::new();
        let late = None;
        Self {
            host,
            device,
            pool,
            fences,
            frames,
            scene,
            objects,
            state,
            colour,
            depth,
            resolved,
            images,
            lens,
            next: first,
            first,
            late,
        }
    }

    /// Moves some boxes, which differ between frames: each change is made in a single frame.
    fn move_boxes(&mut self, frame: u64) {
        let moved = (1..1_000).filter(|number| number % 5 == frame % 5).map(|number| {
            let bounds = boxes()[number as usize];
            // Out of sight and back, all along the same way, so that boxes do not meet.
            let by = Vec3::Y * if (frame / 5).is_multiple_of(2) { 40.0 } else { 0.0 };
            (ObjectId(number as u32), Aabb::new(bounds.min + by, bounds.max + by))
        });
        let moved: Vec<(ObjectId, Aabb)> = moved.collect();
        self.scene.move_to(&moved).unwrap();
    }

    /// Returns a command buffer of the host in recording.
    fn begin_commands(&self) -> vk::CommandBuffer {
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.pool)
            .command_buffer_count(1);
        let device = &self.host.device;
        // SAFETY: a fresh command buffer of the host.
        unsafe {
            let raw = device.allocate_command_buffers(&info).unwrap()[0];
            let twice = vk::CommandBufferUsageFlags::SIMULTANEOUS_USE;
            let info = vk::CommandBufferBeginInfo::default().flags(twice);
            device.begin_command_buffer(raw, &info).unwrap();
            raw
        }
    }

    /// Begins a frame with these numbers, gives it up, and returns the refusal, if any. The GPU
    /// must be idle.
    pub fn refusal(&mut self, current: u64, safe: u64) -> Option<gpu::Error> {
        let raw = self.begin_commands();
        let numbers = FrameNumbers { current: Tick(current), safe: Tick(safe) };
        // SAFETY: the command buffer is being recorded; nothing runs.
        unsafe { self.frames.begin_in(raw, numbers) }.err()
    }

    /// Draws a frame into a command buffer of the host.
    pub fn draw(
        &mut self,
        strategy: Strategy,
        camera: &Camera,
        submits: Submits,
    ) -> Result<(), occlusion::Error> {
        let raw = self.begin_commands();
        let Self { host, device, frames, scene, objects, state, .. } = self;
        let current = self.next;
        self.next += 1;
        let safe = current.saturating_sub(IN_FLIGHT).max(self.first - 1);
        if let Some(fence) =
            (safe.checked_sub(self.first)).and_then(|place| self.fences.get(place as usize))
        {
            // SAFETY: fences of this device.
            unsafe { host.device.wait_for_fences(&[*fence], true, 60_000_000_000) }.unwrap();
        }
        let numbers = FrameNumbers { current: Tick(current), safe: Tick(safe) };
        // SAFETY: the command buffer is being recorded; frames up to `safe` were waited for.
        let frame = unsafe { frames.begin_in(raw, numbers) }.unwrap();
        let bits = device.adapter().limits.sub_pixel_precision_bits;
        let view = self.lens.view(camera, current, SIZE, bits);
        let request = DrawRequest { strategy, ..DrawRequest::from(&view) };
        let mut scope = scene.begin(frame)?;
        scope.draw(state, request, objects)?;
        scope.end()?;
        self.copy_image(raw);
        // SAFETY: the command buffer is complete.
        unsafe { self.host.device.end_command_buffer(raw) }.unwrap();
        // SAFETY: a plain fence.
        let fence = unsafe { self.host.device.create_fence(&Default::default(), None) }.unwrap();
        self.fences.push(fence);
        self.submit(raw, fence, submits);
        Ok(())
    }

    fn submit(&mut self, raw: vk::CommandBuffer, fence: vk::Fence, submits: Submits) {
        let buffers = [raw];
        let submit = |buffers: &[vk::CommandBuffer], fence| {
            let info = vk::SubmitInfo::default().command_buffers(buffers);
            // SAFETY: complete command buffers, and the host's own queue.
            unsafe { self.host.device.queue_submit(self.host.queue, &[info], fence) }.unwrap();
        };
        match submits {
            Submits::Once => submit(&buffers, fence),
            Submits::Twice => {
                submit(&buffers, vk::Fence::null());
                submit(&buffers, fence);
            }
            Submits::Never => submit(&[], fence),
            Submits::Late => {
                self.late = Some((raw, fence));
                return;
            }
        }
        if let Some((raw, fence)) = self.late.take() {
            submit(&[raw], fence);
        }
    }

    /// Copies the finished image to its own buffer, by the host's commands.
    fn copy_image(&mut self, raw: vk::CommandBuffer) {
        let [width, height] = SIZE;
        let buffer = OwnBuffer::new(self.host, u64::from(width * height * 4));
        self.colour.record_copy(self.host, raw, self.resolved.as_ref(), &buffer);
        self.images.push(buffer);
    }

    /// Waits for all frames and returns the draws of the last one that is known.
    pub fn finish_draws(&mut self) -> u64 {
        self.host.say_all_is_over(&self.device);
        let completed = self.device.completed().unwrap();
        self.state.collect(completed, &self.scene);
        self.state.drain_stats().next_back().map_or(0, |outcome| outcome.draws)
    }

    /// Returns the image of a frame, counted from 0. All frames are over.
    pub fn image(&self, frame: u64) -> Vec<u8> {
        self.images[frame as usize].bytes(self.host)
    }

    /// Destroys what the host owns. All frames are over.
    pub fn destroy(self) {
        let Self { host, pool, fences, objects, colour, depth, resolved, images, .. } = self;
        // SAFETY: the GPU is idle, and nothing is used any more.
        unsafe {
            host.device.destroy_command_pool(pool, None);
            fences.iter().for_each(|fence| host.device.destroy_fence(*fence, None));
        }
        objects.passes.into_iter().for_each(OwnPasses::destroy);
        [colour, depth].into_iter().chain(resolved).for_each(|image| image.destroy(host));
        images.into_iter().for_each(|image| image.destroy(host));
    }
}
