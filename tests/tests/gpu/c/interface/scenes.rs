//! Impossible scenes, and views of other scenes.

use std::ptr::null;

use ash::vk;
use capi::api::scene::*;
use capi::error::AntumbraResult::{self, BadArgument, NoMemory, Ok, UnknownHandle};
use capi::executor::frame::AntumbraViewFrame;
use capi::executor::scene::{AntumbraScene, AntumbraSceneDesc, AntumbraView};
use capi::executor::target::AntumbraAttachments;
use capi::layout::Versioned;
use gpu::Purpose;
use tests::Driver;
use tests::host_device::Host;

use super::{CHost, FORMAT, camera, expect};

const PLAIN: AntumbraAttachments =
    AntumbraAttachments { depth_format: FORMAT, ..AntumbraAttachments::INIT };

impl CHost<'_> {
    fn create(
        &mut self,
        attachments: &AntumbraAttachments,
        change: impl FnOnce(&mut AntumbraSceneDesc),
    ) -> (AntumbraResult, AntumbraScene) {
        let mut desc = AntumbraSceneDesc { device: self.device, attachments, ..Versioned::INIT };
        change(&mut desc);
        let mut scene = AntumbraScene { id: 0 };
        // SAFETY: values on this stack.
        let made =
            unsafe { antumbra_scene_create(self.context, &desc, &mut scene, &mut self.error) };
        (made, scene)
    }
}

#[test]
fn scenes_that_cannot_be_are_refused_by_name() {
    type Change = fn(&mut AntumbraSceneDesc);
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let mut c = CHost::new(&host, null());
    let changes: [(Change, AntumbraResult, &str); 5] = [
        (|desc| desc.object_capacity = u32::MAX, BadArgument, "more than one hierarchy holds"),
        (|desc| desc.object_capacity = 1 << 30, NoMemory, "no memory to cull"),
        (|desc| desc.bucket_count = u32::MAX, BadArgument, "buckets are more"),
        (|desc| desc.draw_capacity = u32::MAX, BadArgument, "the bytes of all draws"),
        (|desc| desc.frames_in_flight = u32::MAX, BadArgument, "frames in flight"),
    ];
    for (change, result, words) in changes {
        let (refused, _) = c.create(&PLAIN, change);
        expect(refused, result, words, &c.error);
    }
    let samples = vk::SampleCountFlags::from_raw;
    for (attachments, words) in [
        (AntumbraAttachments { samples: samples(64), ..PLAIN }, "samples per pixel"),
        (AntumbraAttachments { samples: samples(3), ..PLAIN }, "samples per pixel"),
        (
            AntumbraAttachments { depth_format: vk::Format::R8G8B8A8_UNORM, ..PLAIN },
            "R8G8B8A8_UNORM",
        ),
        (AntumbraAttachments { subpass: 77, ..PLAIN }, "attachments.subpass"),
    ] {
        let (refused, _) = c.create(&attachments, |_| {});
        expect(refused, BadArgument, words, &c.error);
    }
    c.finish();
    host.finish();
}

#[test]
fn a_view_of_another_scene_is_unknown() {
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let mut c = CHost::new(&host, null());
    let (made, other) = c.create(&PLAIN, |_| {});
    assert_eq!(made, Ok);
    let mut foreign = AntumbraView { id: 0 };
    // SAFETY: values on this stack.
    let made = unsafe { antumbra_view_create(c.context, other, &mut foreign, &mut c.error) };
    assert_eq!(made, Ok);
    assert_ne!(foreign, c.view);
    // SAFETY: as above.
    let gone = unsafe { antumbra_view_destroy(c.context, c.scene, foreign, &mut c.error) };
    expect(gone, UnknownHandle, "another context, scene or renderer", &c.error);
    let camera = camera();
    let target = c.target();
    let good =
        AntumbraViewFrame { view: c.view, camera: &camera, target: &target, ..Versioned::INIT };
    let view = AntumbraViewFrame { view: foreign, ..good };
    c.refuse(&[&view], |_| {}, UnknownHandle, "no view", &good);
    c.finish();
    host.finish();
}
