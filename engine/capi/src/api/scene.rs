//! Functions of scenes, their views and frames.

use cull::DrawPhases;

use crate::context::{AntumbraContext, entry};
use crate::decisions::hierarchy::AntumbraAabb;
use crate::error::{AntumbraError, AntumbraResult, Failure};
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
            // Views of different scenes have different handles.
            *scene = context.scenes.insert_with(|handle| {
                new.views = Table::new(std::ptr::from_ref(context) as u64 ^ handle.id);
                new
            })?;
            Ok(())
        })
    }
}

/// Destroys a scene and its views. Resources that frames may still use are freed when these frames
/// are over. A handle of 0 is not an error.
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
/// The time depends on the number of added objects. If they do not fit
/// (`AntumbraSceneDesc::object_capacity`), the scene grows to hold them and a further sixteenth of
/// all objects, and the next frame uploads all objects to larger buffers. If their number reaches
/// the number of existing objects, everything is rebuilt: some seconds per 1,000,000 objects.
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

/// Removes objects. After an error the objects before the one in the message have been removed.
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

/// Moves objects: object `objects[i]` has the box `boxes[i]` from now on. The host itself gives the
/// new transform to its draws. After an error the objects before the one in the message have moved.
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

/// Creates a view of a scene, without a history.
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

/// Destroys a view. A handle of 0 is not an error.
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

/// Writes the draw lists of a view in the newest frame, for a scene with `ANTUMBRA_DRAWS_BY_LISTS`.
/// Before the first frame there are no lists.
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
            if scene.draw_phases != DrawPhases::Two {
                let message = "the scene draws by callbacks: create it with \
                               AntumbraSceneDesc::draws = ANTUMBRA_DRAWS_BY_LISTS";
                return Err(Failure::argument(message));
            }
            let view = scene.views.find(view)?;
            output.write(&view.read()?.lists.described());
            Ok(())
        })
    }
}

/// Records a frame of a scene into a command buffer of the host: changes of the scene, then draws
/// and tests of all views. Never waits, and never submits. If the host draws from lists, only tests
/// are recorded: the images must contain the visible draws when the command buffer executes.
///
/// The host submits each frame once, in the order of the frame numbers. Other orders are allowed,
/// too. A frame that is never submitted has no effect: its answers are ignored. A frame may be
/// submitted twice, unless the scene has `ANTUMBRA_RESUBMISSION_NEVER`: both runs draw correct
/// images if a barrier or a semaphore orders them. A frame may be submitted after a later frame: it
/// then shows changed objects as the later frame left them. After an error the command buffer must
/// not be submitted, and the next frame needs a higher number.
///
/// # Safety
/// The rules of the interface.
///
/// The caller promises: the command buffer belongs to the scene's device and to the queue family of
/// its `AntumbraDeviceDesc`. All frames up to `safe` are over. When the command buffer executes,
/// the images are in their `entry` states, and nothing else uses them until it is over.
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
