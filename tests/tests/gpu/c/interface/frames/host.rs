//! A host in C that draws objects with several draws in several buckets, in several views.

use std::ffi::c_void;
use std::ptr::{from_mut, from_ref, null, null_mut};

use ash::vk;
use capi::api::context::{antumbra_context_create, antumbra_context_destroy};
use capi::api::device::{antumbra_device_destroy, antumbra_device_finished};
use capi::api::device_costs::{antumbra_device_costs_destroy, antumbra_device_costs_measure};
use capi::api::scene::*;
use capi::context::{AntumbraContext, AntumbraContextDesc};
use capi::decisions::camera::AntumbraCamera;
use capi::decisions::hierarchy::AntumbraAabb;
use capi::error::{AntumbraError, AntumbraResult};
use capi::executor::device::{AntumbraDevice, AntumbraDeviceDesc};
use capi::executor::device_costs::AntumbraDeviceCosts;
use capi::executor::frame::*;
use capi::executor::lists::{ANTUMBRA_DRAWS_BY_LISTS, AntumbraDrawLists};
use capi::executor::queue::AntumbraQueueDesc;
use capi::executor::scene::*;
use capi::executor::target::{AntumbraAttachments, AntumbraImage, AntumbraTargetDesc};
use capi::layout::Versioned;
use capi::renderer::device_costs::AntumbraDeviceCostsDesc;
use cull::{Aabb, CullView};
use occlusion::Rendering;
use tests::host_commands::{HostCommands, Runs};
use tests::host_device::Host;
use tests::host_images::OwnBuffer;
use tests::host_walk::{boxes, camera};
use tests::walk::pixels_that_differ;

use super::images::{COLOUR, ViewImages, area};
use super::lists;
use super::pipeline::{BoxPipeline, INDICES};
use super::{Costs, FrameOptions, SIZE};
use crate::c::interface::{adopt, adopt_with, no_error, text};

pub const VIEWS: usize = 2;
const BUCKETS: u32 = 3;
const IN_FLIGHT: usize = 2;

/// A host with its scene. Destroyed by [`DrawingHost::finish`].
pub struct DrawingHost<'a> {
    host: &'a Host,
    context: *mut AntumbraContext,
    device: AntumbraDevice,
    scene: AntumbraScene,
    views: [AntumbraView; VIEWS],
    error: AntumbraError,
    /// The objects, and their draws.
    objects: Vec<(u32, Vec<AntumbraObjectDraw>)>,
    pipeline: BoxPipeline,
    /// The images of each view: with our culling, and of all draws.
    images: [[ViewImages; 2]; VIEWS],
    commands: HostCommands<'a>,
    /// The command buffers of draws from lists, before and after the tests.
    around_tests: [HostCommands<'a>; 2],
    /// An `ANTUMBRA_DRAWS_..`.
    draws: u32,
    /// The copies of the images of each frame.
    copies: Vec<[[OwnBuffer; 2]; VIEWS]>,
    /// The smallest number of objects in a frame of each view, as drawn by the GPU.
    fewest: [u64; VIEWS],
    /// The budget of queries of all views together, if any.
    query_budget: usize,
    /// The most queries of all views together in a frame.
    most_queries: u64,
    /// The lists of revealed draws of all frames.
    pub revealed_lists: usize,
}

/// The state that callbacks read while a frame is recorded.
struct Recording<'a> {
    host: &'a Host,
    ids: [AntumbraView; VIEWS],
    views: [CullView; VIEWS],
    images: [&'a ViewImages; VIEWS],
    pipeline: &'a BoxPipeline,
}

impl Recording<'_> {
    fn number(&self, view: AntumbraView) -> usize {
        self.ids.iter().position(|id| *id == view).unwrap()
    }
}

