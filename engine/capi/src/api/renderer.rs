//! Functions of renderers.

use std::sync::Arc;

use cull::ObjectId;
use gpu::Purpose;
use scene::{MeshId, Object, ObjectChange};

use crate::api::device::write_needs;
use crate::context::{AntumbraContext, entry};
use crate::error::{AntumbraError, AntumbraResult};
use crate::executor::device::{
    AntumbraAdapterDesc, AntumbraDevice, AntumbraFeatures, AntumbraRequirements,
};
use crate::pointers::{Output, check_output, output_slice, read, slice};
use crate::renderer::description::{
    AntumbraMeshDesc, AntumbraMeshObject, AntumbraRendererDesc, AntumbraTransform, added,
};
use crate::renderer::frame::{
    AntumbraFinishedImage, AntumbraRenderDesc, AntumbraRenderer, AntumbraRendererStats,
    HostedRenderer,
};
use crate::renderer::shadows::{AntumbraShadowDesc, AntumbraShadowStats};

/// Writes the requirements of the renderer, as `antumbra_requirements` does for the executor. For a
/// device that will be adopted with a queue.
///
/// # Safety
/// The rules of the interface.
///
/// The caller promises that the handles are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_requirements(
    context: *const AntumbraContext,
    adapter: *const AntumbraAdapterDesc,
    features: *const AntumbraFeatures,
    requirements: *mut AntumbraRequirements,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |_| write_needs(adapter, features, requirements, Purpose::Renderer))
    }
}

/// Creates a renderer of a scene, and uploads the scene. Only the Rust interface has textures,
/// materials, lights besides the sun, transparent, skinned and animated meshes, levels of detail,
/// several views, and glTF files.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_create(
    context: *const AntumbraContext,
    desc: *const AntumbraRendererDesc,
    renderer: *mut AntumbraRenderer,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            check_output("renderer", renderer)?;
            let desc = read("desc", desc)?;
            let device = context.devices.find(desc.device)?.read()?.clone();
            HostedRenderer::check_device(&device)?;
            let options = desc.options()?;
            let keeps_scene = desc.keeps_scene()?;
            let scene = desc.scene()?;
            let mut new = HostedRenderer::new(&device, &scene, &options)?;
            if keeps_scene {
                new.renderer.keep_scene(Arc::new(scene))?;
            }
            *renderer = context.renderers.insert(new)?;
            Ok(())
        })
    }
}

/// Continues on another device, which was adopted with a queue, after a call on the present one
/// returned `ANTUMBRA_RESULT_DEVICE_LOST`. The renderer must have been created with `keeps_scene`.
/// It has the same scene, ids and options as before, and begins without history; its size may
/// change later. Takes as long as `antumbra_renderer_create`. The log has the frames that the lost
/// device did not finish, with the labels of their passes. After an error nothing has changed, and
/// the call can be repeated. Release the lost device afterwards.
///
/// # Safety
/// The rules of the interface.
///
/// The caller promises that the host no longer uses the image of an earlier frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_recover(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    device: AntumbraDevice,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let device = context.devices.find(device)?.read()?.clone();
            HostedRenderer::check_device(&device)?;
            context.renderers.find(renderer)?.write()?.recover(&device)
        })
    }
}

/// Destroys a renderer without a wait: resources of frames in flight are freed when these frames
/// are over. The host must not use the renderer's image any more. A handle of 0 is not an error.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_destroy(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe { entry(context, error, |context| context.renderers.destroy(renderer)) }
}

/// Renders a frame and submits it. Waits for the frame that used its memory `frames_in_flight`
/// frames ago, and for nothing else.
///
/// # Safety
/// The rules of the interface.
///
/// The caller promises: when the frame executes, the image of the previous frame is in its `state`
/// again, and its other users are over. The callbacks of the queue do what `AntumbraQueueDesc`
/// says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_render(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    desc: *const AntumbraRenderDesc,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let desc = read("desc", desc)?;
            let camera = read("desc.camera", desc.camera)?;
            context.renderers.find(renderer)?.write()?.render(&desc, &camera)
        })
    }
}

/// Writes the image of the newest frame. Before the first frame the result is
/// `ANTUMBRA_RESULT_BAD_ARGUMENT`.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_image(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    image: *mut AntumbraFinishedImage,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("image", image)?;
            let finished = context.renderers.find(renderer)?.write()?.renderer.finished_image()?;
            output.write(&finished.into());
            Ok(())
        })
    }
}

