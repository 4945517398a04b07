//! Functions of the shadows of renderers.

use scene::LightId;

use crate::context::{AntumbraContext, entry};
use crate::error::{AntumbraError, AntumbraResult};
use crate::pointers::{Output, read};
use crate::renderer::frame::AntumbraRenderer;
use crate::renderer::shadows::{AntumbraLightShadowDesc, AntumbraShadowDesc, AntumbraShadowStats};

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

/// Changes the shadow of one light; `desc` is null for what the options of all lights say. The next
/// frame shows it. The sun of an `AntumbraSunlight` is light 0, unless it is black; the lights of a
/// file are counted from 0. The renderer must have been created with an `AntumbraShadowDesc`, or
/// from a file.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_set_light_shadow(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    light: u32,
    desc: *const AntumbraLightShadowDesc,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let shadow = if desc.is_null() { None } else { Some(read("desc", desc)?.shadow()?) };
            let renderer = context.renderers.find(renderer)?;
            renderer.write()?.set_light_shadow(LightId(light), shadow)
        })
    }
}
