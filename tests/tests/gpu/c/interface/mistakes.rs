//! Mistakes in the calls of a host: errors name the place, the rule and the remedy.

use std::ptr::{from_ref, null, null_mut};

use ash::vk;
use capi::api::context::{antumbra_context_create, antumbra_context_destroy};
use capi::api::scene::*;
use capi::context::AntumbraContextDesc;
use capi::decisions::camera::{ANTUMBRA_DEPTH_STANDARD, AntumbraCamera};
use capi::decisions::hierarchy::AntumbraAabb;
use capi::error::AntumbraResult::{self, BadArgument, BadPointer, Ok, UnknownHandle, Unsupported};
use capi::executor::device::AntumbraFeatures;
use capi::executor::frame::*;
use capi::executor::queue::AntumbraQueueDesc;
use capi::executor::scene::*;
use capi::executor::target::{AntumbraAttachments, AntumbraImage};
use capi::layout::Versioned;
use gpu::Purpose;
use tests::host_device::Host;
use tests::{Driver, drivers};

use super::{CHost, Change, FORMAT, adopt, adopt_with, camera, end, expect, text};

#[test]
fn a_device_without_a_feature_is_refused_by_its_name() {
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let mut context = null_mut();
    // SAFETY: pointers to values on this stack.
    unsafe { antumbra_context_create(&AntumbraContextDesc::current(), &mut context, null_mut()) };
    let (refused, device, error) =
        adopt(&host, context, null(), |core| core.multi_draw_indirect = vk::FALSE);
    expect(refused, Unsupported, "multiDrawIndirect", &error);
    assert_eq!(device.id, 0);
    // SAFETY: the context is no longer used.
    unsafe { antumbra_context_destroy(context, null_mut()) };
    host.finish();
}

#[test]
fn mistakes_in_a_frame_are_named_and_the_next_frame_is_recorded() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Executor);
        let mut c = CHost::new(&host, null());
        let camera = camera();
        let target = c.target();
        let good =
            AntumbraViewFrame { view: c.view, camera: &camera, target: &target, ..Versioned::INIT };
        let small = AntumbraCamera { width: 8, ..camera };
        let standard = AntumbraCamera { depth: ANTUMBRA_DEPTH_STANDARD, ..camera };
        let mut other_format = target;
        other_format.depth.format = vk::Format::D16_UNORM;
        let mut no_image = target;
        no_image.depth.image = vk::Image::null();
        let foreign = AntumbraView { id: 7 };
        let mut nan = camera;
        nan.clip_from_world[0] = f32::NAN;
        let mut infinite = camera;
        infinite.clip_from_world[15] = f32::INFINITY;
        let not_finite = "camera.clip_from_world: the matrix of the view has an element that is";
        for (view, result, words) in [
            (AntumbraViewFrame { camera: &nan, ..good }, BadArgument, not_finite),
            (AntumbraViewFrame { camera: &infinite, ..good }, BadArgument, not_finite),
            (
                AntumbraViewFrame { camera: &small, ..good },
                BadArgument,
                "desc.views[0].camera and desc.views[0].target have different sizes: 8x64 and 64x64",
            ),
            (
                AntumbraViewFrame { camera: &standard, ..good },
                BadArgument,
                "desc.views[0].camera has another ANTUMBRA_DEPTH_",
            ),
            (
                AntumbraViewFrame { target: &other_format, ..good },
                BadArgument,
                "desc.views[0].target.depth has the format D16_UNORM",
            ),
            (
                AntumbraViewFrame { strategy: 9, ..good },
                BadArgument,
                "desc.views[0]: there is no ANTUMBRA_STRATEGY_.. 9",
            ),
            (
                AntumbraViewFrame { target: &no_image, ..good },
                BadPointer,
                "desc.views[0].target.depth.image is null",
            ),
            (
                AntumbraViewFrame { target: null(), ..good },
                BadPointer,
                "desc.views[0].target is null",
            ),
            (
                AntumbraViewFrame { camera: null(), ..good },
                BadPointer,
                "desc.views[0].camera is null",
            ),
            (
                AntumbraViewFrame { view: foreign, ..good },
                UnknownHandle,
                "desc.views[0].view: there is no view 0x7",
            ),
        ] {
            c.refuse(&[&view], |_| {}, result, words, &good);
        }
        let good_at = from_ref(&good);
        c.refuse(
            &[good_at, good_at],
            |_| {},
            BadArgument,
            "desc.views[1] and desc.views[0] are a view twice",
            &good,
        );
        c.refuse(&[good_at, null()], |_| {}, BadPointer, "desc.views[1] is null", &good);
        let one = [good_at];
        let refusals: [(Change, AntumbraResult, &str); 3] = [
            (&|desc| desc.bind = None, BadPointer, "desc.bind is null"),
            (&|desc| desc.commands = vk::CommandBuffer::null(), BadPointer, "desc.commands"),
            (&|desc| desc.end_rendering = Some(end), BadArgument, "both or none"),
        ];
        for (change, result, words) in refusals {
            c.refuse(&one, change, result, words, &good);
        }
        c.finish();
        host.finish();
    }
}

