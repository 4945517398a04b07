//! Functions of renderers of a file: its clips and cameras.

use crate::context::{AntumbraContext, entry};
use crate::decisions::camera::AntumbraCamera;
use crate::error::{AntumbraError, AntumbraResult};
use crate::pointers::{Output, slice};
use crate::renderer::frame::AntumbraRenderer;
use crate::renderer::scene_file::ANTUMBRA_ALL_CLIPS;

/// Plays clips of the renderer's file in loops that begin at time 0, in place of those that play.
/// From the time `seconds` on they fade in, for `fade_seconds`; a fade of 0 is a cut. Without clips
/// the scene returns to rest; with a `clip_count` of `ANTUMBRA_ALL_CLIPS` all clips play that can
/// play together: no two that animate the same property of a node. Otherwise the later of two such
/// clips wins. Nothing moves before `antumbra_renderer_advance`.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_play(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    clips: *const u32,
    clip_count: usize,
    seconds: f64,
    fade_seconds: f64,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let clips = match clip_count {
                ANTUMBRA_ALL_CLIPS => None,
                _ => Some(slice("clips", clips, clip_count)?),
            };
            let renderer = context.renderers.find(renderer)?;
            renderer.write()?.playback()?.play(clips, seconds, fade_seconds)
        })
    }
}

/// Moves the scene of the renderer's file to a time of its clips, in any order of times: objects,
/// poses, lights and cameras. The next frame shows it. The cost grows with what moves. Objects of
/// the file that were removed stay away, and clips do not move objects of the host.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_advance(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    seconds: f64,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let renderer = context.renderers.find(renderer)?;
            renderer.write()?.advance(seconds)
        })
    }
}

/// Writes a camera of the renderer's file for its images, at the time of the last
/// `antumbra_renderer_advance`, or the view `ANTUMBRA_CAMERA_OVERVIEW`. In images that are narrower
/// than those of the camera, nothing is cut off at the sides.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_camera(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    index: u32,
    camera: *mut AntumbraCamera,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("camera", camera)?;
            output.write(&context.renderers.find(renderer)?.read()?.camera(index)?);
            Ok(())
        })
    }
}
