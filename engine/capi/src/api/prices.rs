//! Functions of the prices of a device.

use crate::context::{AntumbraContext, entry};
use crate::error::{AntumbraError, AntumbraResult};
use crate::executor::prices::AntumbraPrices;
use crate::pointers::{check_output, read};
use crate::renderer::frame::HostedRenderer;
use crate::renderer::prices::AntumbraPricesDesc;

/// Measures the prices of tests and draws on a device that was adopted with a queue, and of the
/// ways to skip hidden draws, for scenes on the same device (`AntumbraSceneDesc::prices`), which
/// may be adopted again without a queue. Takes half a second on a driver without a GPU, and waits
/// for the device again and again: for before the first frame.
///
/// # Safety
/// The rules of the interface. The callbacks of the queue do what they say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_prices_measure(
    context: *const AntumbraContext,
    desc: *const AntumbraPricesDesc,
    prices: *mut AntumbraPrices,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            check_output("prices", prices)?;
            let desc = read("desc", desc)?;
            let device = context.devices.find(desc.device)?.read()?.clone();
            HostedRenderer::check_device(&device)?;
            let measured = render::measure_prices(&device, &desc.options()?)?;
            *prices = context.prices.insert(measured)?;
            Ok(())
        })
    }
}

/// Destroys prices; scenes that were created by them stay. A handle of 0 is no error.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_prices_destroy(
    context: *const AntumbraContext,
    prices: AntumbraPrices,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe { entry(context, error, |context| context.prices.destroy(prices)) }
}
