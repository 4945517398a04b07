//! Opens devices.

use crate::context::{AntumbraContext, entry};
use crate::error::{AntumbraError, AntumbraResult};
use crate::executor::device::AntumbraDevice;
use crate::executor::device_open::AntumbraDeviceOpenDesc;
use crate::executor::own_device::open;
use crate::pointers::{check_output, read};

/// Opens a device for renderers, with a queue of its own, for a program that has none. The Vulkan
/// loader of the machine is loaded now, so the program needs to link none. The result is
/// `ANTUMBRA_RESULT_UNSUPPORTED` if there is no loader, driver or suitable device; the message says
/// what to install. `antumbra_device_destroy` closes the device. Headless: images are read by
/// `antumbra_renderer_read_image`.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_device_open(
    context: *const AntumbraContext,
    desc: *const AntumbraDeviceOpenDesc,
    device: *mut AntumbraDevice,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            check_output("device", device)?;
            let desc = read("desc", desc)?;
            *device = context.devices.insert(open(&desc)?)?;
            Ok(())
        })
    }
}
