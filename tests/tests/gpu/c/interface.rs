//! The C interface on a host's device: errors name each mistake of the host, and later frames work.
#![allow(unsafe_code, reason = "a host in C calls it so")]

#[cfg(feature = "shader-compiler")]
mod frames;
mod loss;
mod memory;
mod messages;
mod mistakes;
mod renderer;
mod scenes;
mod threads;

use std::ffi::{CStr, c_char, c_void};
use std::ptr::{null, null_mut};

use ash::vk;
use capi::api::context::{antumbra_context_create, antumbra_context_destroy};
use capi::api::device::*;
use capi::api::scene::*;
use capi::context::{AntumbraContext, AntumbraContextDesc};
use capi::decisions::camera::AntumbraCamera;
use capi::decisions::hierarchy::AntumbraAabb;
use capi::error::AntumbraError;
use capi::error::AntumbraResult::{self, BadArgument, BadPointer, Busy, Ok};
use capi::executor::device::*;
use capi::executor::frame::*;
use capi::executor::scene::*;
use capi::executor::target::*;
use capi::layout::Versioned;
use gpu::{FeatureStructures, Purpose};
use tests::host_device::Host;
use tests::host_images::OwnImage;
use tests::{Driver, drivers};

use memory::Memory;

const SIZE: [u32; 2] = [64, 64];
const FORMAT: vk::Format = vk::Format::D32_SFLOAT;

/// A change of a frame's description.
type Change<'a> = &'a dyn Fn(&mut AntumbraFrameDesc);

/// A host in C: its device, adopted, with a scene of one box and a view.
struct CHost<'a> {
    host: &'a Host,
    context: *mut AntumbraContext,
    device: AntumbraDevice,
    scene: AntumbraScene,
    view: AntumbraView,
    error: AntumbraError,
    image: OwnImage,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    next: u64,
}

/// Returns the last message.
fn text(error: &AntumbraError) -> &str {
    // SAFETY: every call ends the message.
    unsafe { CStr::from_ptr(error.message.as_ptr()) }.to_str().unwrap()
}

/// Checks a result and the words of its message.
#[track_caller]
fn expect(result: AntumbraResult, wanted: AntumbraResult, words: &str, error: &AntumbraError) {
    assert_eq!(result, wanted, "{}", text(error));
    assert!(text(error).contains(words), "\"{}\" does not say \"{words}\"", text(error));
}

fn adapter(host: &Host) -> AntumbraAdapterDesc {
    AntumbraAdapterDesc {
        instance_proc_addr: Some(host.entry.static_fn().get_instance_proc_addr),
        instance: host.instance.handle(),
        physical_device: host.physical,
        ..Versioned::INIT
    }
}

/// Adopts the device of a host with all its features, except those that `change` turns off.
fn adopt(
    host: &Host,
    context: *mut AntumbraContext,
    callbacks: *const vk::AllocationCallbacks<'static>,
    change: impl FnOnce(&mut vk::PhysicalDeviceFeatures),
) -> (AntumbraResult, AntumbraDevice, AntumbraError) {
    let of_desc = |desc: &mut AntumbraDeviceDesc| desc.allocation_callbacks = callbacks;
    adopt_with(host, context, |structures| change(&mut structures.core), of_desc)
}

/// Adopts the device of a host with changed features and a changed description.
fn adopt_with(
    host: &Host,
    context: *mut AntumbraContext,
    change_features: impl FnOnce(&mut FeatureStructures),
    change: impl FnOnce(&mut AntumbraDeviceDesc),
) -> (AntumbraResult, AntumbraDevice, AntumbraError) {
    let mut structures = host.needs.features().structures();
    change_features(&mut structures);
    let features = AntumbraFeatures {
        core: &raw mut structures.core,
        vulkan_12: (&raw mut structures.vulkan_12).cast(),
        vulkan_13: (&raw mut structures.vulkan_13).cast(),
        conditional_rendering: (&raw mut structures.conditional).cast(),
        ..Versioned::INIT
    };
    let extensions = host.needs.extensions().into_iter().chain([ash::ext::debug_utils::NAME]);
    let extensions: Vec<*const c_char> = extensions.map(CStr::as_ptr).collect();
    let adapter = adapter(host);
    let mut desc = AntumbraDeviceDesc {
        queue_family: host.needs.queue_family.unwrap(),
        adapter: &adapter,
        device: host.device.handle(),
        features: &features,
        extensions: extensions.as_ptr(),
        extension_count: extensions.len(),
        ..Versioned::INIT
    };
    change(&mut desc);
    let mut device = AntumbraDevice { id: 0 };
    let mut error = no_error();
    // SAFETY: everything belongs to this host, and lives as long as the host.
    let result = unsafe { antumbra_device_adopt(context, &desc, &mut device, &mut error) };
    (result, device, error)
}