#[test]
fn more_frames_than_slots_are_refused() {
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let mut c = CHost::new(&host, null());
    assert_eq!(c.record(&[], |frame| frame.safe = 0), Ok);
    assert_eq!(c.record(&[], |frame| frame.safe = 0), Ok);
    let third = c.record(&[], |frame| frame.safe = 0);
    let words = "frame 3 needs the memory of frame 1, which is not over yet, since \
                 AntumbraSceneDesc::frames_in_flight is 2";
    expect(third, BadArgument, words, &c.error);
    assert_eq!(c.record(&[], |_| {}), Ok);
    c.finish();
    host.finish();
}

#[test]
fn a_refused_frame_number_says_which_rule_it_breaks() {
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let mut c = CHost::new(&host, null());
    let camera = camera();
    let target = c.target();
    let good =
        AntumbraViewFrame { view: c.view, camera: &camera, target: &target, ..Versioned::INIT };
    assert_eq!(c.record(&[&good], |_| {}), Ok, "{}", text(&c.error));
    // Each refused frame has an even number, and a good one follows.
    let refusals: [(Change, &str); 4] = [
        (
            &|desc| desc.current = 1,
            "frame 1 cannot begin after frame 1: `AntumbraFrameDesc::current` must rise with each \
             frame that begins on the device, and is 2 or more now",
        ),
        (&|desc| desc.current = 2, "frame 2 cannot begin after frame 3"),
        (
            &|desc| desc.safe = desc.current,
            "frame 6 cannot begin while `AntumbraFrameDesc::safe` is 6: no frame is over before it \
             begins, so `safe` must be below 6",
        ),
        (
            &|desc| desc.safe = 5,
            "frame 8 cannot begin while `AntumbraFrameDesc::safe` is 5: all frames up to 6 were \
             over before, and `safe` must not fall, so it must be 6 or more",
        ),
    ];
    for (change, words) in refusals {
        c.refuse(&[&good], change, BadArgument, words, &good);
    }
    c.finish();
    host.finish();
}

#[test]
fn a_null_struct_of_features_is_not_called_a_lack_of_the_device() {
    type Clear = fn(&mut AntumbraFeatures);
    let core: Clear = |features| features.core = null_mut();
    let vulkan_12: Clear = |features| features.vulkan_12 = null_mut();
    let vulkan_13: Clear = |features| features.vulkan_13 = null_mut();
    for (purpose, clear, words) in [
        (
            Purpose::Executor,
            core,
            "desc.features.core is null, which counts as all features off, and multiDrawIndirect, \
             drawIndirectFirstInstance must be on: pass the VkPhysicalDeviceFeatures that the \
             device was created with",
        ),
        (
            Purpose::Executor,
            vulkan_13,
            "desc.features.vulkan_13 is null, which counts as all features off, and \
             dynamicRendering, synchronization2 must be on: pass the \
             VkPhysicalDeviceVulkan13Features",
        ),
        (
            Purpose::Renderer,
            vulkan_12,
            "desc.features.vulkan_12 is null, which counts as all features off, and \
             timelineSemaphore must be on",
        ),
        // An executor needs no feature of these structs.
        (Purpose::Executor, vulkan_12, ""),
        (Purpose::Executor, |features| features.conditional_rendering = null_mut(), ""),
    ] {
        let host = Host::new(Driver::Lavapipe, purpose);
        let mut context = null_mut();
        let desc = AntumbraContextDesc::current();
        // SAFETY: pointers to values on this stack.
        unsafe { antumbra_context_create(&desc, &mut context, null_mut()) };
        let queue = AntumbraQueueDesc { queue: host.queue, ..Versioned::INIT };
        let mut features = AntumbraFeatures::INIT;
        let (result, _, error) = adopt_with(
            &host,
            context,
            |_| {},
            |desc| {
                // SAFETY: the struct of the caller.
                features = unsafe { *desc.features };
                clear(&mut features);
                desc.features = &raw const features;
                if purpose == Purpose::Renderer {
                    desc.queue = &queue;
                }
            },
        );
        expect(result, if words.is_empty() { Ok } else { BadPointer }, words, &error);
        // SAFETY: the context is no longer used.
        unsafe { antumbra_context_destroy(context, null_mut()) };
        host.finish();
    }
}

