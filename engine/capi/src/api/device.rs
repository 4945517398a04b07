//! Functions of devices.

use gpu::Purpose;

use crate::context::{AntumbraContext, entry};
use crate::error::{AntumbraError, AntumbraResult, Failure};
use crate::executor::device::{
    AntumbraAdapterDesc, AntumbraDevice, AntumbraDeviceDesc, AntumbraFeatures,
    AntumbraRequirements, adopt, require,
};
use crate::pointers::{Output, check_output, read};

/// Writes the requirements of the executor on a physical device. Turns on the features in the
/// structs of `features` that the executor needs or can use, and leaves all others as they are.
/// Call it before the device is created, with the structs that the device is created with. If the
/// result is `ANTUMBRA_RESULT_UNSUPPORTED`, the message names what is missing.
///
/// # Safety
/// The rules of the interface.
///
/// The caller promises that the handles are valid.
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

/// Writes the requirements of a part of the engine.
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

/// Adopts the device of a host. The library never destroys objects of the host. A device with a
/// queue is for renderers, which submit to the queue. A device without a queue is for scenes:
/// nothing is submitted, and the host's frame numbers say which frames are over. If the result is
/// `ANTUMBRA_RESULT_UNSUPPORTED`, the message names what is not on.
///
/// # Safety
/// The rules of the interface.
///
/// The caller promises that the handles belong together, and live until this device and everything
/// that is created on it are destroyed. All features and extensions that `desc` names are on.
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

/// Declares that all frames are over on the GPU, or will never be submitted, so that their
/// resources can be freed. Call it before the device is destroyed; otherwise resources that the
/// last frames may still use are never freed, and the log says so. A device with a queue tracks its
/// frames itself: the result is `ANTUMBRA_RESULT_BAD_ARGUMENT`.
///
/// # Safety
/// The rules of the interface.
///
/// The caller promises that this is true.
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

/// Ends the adoption of a device, which the host still owns, or closes a device that the library
/// opened. Scenes and renderers on it live on until they are destroyed. With a queue, this call or
/// the destruction of the last renderer waits until all submitted frames are over; the wait is
/// bounded. A handle of 0 is not an error.
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