fn no_error() -> AntumbraError {
    let struct_size = size_of::<AntumbraError>() as u32;
    AntumbraError { struct_size, result: 0, message: [0; 504] }
}

unsafe extern "C" fn bind_nothing(_user: *mut c_void, _binding: *const AntumbraBinding) {}

/// A host that begins its renderings itself, and calls the interface from within a call.
struct Rendering<'a> {
    device: &'a ash::Device,
    view: vk::ImageView,
    scene: (*const AntumbraContext, AntumbraScene),
    begun: u32,
    ended: u32,
    inner: AntumbraResult,
}

unsafe extern "C" fn begin(user: *mut c_void, rendering: *const AntumbraRendering) {
    let area = vk::Rect2D {
        extent: vk::Extent2D { width: SIZE[0], height: SIZE[1] },
        ..Default::default()
    };
    // SAFETY: the test passes this as user; the rendering is that of the call.
    unsafe {
        let host = &mut *user.cast::<Rendering<'_>>();
        let depth = vk::RenderingAttachmentInfo::default()
            .image_view(host.view)
            .image_layout(vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL)
            .load_op(match (*rendering).is_first {
                0 => vk::AttachmentLoadOp::LOAD,
                _ => vk::AttachmentLoadOp::CLEAR,
            });
        let info =
            vk::RenderingInfo::default().render_area(area).layer_count(1).depth_attachment(&depth);
        host.device.cmd_begin_rendering((*rendering).commands, &info);
        assert_eq!((*rendering).is_first, u32::from(host.begun == 0));
        host.begun += 1;
        let (context, scene) = host.scene;
        host.inner = antumbra_scene_remove(context, scene, null(), 0, null_mut());
    }
}

unsafe extern "C" fn end(user: *mut c_void, rendering: *const AntumbraRendering) {
    // SAFETY: as above.
    unsafe {
        let host = &mut *user.cast::<Rendering<'_>>();
        host.device.cmd_end_rendering((*rendering).commands);
        host.ended += 1;
    }
}

impl<'a> CHost<'a> {
    fn new(host: &'a Host, callbacks: *const vk::AllocationCallbacks<'static>) -> Self {
        Self::in_context(host, &AntumbraContextDesc::current(), callbacks)
    }

    fn in_context(
        host: &'a Host,
        desc: &AntumbraContextDesc,
        callbacks: *const vk::AllocationCallbacks<'static>,
    ) -> Self {
        let mut context = null_mut();
        // SAFETY: pointers to values on this stack.
        let made = unsafe { antumbra_context_create(desc, &mut context, null_mut()) };
        assert_eq!(made, Ok);
        let (adopted, device, mut error) = adopt(host, context, callbacks, |_| {});
        assert_eq!(adopted, Ok, "{}", text(&error));
        let attachments = AntumbraAttachments { depth_format: FORMAT, ..Versioned::INIT };
        let desc = AntumbraSceneDesc {
            device,
            attachments: &attachments,
            object_capacity: 4,
            ..Versioned::INIT
        };
        let bounds = AntumbraAabb { min: [-0.5, -0.5, -3.0], max: [0.5, 0.5, -2.0] };
        let object = AntumbraObject { bounds, first_draw: 0, draw_count: 0 };
        let mut scene = AntumbraScene { id: 0 };
        let mut view = AntumbraView { id: 0 };
        let mut id = 9;
        // SAFETY: as above.
        unsafe {
            let made = antumbra_scene_create(context, &desc, &mut scene, &mut error);
            assert_eq!(made, Ok, "{}", text(&error));
            let made = antumbra_view_create(context, scene, &mut view, &mut error);
            assert_eq!(made, Ok, "{}", text(&error));
            let added =
                antumbra_scene_add(context, scene, &object, 1, null(), 0, &mut id, &mut error);
            assert_eq!(added, Ok, "{}", text(&error));
        }
        let usage =
            vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let image = OwnImage::new(host, SIZE, FORMAT, vk::SampleCountFlags::TYPE_1, usage);
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(host.needs.queue_family.unwrap())
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: plain objects of the host.
        let (pool, commands) = unsafe {
            let pool = host.device.create_command_pool(&info, None).unwrap();
            let info =
                vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            (pool, host.device.allocate_command_buffers(&info).unwrap()[0])
        };
        Self { host, context, device, scene, view, error, image, pool, commands, next: 1 }
    }

