//! Broken connections to an X server: Xlib then ends the process, unless the program prevents it.

use std::ffi::{c_int, c_void};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use libloading::Library;
use raw_window_handle::{HasDisplayHandle, RawDisplayHandle, XlibDisplayHandle};

/// The type `XIOErrorHandler` of X11/Xlib.h.
type ErrorHandler = unsafe extern "C" fn(display: *mut c_void) -> c_int;
/// The type of `XSetIOErrorHandler`, whose handler applies to all connections of the process.
type SetErrorHandler = unsafe extern "C" fn(handler: ErrorHandler) -> *mut c_void;
/// The type `XIOErrorExitHandler`.
type ExitHandler = unsafe extern "C" fn(display: *mut c_void, is_lost: *mut c_void);
/// The type of `XSetIOErrorExitHandler`, since libX11 1.7.
type SetExitHandler =
    unsafe extern "C" fn(display: *mut c_void, handler: ExitHandler, is_lost: *mut c_void);

/// The connection of a window to its display.
///
/// A broken Xlib connection ends the process, and unsaved data is lost. With a link the process
/// goes on: calls of Xlib fail from then on, [`DisplayLink::is_lost`] returns true, and the program
/// can end in order.
#[derive(Clone, Copy, Debug)]
pub struct DisplayLink(&'static AtomicBool);

impl DisplayLink {
    /// Watches the connection of `display`, which belongs to a window or an event loop. Connections
    /// of other systems, and of Xlib before 1.7, are not watched: the link is never lost.
    ///
    /// Replaces Xlib's handler of broken connections, which is global to the process: a handler of
    /// the host is not called any more. Connections that are not watched still end the process,
    /// without Xlib's message.
    pub fn watch(display: &impl HasDisplayHandle) -> Self {
        // Never freed: the display keeps the pointer until its owner closes it.
        let is_lost: &'static AtomicBool = Box::leak(Box::default());
        let handle = display.display_handle().map(|handle| handle.as_raw());
        let Ok(RawDisplayHandle::Xlib(XlibDisplayHandle { display: Some(display), .. })) = handle
        else {
            return Self(is_lost);
        };
        if let Some((set_error_handler, set_exit_handler)) = loaded() {
            let pointer = std::ptr::from_ref(is_lost).cast_mut().cast();
            // SAFETY: the display is open, as the owner of its handle promises. `note_loss` uses
            // the pointer with its true type, and it is never freed. Xlib's own error handler ends
            // the process before the exit handler is called; connections without a link still end
            // it.
            unsafe {
                set_exit_handler(display.as_ptr(), note_loss, pointer);
                set_error_handler(go_on);
            }
        }
        Self(is_lost)
    }

    /// Returns true once the connection is broken.
    pub fn is_lost(self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Notes the loss of a connection.
///
/// # Safety
/// `is_lost` points to an `AtomicBool` that lives as long as the program.
unsafe extern "C" fn note_loss(_: *mut c_void, is_lost: *mut c_void) {
    // SAFETY: the caller's promise; an atomic may be shared.
    let is_lost = unsafe { &*is_lost.cast::<AtomicBool>() };
    is_lost.store(true, Ordering::Relaxed);
}

/// Returns to Xlib, which then calls the exit handler.
unsafe extern "C" fn go_on(_: *mut c_void) -> c_int {
    0
}

fn loaded() -> Option<(SetErrorHandler, SetExitHandler)> {
    static LIBRARY: OnceLock<Option<Library>> = OnceLock::new();
    // SAFETY: a program with an Xlib display has this library loaded; it is never unloaded.
    let library = LIBRARY.get_or_init(|| unsafe { Library::new("libX11.so.6") }.ok()).as_ref()?;
    // SAFETY: both functions have these types (X11/Xlib.h).
    unsafe {
        let set_error_handler = library.get::<SetErrorHandler>(b"XSetIOErrorHandler\0").ok()?;
        let set_exit_handler = library.get::<SetExitHandler>(b"XSetIOErrorExitHandler\0").ok()?;
        Some((*set_error_handler, *set_exit_handler))
    }
}
