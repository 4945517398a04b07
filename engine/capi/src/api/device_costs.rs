//! Functions of the costs of a device.

use crate::context::{AntumbraContext, entry};
use crate::error::{AntumbraError, AntumbraResult};
use crate::executor::device_costs::AntumbraDeviceCosts;
use crate::pointers::{check_output, read};
use crate::renderer::device_costs::AntumbraDeviceCostsDesc;
use crate::renderer::frame::HostedRenderer;

/// Measures the costs of tests and draws on a device that was adopted with a queue, and of the
/// ways to skip hidden draws, for scenes on the same device (`AntumbraSceneDesc::costs`), which
/// may be adopted again without a queue. Takes half a second on a driver without a GPU, and waits
/// for the device again and again: for before the first frame.
///
/// # Safety
/// The rules of the interface. The callbacks of the queue do what they say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_device_costs_measure(
    context: *const AntumbraContext,
    desc: *const AntumbraDeviceCostsDesc,
    costs: *mut AntumbraDeviceCosts,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            check_output("costs", costs)?;
            let desc = read("desc", desc)?;
            let device = context.devices.find(desc.device)?.read()?.clone();
            HostedRenderer::check_device(&device)?;
            let measured = render::measure_costs(&device, &desc.options()?)?;
            *costs = context.costs.insert(measured)?;
            Ok(())
        })
    }
}

/// Destroys costs; scenes that were created by them stay. A handle of 0 is no error.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_device_costs_destroy(
    context: *const AntumbraContext,
    costs: AntumbraDeviceCosts,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe { entry(context, error, |context| context.costs.destroy(costs)) }
}