    fn target(&self) -> AntumbraTargetDesc {
        let depth = AntumbraImage {
            image: self.image.image,
            view: self.image.view,
            format: FORMAT,
            usage: self.image.usage,
            entry: AntumbraImageState {
                layout: vk::ImageLayout::UNDEFINED,
                reserved: 0,
                stages: vk::PipelineStageFlags2::ALL_COMMANDS,
                access: vk::AccessFlags2::MEMORY_WRITE,
            },
            exit: AntumbraImageState {
                layout: vk::ImageLayout::UNDEFINED,
                reserved: 0,
                stages: vk::PipelineStageFlags2::NONE,
                access: vk::AccessFlags2::NONE,
            },
        };
        let [width, height] = SIZE;
        AntumbraTargetDesc { depth, width, height, ..Versioned::INIT }
    }

    /// Records a frame of these views, changed by `change`. The frame is never submitted, so it is
    /// over.
    fn record(
        &mut self,
        views: &[*const AntumbraViewFrame],
        change: impl FnOnce(&mut AntumbraFrameDesc),
    ) -> AntumbraResult {
        let mut desc = AntumbraFrameDesc {
            view_count: views.len() as u32,
            views: views.as_ptr(),
            commands: self.commands,
            current: self.next,
            safe: self.next - 1,
            bind: Some(bind_nothing),
            ..Versioned::INIT
        };
        self.next += 1;
        change(&mut desc);
        let device = &self.host.device;
        // SAFETY: the command buffer is never submitted, so that it is over at once.
        unsafe {
            let info = vk::CommandBufferBeginInfo::default();
            device.begin_command_buffer(self.commands, &info).unwrap();
            let result = antumbra_scene_record(self.context, self.scene, &desc, &mut self.error);
            device.end_command_buffer(self.commands).unwrap();
            result
        }
    }

    /// Records a frame that is refused, then `good`.
    #[track_caller]
    fn refuse(
        &mut self,
        views: &[*const AntumbraViewFrame],
        change: impl FnOnce(&mut AntumbraFrameDesc),
        wanted: AntumbraResult,
        words: &str,
        good: &AntumbraViewFrame,
    ) {
        let result = self.record(views, change);
        expect(result, wanted, words, &self.error);
        let recorded = self.record(&[good], |_| {});
        assert_eq!(recorded, Ok, "after \"{words}\": {}", text(&self.error));
    }

    /// Destroys the host and all objects. Nothing was ever submitted.
    fn finish(mut self) {
        // SAFETY: nothing is in flight.
        unsafe {
            let finished = antumbra_device_finished(self.context, self.device, &mut self.error);
            assert_eq!(finished, Ok, "{}", text(&self.error));
            assert_eq!(antumbra_context_destroy(self.context, &mut self.error), Ok);
            self.host.device.destroy_command_pool(self.pool, None);
        }
        self.image.destroy(self.host);
    }
}

fn camera() -> AntumbraCamera {
    let [width, height] = SIZE;
    #[rustfmt::skip]
    let clip_from_world = [
        1.0, 0.0, 0.0, 0.0,
        0.0, -1.0, 0.0, 0.0,
        0.0, 0.0, 0.0, -1.0,
        0.0, 0.0, 0.1, 0.0,
    ];
    AntumbraCamera { clip_from_world, width, height, ..Versioned::INIT }
}

