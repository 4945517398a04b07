//! A device in one call, for programs that have nothing special to ask for.

use std::sync::Arc;

use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::instance::{Instance, InstanceOptions, load_entry};
use crate::core::open_device::DeviceOptions;
use crate::core::window_system::WindowSystem;
use crate::present::surface::{Surface, Window};
use crate::present::swapchain::{Swapchain, SwapchainOptions};

/// Opens the machine's best device and, if there is a window, its swapchain.
///
/// # Errors
/// No loader, no driver, no device that can; a window that is gone.
pub fn open(window: Option<Arc<dyn Window>>) -> Result<(Device, Option<Swapchain>), Error> {
    let windows = window.as_ref().map(WindowSystem::of).transpose()?;
    let options = InstanceOptions { windows, ..InstanceOptions::default() };
    let instance = Instance::new(load_entry()?, &options)?;
    let Some(window) = window else {
        let adapter = instance.pick_adapter(None)?;
        return Ok((Device::new(&instance, &adapter, &DeviceOptions::default())?, None));
    };
    let surface = Surface::new(&instance, window)?;
    let adapter = instance.pick_adapter_for(&surface, None)?;
    let device = Device::new(&instance, &adapter, &DeviceOptions::default())?;
    let swapchain = Swapchain::new(&device, &surface, &SwapchainOptions::default())?;
    Ok((device, Some(swapchain)))
}
