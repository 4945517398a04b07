//! Functions of files of scenes.

use crate::context::{AntumbraContext, entry};
use crate::error::{AntumbraError, AntumbraResult};
use crate::pointers::{Output, check_output, read};
use crate::renderer::loaded_file::load;
use crate::renderer::scene_file::{
    AntumbraSceneFile, AntumbraSceneFileCamera, AntumbraSceneFileClip, AntumbraSceneFileDesc,
    AntumbraSceneFileInfo, AntumbraSceneFileNote,
};

/// Loads a file of a scene, for `AntumbraRendererDesc::scene_file`: glTF 2.0, .stl or .obj. The
/// file may contain anything: everything is checked, and what is demanded is bounded. The result
/// `ANTUMBRA_RESULT_BAD_FILE` comes with the file, the object in it, and the reason. Notes are also
/// warnings in the log. May take seconds; other threads may use the context.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_scene_file_load(
    context: *const AntumbraContext,
    desc: *const AntumbraSceneFileDesc,
    file: *mut AntumbraSceneFile,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            check_output("file", file)?;
            let desc = read("desc", desc)?;
            *file = context.scene_files.insert(load(&desc)?)?;
            Ok(())
        })
    }
}

/// Destroys a file. Renderers of it stay as they are. A handle of 0 is not an error.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_scene_file_destroy(
    context: *const AntumbraContext,
    file: AntumbraSceneFile,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe { entry(context, error, |context| context.scene_files.destroy(file)) }
}

/// Writes the contents of a file.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_scene_file_info(
    context: *const AntumbraContext,
    file: AntumbraSceneFile,
    info: *mut AntumbraSceneFileInfo,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("info", info)?;
            output.write(context.scene_files.find(file)?.read()?.info());
            Ok(())
        })
    }
}

/// Writes a camera of a file, from 0 to `AntumbraSceneFileInfo::cameras` - 1. Where it is and what
/// it sees depends on the playing clips: `antumbra_renderer_camera`.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_scene_file_camera(
    context: *const AntumbraContext,
    file: AntumbraSceneFile,
    index: u32,
    camera: *mut AntumbraSceneFileCamera,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("camera", camera)?;
            output.write(&context.scene_files.find(file)?.read()?.camera(index)?);
            Ok(())
        })
    }
}

/// Writes a clip of a file, from 0 to `AntumbraSceneFileInfo::clips` - 1.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_scene_file_clip(
    context: *const AntumbraContext,
    file: AntumbraSceneFile,
    index: u32,
    clip: *mut AntumbraSceneFileClip,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("clip", clip)?;
            output.write(&context.scene_files.find(file)?.read()?.clip(index)?);
            Ok(())
        })
    }
}

/// Writes a note about a file, from 0 to `AntumbraSceneFileInfo::notes` - 1.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_scene_file_note(
    context: *const AntumbraContext,
    file: AntumbraSceneFile,
    index: u32,
    note: *mut AntumbraSceneFileNote,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("note", note)?;
            output.write(&context.scene_files.find(file)?.read()?.note(index)?);
            Ok(())
        })
    }
}