#[test]
fn images_of_a_view_are_named_by_their_places() {
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let mut c = CHost::new(&host, null());
    let camera = camera();
    let target = c.target();
    let good =
        AntumbraViewFrame { view: c.view, camera: &camera, target: &target, ..Versioned::INIT };
    let mut none = target;
    none.depth.usage = vk::ImageUsageFlags::empty();
    let mut copied = target;
    copied.depth.usage = vk::ImageUsageFlags::TRANSFER_SRC;
    let mut many = target;
    many.colour_count = 1;
    many.colours = &target.depth;
    let unattached = "without VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT: create the image with \
                      this bit, and name its whole usage in `AntumbraImage::usage`";
    for (target, words) in [
        (&none, "desc.views[0].target: the depth image of a host's target has the usage 0x0"),
        (&none, unattached),
        (&copied, unattached),
        (&many, "desc.views[0].target.colour_count is 1, but the scene was made for 0 colours"),
    ] {
        let view = AntumbraViewFrame { target, ..good };
        c.refuse(&[&view], |_| {}, BadArgument, words, &good);
    }
    c.finish();
    host.finish();
}

#[test]
fn colours_are_named_by_their_places() {
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let mut c = CHost::new(&host, null());
    let colour = vk::Format::R8G8B8A8_UNORM;
    let mut attachments =
        AntumbraAttachments { depth_format: FORMAT, colour_count: 2, ..Versioned::INIT };
    attachments.colour_formats[0] = colour;
    let mut desc =
        AntumbraSceneDesc { device: c.device, attachments: &attachments, ..Versioned::INIT };
    // SAFETY: values on this stack.
    let made = unsafe { antumbra_scene_create(c.context, &desc, &mut c.scene, &mut c.error) };
    expect(made, BadArgument, "colour image 1", &c.error);
    attachments.colour_formats[1] = colour;
    desc.attachments = &attachments;
    // SAFETY: as above.
    unsafe {
        let made = antumbra_scene_create(c.context, &desc, &mut c.scene, &mut c.error);
        assert_eq!(made, Ok, "{}", text(&c.error));
        let made = antumbra_view_create(c.context, c.scene, &mut c.view, &mut c.error);
        assert_eq!(made, Ok, "{}", text(&c.error));
    }
    let camera = camera();
    let plain = c.target();
    let good = AntumbraImage {
        format: colour,
        usage: vk::ImageUsageFlags::COLOR_ATTACHMENT,
        ..plain.depth
    };
    let unused = AntumbraImage { usage: vk::ImageUsageFlags::SAMPLED, ..good };
    let no_image = AntumbraImage { image: vk::Image::null(), ..good };
    let no_view = AntumbraImage { view: vk::ImageView::null(), ..good };
    let mut reserved = good;
    reserved.exit.reserved = 1;
    let place = "desc.views[0].target.colours[1]";
    for (second, result, words) in [
        (AntumbraImage { format: FORMAT, ..good }, BadArgument, "has the format D32_SFLOAT"),
        (no_image, BadPointer, ".image is null"),
        (no_view, BadPointer, ".view is null"),
        (reserved, BadArgument, ".exit.reserved must be 0"),
    ] {
        let mut target = plain;
        let colours = [good, second];
        (target.colour_count, target.colours) = (2, colours.as_ptr());
        let camera = &camera;
        let target = &target;
        let view = AntumbraViewFrame { view: c.view, camera, target, ..Versioned::INIT };
        let refused = c.record(&[&view], |_| {});
        expect(refused, result, words, &c.error);
        expect(refused, result, place, &c.error);
    }
    let mut target = plain;
    let colours = [good, unused];
    (target.colour_count, target.colours) = (2, colours.as_ptr());
    let view =
        AntumbraViewFrame { view: c.view, camera: &camera, target: &target, ..Versioned::INIT };
    let refused = c.record(&[&view], |_| {});
    let words = "colour image 1 of a host's target has the usage 0x4, without \
                 VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT";
    expect(refused, BadArgument, words, &c.error);
    c.finish();
    host.finish();
}