unsafe extern "C" fn bind(user: *mut c_void, binding: *const AntumbraBinding) {
    // SAFETY: `draw` passes this as user; the binding is that of the call.
    let (host, binding) = unsafe { (&*user.cast::<Recording<'_>>(), &*binding) };
    let view = &host.views[host.number(binding.view)];
    host.pipeline.bind(binding.commands, view, binding.bucket);
}

unsafe extern "C" fn begin(user: *mut c_void, rendering: *const AntumbraRendering) {
    // SAFETY: as above.
    let (host, begun) = unsafe { (&*user.cast::<Recording<'_>>(), &*rendering) };
    let rendering = if begun.is_first == 1 { Rendering::First } else { Rendering::Next };
    host.images[host.number(begun.view)].begin(host.host, begun.commands, rendering);
}

unsafe extern "C" fn end(user: *mut c_void, rendering: *const AntumbraRendering) {
    // SAFETY: as above.
    let (host, ended) = unsafe { (&*user.cast::<Recording<'_>>(), &*rendering) };
    host.images[host.number(ended.view)].end(host.host, ended.commands);
}

/// Returns the two halves of a box.
fn halves(bounds: &Aabb) -> [Aabb; 2] {
    let mut left = *bounds;
    let mut right = *bounds;
    let middle = (bounds.min.x + bounds.max.x) * 0.5;
    (left.max.x, right.min.x) = (middle, middle);
    [left, right]
}

/// Returns the draws of an object: its halves in two buckets, or both in one draw.
fn draws_of(number: u32) -> Vec<AntumbraObjectDraw> {
    let draw = |bucket, first_instance, instance_count| AntumbraObjectDraw {
        bucket: bucket % BUCKETS,
        index_count: INDICES,
        instance_count,
        first_index: 0,
        vertex_offset: 0,
        first_instance,
    };
    let first = number * 2;
    match number % 5 {
        0 => vec![draw(number, first, 2)],
        _ => vec![draw(number, first, 1), draw(number + 1, first + 1, 1)],
    }
}

impl<'a> DrawingHost<'a> {
    pub fn new(host: &'a Host, options: &FrameOptions) -> Self {
        let images = [(); VIEWS].map(|()| [(); 2].map(|()| ViewImages::new(host, options)));
        let pass = images[0][0].passes.as_ref().map(|passes| passes.raw());
        let boxes = boxes();
        let instances: Vec<Aabb> = boxes.iter().flat_map(halves).collect();
        let formats = [COLOUR, options.depth];
        let mut attachments = AntumbraAttachments {
            depth_format: options.depth,
            samples: options.samples,
            colour_count: 1,
            render_pass: pass.unwrap_or_default(),
            ..Versioned::INIT
        };
        attachments.colour_formats[0] = COLOUR;
        let mut new = Self {
            host,
            context: null_mut(),
            device: AntumbraDevice { id: 0 },
            scene: AntumbraScene { id: 0 },
            views: [AntumbraView { id: 0 }; VIEWS],
            error: no_error(),
            objects: Vec::new(),
            pipeline: BoxPipeline::new(host, formats, options.samples, pass, &instances),
            images,
            commands: HostCommands::new(host, IN_FLIGHT),
            around_tests: [(); 2].map(|()| HostCommands::new(host, IN_FLIGHT)),
            draws: options.draws,
            copies: Vec::new(),
            fewest: [u64::MAX; VIEWS],
            query_budget: options.query_budget,
            most_queries: 0,
            revealed_lists: 0,
        };
        // SAFETY: pointers to values on this stack, and to those of `new`.
        unsafe {
            let made = antumbra_context_create(
                &AntumbraContextDesc::current(),
                &mut new.context,
                null_mut(),
            );
            assert_eq!(made, AntumbraResult::Ok);
            let (adopted, device, error) = adopt(host, new.context, null(), |_| {});
            assert_eq!(adopted, AntumbraResult::Ok, "{}", text(&error));
            new.device = device;
            let costs = match options.costs {
                Costs::None => AntumbraDeviceCosts { id: 0 },
                Costs::Measured => new.measure(),
            };
            let desc = AntumbraSceneDesc {
                costs,
                disabled: options.disabled,
                device,
                attachments: &attachments,
                bucket_count: BUCKETS,
                predication: options.predication,
                draws: options.draws,
                resubmission: options.resubmission,
                ..Versioned::INIT
            };
            let made = antumbra_scene_create(new.context, &desc, &mut new.scene, &mut new.error);
            new.check(made);
            new.check(antumbra_device_costs_destroy(new.context, costs, null_mut()));
            for view in 0..VIEWS {
                let Self { context, scene, views, error, .. } = &mut new;
                let made = antumbra_view_create(*context, *scene, &mut views[view], error);
                new.check(made);
            }
        }
        new.add(&boxes);
        new
    }

    /// Measures the costs of the device, which is adopted with its queue for this.
    fn measure(&mut self) -> AntumbraDeviceCosts {
        let queue = AntumbraQueueDesc { queue: self.host.queue, ..Versioned::INIT };
        let with_queue = |desc: &mut AntumbraDeviceDesc| desc.queue = &queue;
        let (adopted, device, error) = adopt_with(self.host, self.context, |_| {}, with_queue);
        assert_eq!(adopted, AntumbraResult::Ok, "{}", text(&error));
        let [width, height] = SIZE;
        let desc = AntumbraDeviceCostsDesc { device, width, height, ..Versioned::INIT };
        let mut costs = AntumbraDeviceCosts { id: 0 };
        // SAFETY: pointers to values on this stack.
        unsafe {
            let x = self.context;
            let error = &raw mut self.error;
            let without_queue = AntumbraDeviceCostsDesc { device: self.device, ..desc };
            let refused = antumbra_device_costs_measure(x, &without_queue, &mut costs, error);
            assert_eq!(refused, AntumbraResult::BadArgument);
            let measured = antumbra_device_costs_measure(x, &desc, &mut costs, error);
            self.check(measured);
            let destroyed = antumbra_device_destroy(x, device, error);
            self.check(destroyed);
        }
        costs
    }

    /// Returns the counts of the first view.
    pub fn stats(&self) -> AntumbraViewStats {
        let mut stats = AntumbraViewStats::INIT;
        // SAFETY: a value on this stack.
        let told = unsafe {
            antumbra_view_stats(self.context, self.scene, self.views[0], &mut stats, null_mut())
        };
        assert_eq!(told, AntumbraResult::Ok);
        stats
    }

    #[track_caller]
    fn check(&self, result: AntumbraResult) {
        assert_eq!(result, AntumbraResult::Ok, "{}", text(&self.error));
    }

    /// Adds all boxes in one call.
    fn add(&mut self, boxes: &[Aabb]) {
        let mut draws = Vec::new();
        let objects = boxes.iter().enumerate().map(|(number, bounds)| {
            let own = draws_of(number as u32);
            let first_draw = draws.len() as u32;
            let draw_count = own.len() as u32;
            draws.extend(own);
            let bounds = AntumbraAabb { min: bounds.min.to_array(), max: bounds.max.to_array() };
            AntumbraObject { bounds, first_draw, draw_count }
        });
        let objects: Vec<AntumbraObject> = objects.collect();
        let mut ids = vec![0; objects.len()];
        let o = objects.as_ptr();
        let d = draws.as_ptr();
        let counts = [objects.len(), draws.len()];
        // SAFETY: arrays of these lengths.
        let added = unsafe {
            let ids = ids.as_mut_ptr();
            let error = &mut self.error;
            antumbra_scene_add(self.context, self.scene, o, counts[0], d, counts[1], ids, error)
        };
        self.check(added);
        let own = (0..boxes.len() as u32).map(draws_of);
        self.objects = ids.into_iter().zip(own).collect();
    }

    /// Removes some objects, in one call.
    pub fn remove_some(&mut self) {
        let is_some = |number: &mut (u32, Vec<_>)| number.0 % 7 == 3;
        let gone: Vec<u32> =
            self.objects.extract_if(.., is_some).map(|removed| removed.0).collect();
        let first = gone.as_ptr();
        let count = gone.len();
        // SAFETY: an array of this length.
        let removed = unsafe {
            antumbra_scene_remove(self.context, self.scene, first, count, &mut self.error)
        };
        self.check(removed);
    }

    /// Draws the wall in another bucket from now on.
    pub fn change_draws(&mut self) {
        let (wall, draws) = &mut self.objects[0];
        draws[0].bucket = BUCKETS - 1;
        let first = draws.as_ptr();
        let count = draws.len();
        // SAFETY: an array of this length.
        let changed = unsafe {
            let error = &mut self.error;
            antumbra_scene_set_draws(self.context, self.scene, *wall, first, count, error)
        };
        self.check(changed);
    }

    /// Draws a frame of all views, draws all objects again, and submits.
    pub fn draw(&mut self, frame: u64) {
        // SAFETY: a physical device of this instance.
        let limits =
            unsafe { self.host.instance.get_physical_device_properties(self.host.physical) }.limits;
        let bits = limits.sub_pixel_precision_bits;
        let views = [frame, frame + 7].map(|frame| CullView::new(&camera(frame), SIZE, bits));
        let (commands, numbers) = self.commands.begin();
        let images = self.images.each_ref().map(|[culled, _]| culled);
        let mut recording =
            Recording { host: self.host, ids: self.views, views, images, pipeline: &self.pipeline };
        let [width, height] = SIZE;
        let cameras = views.map(|view| AntumbraCamera {
            sub_pixel_bits: bits,
            clip_from_world: view.view_proj.to_cols_array(),
            width,
            height,
            ..Versioned::INIT
        });
        let described: [[AntumbraImage; 2]; VIEWS] =
            images.map(|images| images.described(self.draws));
        let targets = described.each_ref().map(|[colour, depth]| AntumbraTargetDesc {
            depth: *depth,
            width,
            height,
            colour_count: 1,
            colours: from_ref(colour),
            ..Versioned::INIT
        });
        let frames: [AntumbraViewFrame; VIEWS] = std::array::from_fn(|view| AntumbraViewFrame {
            view: self.views[view],
            camera: &cameras[view],
            target: &targets[view],
            ..Versioned::INIT
        });
        let listed = frames.each_ref().map(from_ref);
        let owns_renderings = images[0].passes.is_some();
        let desc = AntumbraFrameDesc {
            view_count: VIEWS as u32,
            views: listed.as_ptr(),
            commands,
            current: numbers.current.0,
            safe: numbers.safe.0,
            bind: (self.draws != ANTUMBRA_DRAWS_BY_LISTS).then_some(bind),
            user: from_mut(&mut recording).cast(),
            begin_rendering: owns_renderings.then_some(begin),
            end_rendering: owns_renderings.then_some(end),
            query_budget: self.query_budget,
            ..Versioned::INIT
        };
        // SAFETY: a command buffer of the host that is being recorded; the frames up to the safe
        // one were waited for.
        let recorded =
            unsafe { antumbra_scene_record(self.context, self.scene, &desc, &mut self.error) };
        self.check(recorded);
        if self.draws == ANTUMBRA_DRAWS_BY_LISTS {
            self.draw_lists(&views);
        } else {
            self.draw_all(commands, &views);
            self.commands.end(Runs::Once).unwrap();
        }
        self.note_counts();
    }

    /// Draws the lists of the newest frame around its tests, and draws all objects again.
    fn draw_lists(&mut self, views: &[CullView; VIEWS]) {
        let lists = self.views.map(|view| {
            let mut lists = AntumbraDrawLists::INIT;
            let Self { context, scene, error, .. } = self;
            // SAFETY: values on this stack.
            let told = unsafe { antumbra_view_lists(*context, *scene, view, &mut lists, error) };
            assert_eq!(told, AntumbraResult::Ok, "{}", text(error));
            lists
        });
        self.revealed_lists += lists.iter().map(|list| list.revealed_count).sum::<usize>();
        let draw = |recording: &Self, commands, rendering| {
            for ((view, lists), [culled, _]) in views.iter().zip(&lists).zip(&recording.images) {
                if rendering == Rendering::First {
                    culled.prepare(recording.host, commands);
                }

                lists::record(
                    recording.host,
                    commands,
                    culled,
                    &recording.pipeline,
                    lists,
                    view,
                    rendering,
                );
                if rendering == Rendering::Next {
                    culled.restore(recording.host, commands);
                }
            }
        };
        let (before, _) = self.around_tests[0].begin();
        draw(self, before, Rendering::First);
        self.around_tests[0].end(Runs::Once).unwrap();
        self.commands.end(Runs::Once).unwrap();
        let (behind, _) = self.around_tests[1].begin();
        draw(self, behind, Rendering::Next);
        self.draw_all(behind, views);
        self.around_tests[1].end(Runs::Once).unwrap();
    }

    /// Draws all objects without culling, and copies all images.
    fn draw_all(&mut self, commands: vk::CommandBuffer, views: &[CullView; VIEWS]) {
        let device = &self.host.device;
        let bytes = u64::from(SIZE[0] * SIZE[1] * 4);
        let copies = [(); VIEWS].map(|()| [(); 2].map(|()| OwnBuffer::new(self.host, bytes)));
        for ((images, view), copies) in self.images.iter().zip(views).zip(&copies) {
            let [_, all] = images;
            all.prepare(self.host, commands);
            all.begin(self.host, commands, Rendering::First);
            let [width, height] = SIZE.map(|pixels| pixels as f32);
            let viewport = vk::Viewport { width, height, max_depth: 1.0, ..Default::default() };
            // SAFETY: the rendering that was begun, in a command buffer that is being recorded.
            unsafe {
                device.cmd_set_viewport(commands, 0, &[viewport]);
                device.cmd_set_scissor(commands, 0, &[area()]);
                for bucket in 0..BUCKETS {
                    self.pipeline.bind(commands, view, bucket);
                    let draws = self.objects.iter().flat_map(|(_, draws)| draws);
                    for drawn in draws.filter(|draw| draw.bucket == bucket) {
                        let count = drawn.instance_count;
                        let first = drawn.first_instance;
                        device.cmd_draw_indexed(commands, drawn.index_count, count, 0, 0, first);
                    }
                }
            }
            all.end(self.host, commands);
            all.restore(self.host, commands);
            for (images, copy) in images.iter().zip(copies) {
                images.copy(self.host, commands, copy);
            }
        }
        self.copies.push(copies);
    }

    /// Notes the number of drawn objects in the last known frame of each view, and the queries of
    /// this frame.
    fn note_counts(&mut self) {
        let mut queries = 0;
        for (view, fewest) in self.views.iter().zip(&mut self.fewest) {
            let mut stats = AntumbraViewStats::INIT;
            // SAFETY: values on this stack.
            let told = unsafe {
                antumbra_view_stats(self.context, self.scene, *view, &mut stats, null_mut())
            };
            assert_eq!(told, AntumbraResult::Ok);
            if stats.frame > 0 {
                *fewest = stats.objects.min(*fewest);
            }
            queries += stats.queries;
        }
        self.most_queries = self.most_queries.max(queries);
    }

    /// Compares the images of all frames, and destroys everything. Returns the smallest number of
    /// objects in a frame of each view, and the largest number of queries in a frame.
    pub fn finish(mut self, what: &str) -> ([u64; VIEWS], u64) {
        let host = self.host;
        host.wait_idle();
        for (frame, views) in self.copies.iter().enumerate() {
            for (view, copies) in views.iter().enumerate() {
                let [culled, all] = copies.each_ref().map(|copy| copy.bytes(host));
                let wrong = pixels_that_differ(&culled, &all);
                assert_eq!(wrong, 0, "{what}: frame {frame}, view {view}");
                let seen = all.chunks_exact(4).any(|pixel| pixel[..3] != [0; 3]);
                assert!(seen, "{what}: nothing in frame {frame}, view {view}");
            }
        }
        // SAFETY: the GPU is idle.
        unsafe {
            let finished = antumbra_device_finished(self.context, self.device, &mut self.error);
            self.check(finished);
            let destroyed = antumbra_context_destroy(self.context, &mut self.error);
            self.check(destroyed);
        }
        self.copies.into_iter().flatten().flatten().for_each(|copy| copy.destroy(host));
        self.images.into_iter().flatten().for_each(|images| images.destroy(host));
        self.pipeline.destroy(host);
        self.commands.destroy();
        self.around_tests.into_iter().for_each(HostCommands::destroy);
        (self.fewest, self.most_queries)
    }
}
