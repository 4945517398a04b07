//! Conversion of Xlib windows to XCB windows: every driver for X11 supports XCB windows, and some
//! support only them.
//!
//! The loader assumes that any driver supports Xlib surfaces. Google's SwiftShader supports none,
//! but reports that it can present to them, and crashes when their size is queried. Both libraries
//! share one connection, and drivers for Xlib windows also use this connection.

use std::ffi::c_void;
use std::num::NonZeroU32;
use std::ptr::NonNull;
use std::sync::OnceLock;

use libloading::Library;
use raw_window_handle::{
    RawDisplayHandle, RawWindowHandle, XcbDisplayHandle, XcbWindowHandle, XlibDisplayHandle,
};

/// The type of `XGetXCBConnection`.
type ConnectionOf = unsafe extern "C" fn(display: *mut c_void) -> *mut c_void;

/// Returns the XCB form of a display, if it is an Xlib display and the library is installed.
pub(crate) fn display(handle: RawDisplayHandle) -> RawDisplayHandle {
    let RawDisplayHandle::Xlib(XlibDisplayHandle { display: Some(display), screen, .. }) = handle
    else {
        return handle;
    };
    let Some(connection_of) = loaded() else { return handle };
    // SAFETY: the display is open, as the owner of the handle promises; it keeps its connection.
    let connection = unsafe { connection_of(display.as_ptr()) };
    match NonNull::new(connection) {
        Some(connection) => XcbDisplayHandle::new(Some(connection), screen).into(),
        None => handle,
    }
}

/// Returns the XCB form of a window, if its display was converted to XCB.
pub(crate) fn window(handle: RawWindowHandle, display: RawDisplayHandle) -> RawWindowHandle {
    let (RawWindowHandle::Xlib(window), RawDisplayHandle::Xcb(_)) = (handle, display) else {
        return handle;
    };
    // Xlib stores the server's 32-bit numbers in a long.
    let number = |long: std::ffi::c_ulong| u32::try_from(long).ok().and_then(NonZeroU32::new);
    let Some(id) = number(window.window) else { return handle };
    let mut xcb = XcbWindowHandle::new(id);
    xcb.visual_id = number(window.visual_id);
    xcb.into()
}

fn loaded() -> Option<ConnectionOf> {
    static LIBRARY: OnceLock<Option<Library>> = OnceLock::new();
    // SAFETY: a part of X11 that runs no code when it is loaded, and is never unloaded.
    let library = LIBRARY.get_or_init(|| unsafe { Library::new("libX11-xcb.so.1") }.ok()).as_ref();
    // SAFETY: the function has this type (X11/Xlib-xcb.h).
    let symbol =
        library.map(|library| unsafe { library.get::<ConnectionOf>(b"XGetXCBConnection\0") });
    symbol.and_then(Result::ok).map(|symbol| *symbol)
}

#[cfg(test)]
mod tests {
    use super::*;
    use raw_window_handle::{WaylandDisplayHandle, XlibWindowHandle};

    #[test]
    fn only_windows_of_xlib_change() {
        let wayland = RawDisplayHandle::Wayland(WaylandDisplayHandle::new(NonNull::dangling()));
        assert_eq!(display(wayland), wayland);
        let closed = RawDisplayHandle::Xlib(XlibDisplayHandle::new(None, 0));
        assert_eq!(display(closed), closed);
        let mut xlib = XlibWindowHandle::new(7);
        xlib.visual_id = 33;
        let xlib = RawWindowHandle::Xlib(xlib);
        assert_eq!(window(xlib, closed), xlib);
        let xcb = RawDisplayHandle::Xcb(XcbDisplayHandle::new(Some(NonNull::dangling()), 0));
        let RawWindowHandle::Xcb(found) = window(xlib, xcb) else { panic!("a window of XCB") };
        assert_eq!((found.window.get(), found.visual_id), (7, NonZeroU32::new(33)));
    }
}
