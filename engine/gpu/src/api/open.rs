//! Opening a device in one call, for programs without special needs.

#[cfg(feature = "window")]
use std::sync::Arc;

use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::instance::{Instance, InstanceOptions, load_entry};
use crate::core::open_device::DeviceOptions;
#[cfg(feature = "window")]
use crate::core::window_system::WindowSystem;
#[cfg(feature = "window")]
use crate::present::surface::{Surface, Window};
#[cfg(feature = "window")]
use crate::present::swapchain::{Swapchain, SwapchainOptions};

/// Opens the machine's best device.
///
/// # Errors
/// No loader, no driver, no suitable device.
pub fn open() -> Result<Device, Error> {
    let instance = Instance::new(load_entry()?, &InstanceOptions::default())?;
    let adapter = instance.pick_adapter(None)?;
    Device::new(&instance, &adapter, &DeviceOptions::default())
}

/// Opens the machine's best device that can present to `window`, and the window's swapchain.
///
/// # Errors
/// The errors of [`open`]; a window that is closed, or that no device can present to.
#[cfg(feature = "window")]
pub fn open_with_window(window: Arc<dyn Window>) -> Result<(Device, Swapchain), Error> {
    let windows = Some(WindowSystem::of(&window)?);
    let options = InstanceOptions { windows, ..InstanceOptions::default() };
    let instance = Instance::new(load_entry()?, &options)?;
    let surface = Surface::new(&instance, window)?;
    let adapter = instance.pick_adapter_for(&surface, None)?;
    let device = Device::new(&instance, &adapter, &DeviceOptions::default())?;
    let swapchain = Swapchain::new(&device, &surface, &SwapchainOptions::default())?;
    Ok((device, swapchain))
}
