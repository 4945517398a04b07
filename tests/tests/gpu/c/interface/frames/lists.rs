//! A host in C that draws from lists, in its own command buffers: the visible draws before the
//! tests, the revealed draws after them.

use std::ptr::null;
use std::slice::from_raw_parts;

use ash::vk::{self, Handle};
use capi::api::scene::{antumbra_scene_create, antumbra_view_lists};
use capi::error::AntumbraResult;
use capi::executor::lists::{ANTUMBRA_DRAWS_BY_LISTS, AntumbraDrawList, AntumbraDrawLists};
use capi::executor::scene::{AntumbraScene, AntumbraSceneDesc};
use capi::executor::target::AntumbraAttachments;
use capi::layout::Versioned;
use cull::CullView;
use gpu::Purpose;
use occlusion::Rendering;
use tests::Driver;
use tests::host_device::Host;

use super::images::{ViewImages, area};
use super::pipeline::BoxPipeline;
use crate::c::interface::{CHost, FORMAT, expect};

/// Returns the lists of the visible or of the revealed draws.
fn listed(lists: &AntumbraDrawLists, rendering: Rendering) -> &[AntumbraDrawList] {
    let (first, count) = match rendering {
        Rendering::First => (lists.visible, lists.visible_count),
        Rendering::Next => (lists.revealed, lists.revealed_count),
    };
    // SAFETY: arrays of these lengths, until the view is recorded again.
    unsafe { from_raw_parts(first, count) }
}

/// Records one rendering of a view.
pub fn record(
    host: &Host,
    commands: vk::CommandBuffer,
    images: &ViewImages,
    pipeline: &BoxPipeline,
    lists: &AntumbraDrawLists,
    view: &CullView,
    rendering: Rendering,
) {
    let device = &host.device;
    let [width, height] = super::SIZE.map(|pixels| pixels as f32);
    let viewport = vk::Viewport { width, height, max_depth: 1.0, ..Default::default() };
    let stride = size_of::<vk::DrawIndexedIndirectCommand>() as u32;
    images.begin(host, commands, rendering);
    // SAFETY: the rendering that was begun; buffers that live until the frame is over.
    unsafe {
        device.cmd_set_viewport(commands, 0, &[viewport]);
        device.cmd_set_scissor(commands, 0, &[area()]);
        for list in listed(lists, rendering) {
            let AntumbraDrawList { bucket, most, commands: buffer, .. } = *list;
            pipeline.bind(commands, view, bucket);
            let offset = list.commands_offset;
            let count = list.count;
            let at = list.count_offset;
            if count == vk::Buffer::null() {
                device.cmd_draw_indexed_indirect(commands, buffer, offset, most, stride)
            } else {
                device.cmd_draw_indexed_indirect_count(
                    commands, buffer, offset, count, at, most, stride,
                )
            }
        }
    }
    images.end(host, commands);
}

#[test]
fn scenes_that_cannot_hand_out_lists_are_refused_by_name() {
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let mut c = CHost::new(&host, null());
    // Refused before it is read.
    let render_pass = vk::RenderPass::from_raw(1);
    let plain = AntumbraAttachments { depth_format: FORMAT, ..Versioned::INIT };
    let with_pass = AntumbraAttachments { render_pass, ..plain };
    let by_lists = ANTUMBRA_DRAWS_BY_LISTS;
    for (attachments, draws, words) in
        [(&plain, 7, "ANTUMBRA_DRAWS_.. 7"), (&with_pass, by_lists, "render_pass must be null")]
    {
        let desc = AntumbraSceneDesc { device: c.device, attachments, draws, ..Versioned::INIT };
        let mut scene = AntumbraScene { id: 0 };
        // SAFETY: values on this stack.
        let made = unsafe { antumbra_scene_create(c.context, &desc, &mut scene, &mut c.error) };
        expect(made, AntumbraResult::BadArgument, words, &c.error);
    }
    let mut lists = AntumbraDrawLists::INIT;
    // SAFETY: as above.
    let told = unsafe { antumbra_view_lists(c.context, c.scene, c.view, &mut lists, &mut c.error) };
    expect(told, AntumbraResult::BadArgument, "ANTUMBRA_DRAWS_BY_LISTS", &c.error);
    c.finish();
    host.finish();
}
