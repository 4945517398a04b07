//! Functions of scenes, their views and frames.

use crate::context::{AntumbraContext, entry};
use crate::decisions::hierarchy::AntumbraAabb;
use crate::error::{AntumbraError, AntumbraResult};
use crate::executor::frame::{AntumbraFrameDesc, record};
use crate::executor::lists::AntumbraDrawLists;
use crate::executor::scene::{
    AntumbraObject, AntumbraObjectDraw, AntumbraScene, AntumbraSceneDesc, AntumbraView,
    AntumbraViewStats, HostedScene,
};
use crate::pointers::{Output, check_output, output_slice, read, slice};
use crate::table::{Shared, Table};

/// Creates a scene without objects.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_scene_create(
    context: *const AntumbraContext,
    desc: *const AntumbraSceneDesc,
    scene: *mut AntumbraScene,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            check_output("scene", scene)?;
            let desc = read("desc", desc)?;
            let attachments = read("desc.attachments", desc.attachments)?;
            let device = context.devices.find(desc.device)?.read()?.clone();
            let costs = match desc.costs.id {
                0 => None,
                _ => Some(context.costs.find(desc.costs)?),
            };
            let costs = costs.as_ref().map(Shared::read).transpose()?;
            let mut new = HostedScene::new(device, &desc, &attachments, costs.as_deref())?;
            // No view of this scene has the handle of another's.
            *scene = context.scenes.insert_with(|handle| {
                new.views = Table::new(std::ptr::from_ref(context) as u64 ^ handle.id);
                new
            })?;
            Ok(())
        })
    }
}

/// Destroys a scene and its views. What frames may still use is freed when they are over. A handle
/// of 0 is no error.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_scene_destroy(
    context: *const AntumbraContext,
    scene: AntumbraScene,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe { entry(context, error, |context| context.scenes.destroy(scene)) }
}

/// Adds objects and writes their ids, which may be those of objects that were removed. After an
/// error nothing was added.
///
/// The time depends on the number of added objects. Where there is no room for them
/// (`AntumbraSceneDesc::object_capacity`), room for a sixteenth of all objects is made besides, and
/// the next frame uploads all to larger buffers. Where they are as many as the objects that are
/// there, everything is built again: some seconds per 1,000,000.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_scene_add(
    context: *const AntumbraContext,
    scene: AntumbraScene,
    objects: *const AntumbraObject,
    count: usize,
    draws: *const AntumbraObjectDraw,
    draw_count: usize,
    ids: *mut u32,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let objects = slice("objects", objects, count)?;
            let draws = slice("draws", draws, draw_count)?;
            let ids = output_slice("ids", ids, count)?;
            let scene = context.scenes.find(scene)?;
            let mut scene = scene.write()?;
            for (id, added) in ids.iter_mut().zip(scene.add(objects, draws)?) {
                id.write(added.0);
            }
            Ok(())
        })
    }
}

/// Removes objects. After an error those before the one that the message names were removed.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_scene_remove(
    context: *const AntumbraContext,
    scene: AntumbraScene,
    objects: *const u32,
    count: usize,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let objects = slice("objects", objects, count)?;
            context.scenes.find(scene)?.write()?.remove(objects)
        })
    }
}

/// Moves objects: object `objects[i]` has the box `boxes[i]` from now on. Where draws read its new
/// place is the concern of the host. After an error those before the one that the message names
/// have moved.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_scene_move(
    context: *const AntumbraContext,
    scene: AntumbraScene,
    objects: *const u32,
    boxes: *const AntumbraAabb,
    count: usize,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let objects = slice("objects", objects, count)?;
            let boxes = slice("boxes", boxes, count)?;
            context.scenes.find(scene)?.write()?.move_to(objects, boxes)
        })
    }
}

/// Replaces the draws of an object.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_scene_set_draws(
    context: *const AntumbraContext,
    scene: AntumbraScene,
    object: u32,
    draws: *const AntumbraObjectDraw,
    draw_count: usize,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let draws = slice("draws", draws, draw_count)?;
            context.scenes.find(scene)?.write()?.set_draws(object, draws)
        })
    }
}

/// Creates a view of a scene, which knows nothing yet.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_view_create(
    context: *const AntumbraContext,
    scene: AntumbraScene,
    view: *mut AntumbraView,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            check_output("view", view)?;
            *view = context.scenes.find(scene)?.write()?.add_view()?;
            Ok(())
        })
    }
}

/// Destroys a view. A handle of 0 is no error.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_view_destroy(
    context: *const AntumbraContext,
    scene: AntumbraScene,
    view: AntumbraView,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| context.scenes.find(scene)?.write()?.views.destroy(view))
    }
}

/// Writes the counts of the newest frame of a view whose results are known.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_view_stats(
    context: *const AntumbraContext,
    scene: AntumbraScene,
    view: AntumbraView,
    stats: *mut AntumbraViewStats,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("stats", stats)?;
            let scene = context.scenes.find(scene)?;
            let scene = scene.write()?;
            let view = scene.views.find(view)?;
            output.write(&view.write()?.stats());
            Ok(())
        })
    }
}

/// Writes where the draws of a view in the newest frame are, for a scene with
/// `ANTUMBRA_DRAWS_BY_LISTS`. There are none before the first frame.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_view_lists(
    context: *const AntumbraContext,
    scene: AntumbraScene,
    view: AntumbraView,
    lists: *mut AntumbraDrawLists,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("lists", lists)?;
            let scene = context.scenes.find(scene)?;
            let scene = scene.read()?;
            let view = scene.views.find(view)?;
            output.write(&view.read()?.lists.described());
            Ok(())
        })
    }
}

/// Records a frame of a scene into a command buffer of the host: changes of the scene, then draws
/// and tests of all views. Never waits, and never submits. Where the host draws from lists, tests
/// alone: each image is entered with the visible draws in it.
///
/// The host submits frames in the order of their numbers, each of them once. What else it may do:
/// never submit a frame, which changes nothing: its answers are ignored. Submit one twice, the
/// second run behind the first by a barrier or a semaphore, unless the scene has
/// `ANTUMBRA_RESUBMISSION_NEVER`: both draw right images. Submit one behind a later one, which
/// shows changed objects as the later frame left them. After an error the command buffer must not
/// be submitted, and the next frame needs a higher number.
///
/// # Safety
/// The rules of the interface. The command buffer is of the scene's device, for the queue family
/// that was named; all frames up to `safe` are over. When it executes, the images are in the states
/// that were named, and nothing else uses them until it is over.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_scene_record(
    context: *const AntumbraContext,
    scene: AntumbraScene,
    desc: *const AntumbraFrameDesc,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let desc = read("desc", desc)?;
            record(&mut *context.scenes.find(scene)?.write()?, &desc)
        })
    }
}
