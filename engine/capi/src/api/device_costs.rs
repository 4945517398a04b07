//! Functions of the costs of a device.

use crate::context::{AntumbraContext, entry};
use crate::error::{AntumbraError, AntumbraResult};
use crate::executor::device_costs::AntumbraDeviceCosts;
use crate::pointers::{check_output, read};
use crate::renderer::device_costs::AntumbraDeviceCostsDesc;
use crate::renderer::frame::HostedRenderer;

/// Measures the costs of tests, of draws, and of the ways to skip hidden draws, on a device that
/// was adopted with a queue. Scenes use the costs (`AntumbraSceneDesc::costs`) on the same device,
/// which may be adopted again without a queue. Takes half a second on a software driver, and waits
/// for the device repeatedly. Call it before the first frame.
///
/// # Safety
/// The rules of the interface.
///
/// The caller promises that the callbacks of the queue do what `AntumbraQueueDesc` says.
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

/// Destroys costs. Scenes that were created with them stay as they are. A handle of 0 is not an
/// error.
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
