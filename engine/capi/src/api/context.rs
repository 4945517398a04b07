//! Functions of contexts, and the version.

use crate::context::{AntumbraContext, AntumbraContextDesc, guarded};
use crate::error::{AntumbraError, AntumbraResult};
use crate::pointers::{check_output, read};
use crate::version::ANTUMBRA_ABI_VERSION;

/// Returns the version of the interface that the library was compiled with.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_abi_version() -> u32 {
    ANTUMBRA_ABI_VERSION
}

/// Creates a context.
///
/// # Safety
/// The rules of the interface.
///
/// The caller promises that `desc.log` may be called on each thread that uses the context, until
/// the context is destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_context_create(
    desc: *const AntumbraContextDesc,
    context: *mut *mut AntumbraContext,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        guarded(error, || {
            check_output("context", context)?;
            let desc = read("desc", desc)?;
            *context = Box::into_raw(AntumbraContext::new(&desc)?);
            Ok(())
        })
    }
}

/// Destroys a context and all objects in it. Null is not an error.
///
/// # Safety
/// The rules of the interface.
///
/// The caller promises that no other call uses the context, now or later.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_context_destroy(
    context: *mut AntumbraContext,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        guarded(
            error,
            || if context.is_null() { Ok(()) } else { AntumbraContext::destroy(context) },
        )
    }
}