/// Changes the size of the images without a wait, and keeps the history of earlier frames. The host
/// must not use the image of an earlier frame any more.
///
/// # Safety
/// The rules of the interface.
///
/// The caller promises that the host's commands that use the image are over.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_resize(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    width: u32,
    height: u32,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let renderer = context.renderers.find(renderer)?;
            let mut renderer = renderer.write()?;
            Ok(renderer.renderer.resize([width, height])?)
        })
    }
}

/// Changes the options of shadows; a `method` of 0 turns shadows off. Creates new maps and
/// pipelines, so it is not meant for every frame. The renderer must have been created with an
/// `AntumbraShadowDesc`. After an error nothing has changed.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_set_shadows(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    desc: *const AntumbraShadowDesc,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let desc = read("desc", desc)?;
            let renderer = context.renderers.find(renderer)?;
            renderer.write()?.set_shadows(desc.options()?)
        })
    }
}

/// Writes the counts of the shadows of the newest frame.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_shadow_stats(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    stats: *mut AntumbraShadowStats,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("stats", stats)?;
            let renderer = context.renderers.find(renderer)?;
            output.write(&renderer.read()?.renderer.shadow_stats().into());
            Ok(())
        })
    }
}

/// Adds objects and writes their ids, which may be those of objects that were removed.
/// `AntumbraRendererDesc::spare_objects` must leave room for them. After an error nothing was
/// added.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_add_objects(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    objects: *const AntumbraMeshObject,
    count: usize,
    ids: *mut u32,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let objects = slice("objects", objects, count)?.iter().map(Object::from);
            let ids = output_slice("ids", ids, count)?;
            let changes: Vec<_> = objects.map(|object| ObjectChange::Add { object }).collect();
            let renderer = context.renderers.find(renderer)?;
            let report = renderer.write()?.renderer.update(&changes)?;
            for (id, added) in ids.iter_mut().zip(report.added) {
                id.write(added.0);
            }
            Ok(())
        })
    }
}

/// Removes objects. After an error nothing was removed.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_remove_objects(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    objects: *const u32,
    count: usize,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let objects = slice("objects", objects, count)?.iter().map(|id| ObjectId(*id));
            let changes: Vec<_> = objects.map(|object| ObjectChange::Remove { object }).collect();
            context.renderers.find(renderer)?.write()?.renderer.update(&changes)?;
            Ok(())
        })
    }
}

/// Moves objects: object `objects[i]` has the transform `transforms[i]` from the next frame on.
/// After an error nothing has moved.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_move_objects(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    objects: *const u32,
    transforms: *const AntumbraTransform,
    count: usize,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let objects = slice("objects", objects, count)?.iter().map(|id| ObjectId(*id));
            let transforms = slice("transforms", transforms, count)?.iter().map(Into::into);
            let moves = objects.zip(transforms);
            let changes: Vec<_> =
                moves.map(|(object, transform)| ObjectChange::Move { object, transform }).collect();
            context.renderers.find(renderer)?.write()?.renderer.update(&changes)?;
            Ok(())
        })
    }
}

/// Adds meshes and writes their ids, which may be those of meshes that were removed.
/// `spare_meshes`, `spare_vertices` and `spare_indices` of the `AntumbraRendererDesc` must leave
/// room for them. Objects can use the meshes immediately, and are drawn when the meshes are on the
/// GPU: each frame copies a part. After an error nothing was added.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_add_meshes(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    meshes: *const *const AntumbraMeshDesc,
    count: usize,
    ids: *mut u32,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let ids = output_slice("ids", ids, count)?;
            let meshes = added(meshes, count)?;
            let renderer = context.renderers.find(renderer)?;
            let added = renderer.write()?.add_meshes(meshes)?;
            for (id, added) in ids.iter_mut().zip(added) {
                id.write(added.0);
            }
            Ok(())
        })
    }
}

/// Removes meshes that no object uses. After an error nothing was removed.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_remove_meshes(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    meshes: *const u32,
    count: usize,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let meshes = slice("meshes", meshes, count)?;
            let meshes: Vec<_> = meshes.iter().map(|id| MeshId(*id)).collect();
            let renderer = context.renderers.find(renderer)?;
            let mut renderer = renderer.write()?;
            Ok(renderer.renderer.remove_meshes(&meshes)?)
        })
    }
}

/// Writes the counts of the newest frame whose results are known.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_stats(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    stats: *mut AntumbraRendererStats,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("stats", stats)?;
            output.write(&context.renderers.find(renderer)?.write()?.stats());
            Ok(())
        })
    }
}

/// Waits until all frames of the renderer are over; the wait is bounded. Meant for measurements and
/// for the end of the program, not for each frame.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_wait(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe { entry(context, error, |context| context.renderers.find(renderer)?.write()?.wait()) }
}
