//! Functions of renderers.

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
    AntumbraFinishedImage, AntumbraRenderDesc, AntumbraRenderer, HostedRenderer,
};
use crate::renderer::scene_begin::SceneBegin;
use crate::renderer::view::AntumbraRendererStats;
use crate::table::Table;

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

/// Creates a renderer of a scene, and uploads the scene: meshes with vertex colours and a sun, or
/// the scene of a file, at rest, with its materials, textures, lights, and transparent, skinned and
/// animated meshes. Meshes of the host have no materials, and levels of detail exist in the Rust
/// interface only.
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
            let keeping = desc.keeping()?;
            let begin = SceneBegin::of(&desc, |file| context.scene_of(file))?;
            let mut new = HostedRenderer::new(&device, begin, &options, keeping)?;
            // Views of different renderers have different handles.
            *renderer = context.renderers.insert_with(|handle| {
                new.views = Table::new(std::ptr::from_ref(context) as u64 ^ handle.id);
                new
            })?;
            Ok(())
        })
    }
}

/// Continues on another device, which was adopted with a queue or opened, after a call on the
/// present one returned `ANTUMBRA_RESULT_DEVICE_LOST`. The renderer must have been created with
/// `keeps_scene`. It has the same scene, ids, options and playing clips as before, and its views
/// begin without history; its size may change later. Takes as long as `antumbra_renderer_create`.
/// The log has the frames that the lost device did not finish, with the labels of their passes.
/// After an error nothing has changed, and the call can be repeated. Release the lost device
/// afterwards.
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

/// Waits until all frames are over, and writes the newest image: four bytes per pixel, sRGB red,
/// green, blue and alpha, in rows from the top. `byte_count` is four times width times height. The
/// wait is bounded. Submits a copy, so the image must be in its `state`. Meant for tests, and for
/// images that are written to files, not for each frame.
///
/// # Safety
/// The rules of the interface.
///
/// The caller promises what `antumbra_renderer_render` says about the image of the previous frame
/// and about the callbacks of the queue.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_read_image(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    rgba: *mut u8,
    byte_count: usize,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let rgba = output_slice("rgba", rgba, byte_count)?;
            context.renderers.find(renderer)?.write()?.read_image(rgba)
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
            let objects = slice("objects", objects, count)?;
            let objects: Vec<_> = objects.iter().map(|id| ObjectId(*id)).collect();
            context.renderers.find(renderer)?.write()?.remove_objects(&objects)
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

/// Writes the counts of the newest frame of the renderer's own view whose results are known.
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
