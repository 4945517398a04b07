//! Functions of the executor with invalid handles, which are refused without Vulkan.

use std::ptr::{null, null_mut};

use antumbra_capi::api::device::*;
use antumbra_capi::api::scene::*;
use antumbra_capi::context::AntumbraContext;
use antumbra_capi::error::AntumbraResult::{self, BadPointer, Ok, UnknownHandle};
use antumbra_capi::executor::device::*;
use antumbra_capi::executor::frame::AntumbraFrameDesc;
use antumbra_capi::executor::lists::AntumbraDrawLists;
use antumbra_capi::executor::scene::*;
use antumbra_capi::executor::target::AntumbraAttachments;
use antumbra_capi::layout::Versioned;

use gpu::ash::vk::Handle;
use gpu::vk;

use crate::Host;

type Call<'a> = (&'a str, &'a dyn Fn(*const AntumbraContext, u64) -> AntumbraResult);

#[test]
fn every_function_of_the_executor_checks_its_handles() {
    let host = Host::new();
    let s = |id| AntumbraScene { id };
    let d = |id| AntumbraDevice { id };
    let v = AntumbraView { id: 1 };
    let e = null_mut;
    let attachments =
        AntumbraAttachments { depth_format: vk::Format::D32_SFLOAT, ..Versioned::INIT };
    let frame = AntumbraFrameDesc {
        current: 1,
        commands: vk::CommandBuffer::from_raw(8),
        ..Versioned::INIT
    };
    // SAFETY: of all closures: pointers to values that live as long as the call, or null.
    let calls: [Call; 13] = unsafe {
        [
            ("device_finished", &|x, id| antumbra_device_finished(x, d(id), e())),
            ("device_destroy", &|x, id| antumbra_device_destroy(x, d(id), e())),
            ("scene_create", &|x, id| {
                let attachments = &attachments;
                let desc = AntumbraSceneDesc { device: d(id), attachments, ..Versioned::INIT };
                antumbra_scene_create(x, &desc, &mut s(0), e())
            }),
            ("scene_destroy", &|x, id| antumbra_scene_destroy(x, s(id), e())),
            ("scene_add", &|x, id| {
                antumbra_scene_add(x, s(id), null(), 0, null(), 0, null_mut(), e())
            }),
            ("scene_remove", &|x, id| antumbra_scene_remove(x, s(id), null(), 0, e())),
            ("scene_move", &|x, id| antumbra_scene_move(x, s(id), null(), null(), 0, e())),
            ("scene_set_draws", &|x, id| antumbra_scene_set_draws(x, s(id), 0, null(), 0, e())),
            ("view_create", &|x, id| {
                antumbra_view_create(x, s(id), &mut AntumbraView { id: 0 }, e())
            }),
            ("view_destroy", &|x, id| antumbra_view_destroy(x, s(id), v, e())),
            ("view_stats", &|x, id| {
                let mut stats = AntumbraViewStats::INIT;
                antumbra_view_stats(x, s(id), v, &mut stats, e())
            }),
            ("view_lists", &|x, id| {
                let mut lists = AntumbraDrawLists::INIT;
                antumbra_view_lists(x, s(id), v, &mut lists, e())
            }),
            ("scene_record", &|x, id| antumbra_scene_record(x, s(id), &frame, e())),
        ]
    };
    for (name, call) in calls {
        assert_eq!(call(null(), 5), BadPointer, "{name}");
        for id in [5, u64::MAX, host.hierarchy.id, host.culler.id] {
            assert_eq!(call(host.context, id), UnknownHandle, "{name} {id:#x}");
        }
        let is_gone = matches!(name, "device_destroy" | "scene_destroy");
        let nothing = if is_gone { Ok } else { UnknownHandle };
        assert_eq!(call(host.context, 0), nothing, "{name}");
    }
    // SAFETY: null is refused.
    unsafe {
        let x = host.context;
        let results = [
            antumbra_requirements(x, null(), null(), null_mut(), e()),
            antumbra_device_adopt(x, null(), null_mut(), e()),
            antumbra_device_adopt(x, &Versioned::INIT, &mut d(0), e()),
            antumbra_scene_create(x, null(), &mut s(0), e()),
            antumbra_scene_create(x, &Versioned::INIT, &mut s(0), e()),
            antumbra_scene_record(x, s(0), null(), e()),
            antumbra_view_create(x, s(0), null_mut(), e()),
            antumbra_view_stats(x, s(0), v, null_mut(), e()),
            antumbra_view_lists(x, s(0), v, null_mut(), e()),
        ];
        assert_eq!(results, [BadPointer; 9]);
    }
}
