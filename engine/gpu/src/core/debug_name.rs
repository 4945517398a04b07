//! The debug names of Vulkan objects, as layers and debuggers show them.

use std::ffi::CString;

use ash::ext::debug_utils;
use ash::vk;

/// Gives a live object of the device of `debug` its name. A failure is ignored.
pub(crate) fn set_debug_name<H: vk::Handle>(debug: &debug_utils::Device, handle: H, name: &str) {
    let name = CString::new(name.replace('\0', " ")).unwrap_or_default();
    let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
    // SAFETY: a live object of this device.
    let _unnamed_is_fine = unsafe { debug.set_debug_utils_object_name(&info) };
}