#[test]
fn objects_and_draws_of_a_scene_are_named_by_their_indices() {
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let mut c = CHost::new(&host, null());
    let bounds = AntumbraAabb { min: [0.0; 3], max: [1.0; 3] };
    let bad = AntumbraAabb { min: [2.0; 3], ..bounds };
    let object = AntumbraObject { bounds, first_draw: 0, draw_count: 0 };
    let draw = AntumbraObjectDraw {
        bucket: 0,
        index_count: 3,
        instance_count: 1,
        first_index: 0,
        vertex_offset: 0,
        first_instance: 0,
    };
    let draws = [draw, AntumbraObjectDraw { bucket: 4, ..draw }];
    let x = c.context;
    let s = c.scene;
    let e = &mut c.error;
    let mut ids = [9; 2];
    // SAFETY: pointers to values on this stack.
    unsafe {
        for (second, words) in [
            (AntumbraObject { bounds: bad, ..object }, "objects[1].bounds is no box"),
            (
                AntumbraObject { first_draw: 1, draw_count: 2, ..object },
                "objects[1] has 2 draws from draw 1 on, but draw_count is 2",
            ),
            (
                AntumbraObject { draw_count: 2, ..object },
                "draws[1] names bucket 4, but the scene was created with 1",
            ),
        ] {
            let objects = [object, second];
            let at = objects.as_ptr();
            let ids = ids.as_mut_ptr();
            let added = antumbra_scene_add(x, s, at, 2, draws.as_ptr(), 2, ids, e);
            expect(added, BadArgument, words, e);
        }
        assert_eq!(ids, [9; 2]);
        let changed = antumbra_scene_set_draws(x, s, 0, draws.as_ptr(), 2, e);
        expect(changed, BadArgument, "draws[1] names bucket 4", e);
        let added =
            antumbra_scene_add(x, s, [object; 2].as_ptr(), 2, null(), 0, ids.as_mut_ptr(), e);
        assert_eq!((added, ids), (Ok, [1, 2]), "{}", text(e));

        for (objects, boxes, words) in [
            ([1, 2, 7], [bounds; 3], "objects[2]: object 7 is not"),
            ([1, 1, 1], [bounds, bad, bounds], "objects[1]: object 1 has no usable"),
            ([7, 7, 7], [bounds; 3], "objects[0]: object 7 is not"),
        ] {
            let moved = antumbra_scene_move(x, s, objects.as_ptr(), boxes.as_ptr(), 3, e);
            expect(moved, BadArgument, words, e);
        }
        for (objects, words) in [
            ([1, 7, 7], "objects[1]: object 7 is not"),
            // The first one was removed by the call before.
            ([2, 2, 0], "objects[1]: object 2 is not"),
            ([1, 1, 1], "objects[0]: object 1 is not"),
        ] {
            let removed = antumbra_scene_remove(x, s, objects.as_ptr(), 3, e);
            expect(removed, BadArgument, words, e);
        }
        assert_eq!(antumbra_scene_remove(x, s, &0, 1, e), Ok, "the one after the refused stays");
    }
    c.finish();
    host.finish();
}

#[test]
fn extensions_are_named_by_their_indices() {
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let c = CHost::new(&host, null());
    let names: Vec<*const std::ffi::c_char> = vec![c"VK_KHR_a".as_ptr(), null()];
    let (refused, _, error) = adopt_with(
        &host,
        c.context,
        |_| {},
        |desc| (desc.extensions, desc.extension_count) = (names.as_ptr(), names.len()),
    );
    expect(refused, BadPointer, "desc.extensions[1] is null", &error);
    c.finish();
    host.finish();
}
