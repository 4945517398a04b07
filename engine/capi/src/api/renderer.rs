//! Functions of renderers.

use cull::ObjectId;
use gpu::Purpose;
use render::RendererOptions;
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
use crate::renderer::self_test::AntumbraSelfTest;
use crate::renderer::shadows::{AntumbraShadowDesc, AntumbraShadowStats};

/// Writes what `antumbra_requirements` does, for devices that are adopted with a queue.
///
/// # Safety
/// The rules of the interface; the handles are valid.
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

/// Tests the driver of a device that was adopted with a queue: each assumption that exactness rests
/// on, by small frames of its own. Takes about a second, and waits for the device again and again:
/// for before the first frame.
///
/// # Safety
/// The rules of the interface. The callbacks of the queue do what they say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_self_test(
    context: *const AntumbraContext,
    device: AntumbraDevice,
    outcome: *mut AntumbraSelfTest,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("outcome", outcome)?;
            let device = context.devices.find(device)?.read()?.clone();
            HostedRenderer::check_device(&device)?;
            let found = render::self_test(&device, &RendererOptions::default())?;
            output.write(&AntumbraSelfTest::from(&found));
            Ok(())
        })
    }
}

/// Creates a renderer of a scene, and uploads the scene. What games need besides is in Rust alone:
/// textures, materials, lights beside the sun, transparent, skinned and animated meshes, levels of
/// detail, several views, glTF files.
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
            let scene = desc.scene()?;
            let new = HostedRenderer::new(&device, &scene, &options)?;
            *renderer = context.renderers.insert(new)?;
            Ok(())
        })
    }
}

/// Destroys a renderer. What frames in flight use is freed when they are over: nothing waits. Its
/// image is used no longer. A handle of 0 is no error.
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
/// The rules of the interface. The image of the frame before is in its state again, and its other
/// users are over when the frame executes. The callbacks of the queue do what they say.
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

/// Writes the image of the newest frame. `BAD_ARGUMENT` before the first one.
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

/// Draws images of another size from now on, with what is known of earlier frames. Nothing waits.
/// The image of earlier frames is used no longer.
///
/// # Safety
/// The rules of the interface. Commands of the host that use the image are over.
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

/// Draws shadows by other options from now on; with `method` 0, none. Makes new maps
/// and pipelines: not for every frame. The renderer was created with an `AntumbraShadowDesc`. After
/// an error nothing has changed.
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

/// Adds objects and writes their ids, which may be those of objects that were removed. There must
/// be room: `spare_objects`. After an error nothing was added.
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

/// Adds meshes and writes their ids, which may be those of meshes that were removed. There must be
/// room: `spare_meshes`, `spare_vertices` and `spare_indices`. Objects can have them at once, and
/// are drawn once they are on the GPU: frames copy them bit by bit. After an error nothing was
/// added.
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

/// Removes meshes that no object has. After an error nothing was removed.
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

/// Waits until all frames of the renderer are over. For the end and for measurements, not for a
/// loop. The wait is bounded.
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
