//! Window systems: the kinds of windows that an instance can present to, and the extensions that
//! they need.

use std::ffi::{CStr, CString, c_char};

use ash::{ext, khr};
#[cfg(feature = "window")]
use raw_window_handle::{HasDisplayHandle, RawDisplayHandle, RawWindowHandle};

#[cfg(feature = "window")]
use crate::core::error::Called;
use crate::core::error::Error;

/// A window system, by the Vulkan extension for its windows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WindowSystem(&'static CStr);

/// The functions to query surfaces of an instance for windows.
pub(crate) struct WindowFunctions {
    pub(crate) system: WindowSystem,
    pub(crate) surface: khr::surface::Instance,
    /// The device extensions for present fences whose instance extension is enabled.
    pub(crate) present_fences: Vec<&'static CStr>,
}

/// The extensions of an instance, and the extensions of its devices.
type Asked = (Vec<*const c_char>, Vec<&'static CStr>);

const MAINTENANCE: [(&CStr, &CStr); 2] = [
    (c"VK_KHR_surface_maintenance1", c"VK_KHR_swapchain_maintenance1"),
    (ext::surface_maintenance1::NAME, ext::swapchain_maintenance1::NAME),
];

impl WindowSystem {
    /// Returns the window system of `display`, which is the display of a window or of an event loop
    /// without a window.
    ///
    /// # Errors
    /// [`Error::NoDisplay`] if the connection is lost, or if Vulkan does not support the system.
    #[cfg(feature = "window")]
    pub fn of(display: &impl HasDisplayHandle) -> Result<Self, Error> {
        let handle = display.display_handle();
        let handle = handle.map_err(|error| Error::NoDisplay(error.to_string()))?;
        let names = ash_window::enumerate_required_extensions(display_for_drivers(handle.as_raw()));
        let names = names.called("enumerating the extensions for this display")?;
        // SAFETY: names of extensions, as constant strings.
        let mut names = names.iter().map(|name| unsafe { constant(*name) });
        match names.rfind(|name| *name != khr::surface::NAME) {
            Some(platform) => Ok(Self(platform)),
            None => Err(Error::NoDisplay("Vulkan knows no windows of its kind".to_owned())),
        }
    }

    /// Returns true for Wayland, where no error reports a resize, and a hidden window may never
    /// show a frame.
    #[cfg(feature = "window")]
    pub(crate) fn is_wayland(self) -> bool {
        self.0 == khr::wayland_surface::NAME
    }

    /// Returns the name of the call that makes a surface of this system, for errors.
    #[cfg(feature = "window")]
    pub(crate) fn surface_call(self) -> &'static str {
        let calls = [
            (khr::xcb_surface::NAME, "vkCreateXcbSurfaceKHR"),
            (khr::xlib_surface::NAME, "vkCreateXlibSurfaceKHR"),
            (khr::wayland_surface::NAME, "vkCreateWaylandSurfaceKHR"),
            (khr::win32_surface::NAME, "vkCreateWin32SurfaceKHR"),
            (khr::android_surface::NAME, "vkCreateAndroidSurfaceKHR"),
            (ext::metal_surface::NAME, "vkCreateMetalSurfaceEXT"),
        ];
        let found = calls.into_iter().find(|(extension, _)| *extension == self.0);
        found.map_or("creating a surface for the window", |(_, call)| call)
    }

    /// Returns the extensions to request from an instance, out of the available ones in `there`.
    ///
    /// Also returns the device extensions for present fences whose instance extension is then
    /// enabled. The newer of the two extensions has the structures of the older.
    pub(crate) fn extensions(self, there: &[CString]) -> Result<Asked, Error> {
        let has = |name: &CStr| there.iter().any(|extension| extension.as_c_str() == name);
        let required = [khr::surface::NAME, self.0];
        if let Some(missing) = required.into_iter().find(|name| !has(name)) {
            return Err(Error::NoWindows(missing.to_string_lossy().into_owned()));
        }
        let mut names: Vec<_> = required.map(CStr::as_ptr).into();
        let mut present_fences = Vec::new();
        if has(khr::get_surface_capabilities2::NAME) {
            names.push(khr::get_surface_capabilities2::NAME.as_ptr());
            for (of_instance, of_device) in MAINTENANCE {
                if has(of_instance) {
                    names.push(of_instance.as_ptr());
                    present_fences.push(of_device);
                }
            }
        }
        Ok((names, present_fences))
    }
}

/// Returns the display in the form that drivers expect.
#[cfg(feature = "window")]
pub(crate) fn display_for_drivers(handle: RawDisplayHandle) -> RawDisplayHandle {
    #[cfg(feature = "loaded")]
    let handle = crate::core::xcb::display(handle);
    handle
}

/// Returns the window in the form that drivers expect, on the display of [`display_for_drivers`].
#[cfg(feature = "window")]
pub(crate) fn window_for_drivers(
    handle: RawWindowHandle,
    display: RawDisplayHandle,
) -> RawWindowHandle {
    #[cfg(feature = "loaded")]
    let handle = crate::core::xcb::window(handle, display);
    #[cfg(not(feature = "loaded"))]
    let _same_library = display;
    handle
}

/// Returns the string with the lifetime of the program.
///
/// # Safety
/// `name` points to a string that lives until the program ends.
#[cfg(feature = "window")]
unsafe fn constant(name: *const c_char) -> &'static CStr {
    // SAFETY: the caller's promise.
    unsafe { CStr::from_ptr(name) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_named() {
        let xcb = WindowSystem(khr::xcb_surface::NAME);
        let surface: CString = khr::surface::NAME.into();
        let error = xcb.extensions(&[]).unwrap_err().to_string();
        assert!(error.contains("VK_KHR_surface"), "{error}");
        let error = xcb.extensions(std::slice::from_ref(&surface)).unwrap_err().to_string();
        assert!(error.contains("VK_KHR_xcb_surface"), "{error}");
        let there = [surface, khr::xcb_surface::NAME.into()];
        let (names, fences) = xcb.extensions(&there).unwrap();
        assert_eq!((names.len(), fences.len()), (2, 0));
    }

    #[test]
    fn present_fences_need_both_extensions() {
        let wayland = WindowSystem(khr::wayland_surface::NAME);
        let names = [
            khr::surface::NAME,
            khr::wayland_surface::NAME,
            ext::surface_maintenance1::NAME,
            khr::get_surface_capabilities2::NAME,
        ]
        .map(CString::from);
        let (asked, fences) = wayland.extensions(&names).unwrap();
        assert_eq!((asked.len(), fences), (4, vec![ext::swapchain_maintenance1::NAME]));
        let (asked, fences) = wayland.extensions(&names[..3]).unwrap();
        assert_eq!((asked.len(), fences.len()), (2, 0));
        #[cfg(feature = "window")]
        assert!(wayland.is_wayland());
    }
}