#[test]
fn requirements_are_added_to_what_a_host_wants() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Executor);
        let mut context = null_mut();
        let mut core = vk::PhysicalDeviceFeatures { wide_lines: vk::TRUE, ..Default::default() };
        let mut vulkan_13 = vk::PhysicalDeviceVulkan13Features::default();
        let features =
            AntumbraFeatures { core: &mut core, vulkan_13: &mut vulkan_13, ..Versioned::INIT };
        let mut needs = AntumbraRequirements::INIT;
        let mut error = no_error();
        let mut wrong = vk::PhysicalDeviceVulkan13Features {
            s_type: vk::StructureType::APPLICATION_INFO,
            ..Default::default()
        };
        let mistyped = AntumbraFeatures { vulkan_13: &mut wrong, ..Versioned::INIT };
        let lacking = AntumbraAdapterDesc { instance_proc_addr: None, ..adapter(&host) };
        let old = AntumbraAdapterDesc { api_version: vk::API_VERSION_1_2, ..adapter(&host) };
        let good = adapter(&host);
        // SAFETY: pointers to values on this stack, and the handles of the host.
        unsafe {
            antumbra_context_create(&AntumbraContextDesc::current(), &mut context, null_mut());
            let mut ask = |adapter: &AntumbraAdapterDesc, features: &AntumbraFeatures| {
                antumbra_requirements(context, adapter, features, &mut needs, &mut error)
            };
            assert_eq!(ask(&lacking, &features), BadPointer);
            assert_eq!(ask(&old, &features), BadArgument);
            assert_eq!(ask(&good, &mistyped), BadArgument);
            assert_eq!(ask(&good, &features), Ok);
            antumbra_context_destroy(context, null_mut());
        }
        assert_eq!((core.wide_lines, core.multi_draw_indirect), (vk::TRUE, vk::TRUE));
        assert_eq!(vulkan_13.dynamic_rendering, vk::TRUE);
        assert_eq!(needs.queue_family, host.needs.queue_family.unwrap());
        let names = &needs.extensions[..needs.extension_count as usize];
        // SAFETY: names of the library.
        let names: Vec<&CStr> = names.iter().map(|name| unsafe { CStr::from_ptr(*name) }).collect();
        assert_eq!(names, host.needs.extensions());
        host.finish();
    }
}

#[test]
fn a_host_begins_its_renderings_and_calls_within_a_call_are_refused() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Executor);
        let mut c = CHost::new(&host, null());
        let camera = camera();
        let target = c.target();
        let view =
            AntumbraViewFrame { view: c.view, camera: &camera, target: &target, ..Versioned::INIT };
        let mut rendering = Rendering {
            device: &host.device,
            view: c.image.view,
            scene: (c.context, c.scene),
            begun: 0,
            ended: 0,
            inner: Ok,
        };
        let recorded = c.record(&[&view], |frame| {
            frame.user = (&raw mut rendering).cast();
            frame.begin_rendering = Some(begin);
            frame.end_rendering = Some(end);
        });
        assert_eq!(recorded, Ok, "{}", text(&c.error));
        assert!(rendering.begun > 0 && rendering.begun == rendering.ended);
        assert_eq!(rendering.inner, Busy);
        c.finish();
        host.finish();
    }
}

#[test]
fn the_callbacks_of_a_host_give_and_get_all_memory() {
    let memory = Memory::default();
    let callbacks = memory.callbacks();
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let mut c = CHost::new(&host, &callbacks);
    let camera = camera();
    let target = c.target();
    let view =
        AntumbraViewFrame { view: c.view, camera: &camera, target: &target, ..Versioned::INIT };
    assert_eq!(c.record(&[&view], |_| {}), Ok, "{}", text(&c.error));
    c.finish();
    host.finish();
    let blocks = memory.blocks.into_inner();
    let made = memory.made.into_inner();
    assert!(made > 10 && blocks == 0, "{made} allocations, {blocks} left");
}
