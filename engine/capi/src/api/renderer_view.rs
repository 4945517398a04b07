//! Functions of the views of renderers.

use crate::context::{AntumbraContext, entry};
use crate::error::{AntumbraError, AntumbraResult};
use crate::pointers::{Output, check_output};
use crate::renderer::frame::AntumbraRenderer;
use crate::renderer::view::{AntumbraRendererStats, AntumbraRendererView};

/// Creates a view of a renderer, without history, for `AntumbraRenderDesc::view`. Frames of several
/// cameras, such as a mirror and the eye, each have a view: the history of one says little about
/// what another sees. Each frame shows one view, in the renderer's one image.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_view_create(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    view: *mut AntumbraRendererView,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            check_output("view", view)?;
            *view = context.renderers.find(renderer)?.write()?.add_view()?;
            Ok(())
        })
    }
}

/// Destroys a view of a renderer without a wait. An image that shows it stays. A handle of 0 is not
/// an error.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_view_destroy(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    view: AntumbraRendererView,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let renderer = context.renderers.find(renderer)?;
            renderer.write()?.views.destroy(view)
        })
    }
}

/// Writes the counts of the newest frame of a view whose results are known.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_renderer_view_stats(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    view: AntumbraRendererView,
    stats: *mut AntumbraRendererStats,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("stats", stats)?;
            let renderer = context.renderers.find(renderer)?;
            output.write(&renderer.write()?.view_stats(view)?);
            Ok(())
        })
    }
}
