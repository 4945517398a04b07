//! Functions of devices.

use gpu::Purpose;

use crate::context::{AntumbraContext, entry};
use crate::error::{AntumbraError, AntumbraResult, Failure};
use crate::executor::device::{
    AntumbraAdapterDesc, AntumbraDevice, AntumbraDeviceDesc, AntumbraFeatures,
    AntumbraRequirements, adopt, require,
};
use crate::pointers::{Output, check_output, read};

/// Writes the needs of the executor on a physical device: turns the features on in `features` that
/// it needs or can use, and leaves all others as they are. To be called before the device is
/// created, with the structs that it is created with. `UNSUPPORTED` names what is missing.
///
/// # Safety
/// The rules of the interface; the handles are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_requirements(
    context: *const AntumbraContext,
    adapter: *const AntumbraAdapterDesc,
    features: *const AntumbraFeatures,
    requirements: *mut AntumbraRequirements,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |_| write_needs(adapter, features, requirements, Purpose::Executor))
    }
}

/// Writes the needs of a part of the engine.
///
/// # Safety
/// The rules of the interface; the handles are valid.
pub(crate) unsafe fn write_needs(
    adapter: *const AntumbraAdapterDesc,
    features: *const AntumbraFeatures,
    requirements: *mut AntumbraRequirements,
    purpose: Purpose,
) -> Result<(), Failure> {
    // SAFETY: the caller's promises.
    unsafe {
        let output = Output::new("requirements", requirements)?;
        let adapter = read("adapter", adapter)?;
        let features = read("features", features)?;
        output.write(&require(&adapter, &features, purpose)?);
    }
    Ok(())
}

/// Adopts the device of a host: nothing of the host is ever destroyed. With a queue it is for
/// renderers, which submit to it. Without one it is for scenes: nothing is submitted, and the
/// host's frame numbers are its clock. `UNSUPPORTED` names what is not on.
///
/// # Safety
/// The rules of the interface. The handles belong together, and live until this device and all that
/// is made on it are destroyed. Nothing is named that is not on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_device_adopt(
    context: *const AntumbraContext,
    desc: *const AntumbraDeviceDesc,
    device: *mut AntumbraDevice,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            check_output("device", device)?;
            let desc = read("desc", desc)?;
            *device = context.devices.insert(adopt(&desc)?)?;
            Ok(())
        })
    }
}

/// Says that all frames are over on the GPU, or will never be submitted: what they used can be
/// freed. To be called before the device is destroyed; otherwise all that the last frames may still
/// use is kept for good, and the log says so. A device with a queue knows by itself:
/// `BAD_ARGUMENT`.
///
/// # Safety
/// The rules of the interface, and it is so.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_device_finished(
    context: *const AntumbraContext,
    device: AntumbraDevice,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            Ok(context.devices.find(device)?.read()?.host_finished()?)
        })
    }
}

/// Gives the device back: the host goes on to own it. Scenes and renderers on it live on until they
/// are destroyed. With a queue, the last of them and this wait until what was submitted is over;
/// the wait is bounded. A handle of 0 is no error.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_device_destroy(
    context: *const AntumbraContext,
    device: AntumbraDevice,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe { entry(context, error, |context| context.devices.destroy(device)) }
}
