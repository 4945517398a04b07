//! A host in C that records its frames itself, with our culling in between, by the C interface.

use std::ffi::c_void;
use std::ptr::null;

use capi::api::device::antumbra_device_finished;
use capi::api::scene::{
    antumbra_scene_add, antumbra_scene_create, antumbra_scene_record, antumbra_view_create,
    antumbra_view_stats,
};
use capi::decisions::camera::AntumbraCamera;
use capi::decisions::hierarchy::AntumbraAabb;
use capi::executor::device::AntumbraDevice;
use capi::executor::frame::{AntumbraBinding, AntumbraFrameDesc, AntumbraViewFrame};
use capi::executor::scene::{
    AntumbraObject, AntumbraScene, AntumbraSceneDesc, AntumbraView, AntumbraViewStats,
};
use capi::executor::target::{
    AntumbraAttachments, AntumbraImage, AntumbraImageState, AntumbraTargetDesc,
};
use capi::layout::Versioned;
use cull::CullView;
use gpu::{Purpose, vk};
use tests::every_call;
use tests::host_commands::Runs;
use tests::host_device::Host;
use tests::host_images::OwnImage;
use tests::host_walk::{boxes, camera};

use super::adopted_in_c::{Context, adopt};
use super::executor::{COLOUR, DEPTH, Own};
use super::{Outcome, Program, SIZE, Stage};

/// Binds nothing: the objects have no draws.
unsafe extern "C" fn bind_nothing(_user: *mut c_void, _binding: *const AntumbraBinding) {}

/// The handles of a scene.
#[derive(Clone, Copy)]
struct Shown {
    scene: AntumbraScene,
    view: AntumbraView,
}

impl Program {
    /// Draws in command buffers of a host in C. Returns the last image, with
    /// the numbers of objects and tests of the last frames: the objects have no draws of their own.
    pub(super) fn execute_in_c(&self, stage: &Stage) -> Outcome {
        let host = Host::new(stage.driver, Purpose::Executor);
        let mut own = Own::new(&host);
        every_call::watch(host.device.handle());
        let mut context = Context::new();
        let outcome = own.draw_with(&mut context);
        host.wait_idle();
        let gone = context.destroy();
        let outcome = outcome.and_then(|image| gone.map(|()| image));
        own.destroy();
        every_call::forget_devices();
        host.finish();
        Ok(outcome?)
    }
}

impl Own<'_> {
    fn draw_with(&mut self, context: &mut Context) -> Result<Vec<u8>, String> {
        let device = adopt(self.host, context, null())?;
        let outcome = self.draw_frames(context, device);
        self.host.wait_idle();
        // SAFETY: the wait before.
        let finished = unsafe { antumbra_device_finished(context.raw, device, &mut context.error) };
        let image = outcome?;
        context.check(finished)?;
        Ok(image)
    }

    fn draw_frames(
        &mut self,
        context: &mut Context,
        device: AntumbraDevice,
    ) -> Result<Vec<u8>, String> {
        let shown = create(context, device)?;
        for number in 0..4 {
            let recorded = self.draw_frame(context, shown, number);
            let runs = if recorded.is_ok() { Runs::Once } else { Runs::Never };
            self.commands.end(runs).map_err(|code| format!("{code:?}"))?;
            recorded?;
            // So that each frame knows the results of the one before.
            self.host.wait_idle();
        }
        let mut stats = AntumbraViewStats::INIT;
        let Shown { scene, view } = shown;
        let error = &mut context.error;
        // SAFETY: pointers to values on this stack.
        let found = unsafe { antumbra_view_stats(context.raw, scene, view, &mut stats, error) };
        context.check(found)?;
        let mut image = self.copy.bytes(self.host);
        image.extend([stats.objects, stats.tests].map(|count| count as u8 + 1));
        image.extend([0; 2]);
        Ok(image)
    }

    fn draw_frame(
        &mut self,
        context: &mut Context,
        shown: Shown,
        number: u64,
    ) -> Result<(), String> {
        let begun = self.commands.begin();
        let view = CullView::new(&camera(number), SIZE, 8);
        let [width, height] = SIZE;
        let clip_from_world = view.view_proj.to_cols_array();
        let camera = AntumbraCamera { clip_from_world, width, height, ..Versioned::INIT };
        let colour = described(&self.colour, vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
        let target = AntumbraTargetDesc {
            depth: described(&self.depth, vk::ImageLayout::UNDEFINED),
            width,
            height,
            colours: &colour,
            colour_count: 1,
            ..Versioned::INIT
        };
        let Shown { scene, view } = shown;
        let view = AntumbraViewFrame { view, camera: &camera, target: &target, ..Versioned::INIT };
        let views: *const AntumbraViewFrame = &view;
        let desc = AntumbraFrameDesc {
            view_count: 1,
            views: &views,
            commands: begun.0,
            current: begun.1.current.0,
            safe: begun.1.safe.0,
            bind: Some(bind_nothing),
            ..Versioned::INIT
        };
        // SAFETY: pointers to values on this stack; the command buffer is being recorded.
        let recorded =
            unsafe { antumbra_scene_record(context.raw, scene, &desc, &mut context.error) };
        context.check(recorded)?;
        self.colour.record_copy(self.host, begun.0, None, &self.copy);
        Ok(())
    }
}

/// Creates a scene of boxes without draws.
fn create(context: &mut Context, device: AntumbraDevice) -> Result<Shown, String> {
    let mut attachments =
        AntumbraAttachments { depth_format: DEPTH, colour_count: 1, ..Versioned::INIT };
    attachments.colour_formats[0] = COLOUR;
    let desc = AntumbraSceneDesc { device, attachments: &attachments, ..Versioned::INIT };
    let mut scene = AntumbraScene { id: 0 };
    // SAFETY: here and below: pointers to values on this stack.
    let made = unsafe { antumbra_scene_create(context.raw, &desc, &mut scene, &mut context.error) };
    context.check(made)?;
    let mut view = AntumbraView { id: 0 };
    // SAFETY: as above.
    let made = unsafe { antumbra_view_create(context.raw, scene, &mut view, &mut context.error) };
    context.check(made)?;
    let object = |bounds: &cull::Aabb| AntumbraObject {
        bounds: AntumbraAabb { min: bounds.min.to_array(), max: bounds.max.to_array() },
        first_draw: 0,
        draw_count: 0,
    };
    let objects: Vec<AntumbraObject> = boxes()[..200].iter().map(object).collect();
    let mut ids = vec![0; objects.len()];
    let count = objects.len();
    let error = &mut context.error;
    // SAFETY: as above.
    let added = unsafe {
        antumbra_scene_add(
            context.raw,
            scene,
            objects.as_ptr(),
            count,
            null(),
            0,
            ids.as_mut_ptr(),
            error,
        )
    };
    context.check(added)?;
    Ok(Shown { scene, view })
}

fn described(own: &OwnImage, exit: vk::ImageLayout) -> AntumbraImage {
    let state = |layout| AntumbraImageState {
        layout,
        reserved: 0,
        stages: vk::PipelineStageFlags2::ALL_COMMANDS,
        access: vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE,
    };
    AntumbraImage {
        image: own.image,
        view: own.view,
        format: own.format,
        usage: own.usage,
        entry: state(vk::ImageLayout::UNDEFINED),
        exit: state(exit),
    }
}
