//! The self-test of a device.

use render::RendererOptions;

use crate::context::{AntumbraContext, entry};
use crate::error::{AntumbraError, AntumbraResult};
use crate::executor::device::AntumbraDevice;
use crate::pointers::Output;
use crate::renderer::frame::HostedRenderer;
use crate::renderer::self_test::AntumbraSelfTest;

/// Tests the driver of a device that was adopted with a queue: small frames check each assumption
/// that exactness rests on. Takes about a second, and waits for the device repeatedly. Call it
/// before the first frame.
///
/// # Safety
/// The rules of the interface.
///
/// The caller promises that the callbacks of the queue do what `AntumbraQueueDesc` says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_self_test(
    context: *const AntumbraContext,
    device: AntumbraDevice,
    outcome: *mut AntumbraSelfTest,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("outcome", outcome)?;
            let device = context.devices.find(device)?.read()?.clone();
            HostedRenderer::check_device(&device)?;
            let found = render::self_test(&device, &RendererOptions::default())?;
            output.write(&AntumbraSelfTest::from(&found));
            Ok(())
        })
    }
}
