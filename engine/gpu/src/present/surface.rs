//! Surfaces: windows in Vulkan, the formats and modes that they offer, and the devices that can
//! present to them.

use std::sync::Arc;

use ash::{khr, vk};
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};

use crate::core::adapter::Adapter;
use crate::core::capabilities::OptionalFeature;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::instance::{Instance, InstanceShared};
use crate::core::ownership;
use crate::core::window_system::{
    WindowFunctions, WindowSystem, display_for_drivers, window_for_drivers,
};
use crate::present::present_mode::PresentMode;

/// A window of any library that supports `raw-window-handle`.
pub trait Window: HasWindowHandle + HasDisplayHandle + Send + Sync {}

impl<W: HasWindowHandle + HasDisplayHandle + Send + Sync> Window for W {}

/// A window that frames can be shown in. Clones share it.
///
/// A surface keeps its window alive. Swapchains made from the surface keep it alive until the GPU
/// and the presentation engine are done with them.
#[derive(Clone)]
pub struct Surface {
    shared: Arc<SurfaceShared>,
}

pub(crate) struct SurfaceShared {
    instance: Arc<InstanceShared>,
    functions: khr::surface::Instance,
    raw: vk::SurfaceKHR,
    is_wayland: bool,
    // The field follows the surface, so that the window is dropped after it.
    window: Arc<dyn Window>,
}

impl Surface {
    /// Creates a surface for `window`, which must belong to the window system of the instance.
    ///
    /// # Errors
    /// [`Error::NoDisplay`] if the window or its connection is closed; [`Error::NoWindows`] for an
    /// instance that is not for windows; [`Error::Foreign`] for a window of another window system
    /// than the instance; a failed call.
    pub fn new(instance: &Instance, window: Arc<dyn Window>) -> Result<Self, Error> {
        Self::with_shared(&instance.shared, window)
    }

    /// Creates another surface for the same window, after this one was lost.
    pub(crate) fn renewed(&self) -> Result<Self, Error> {
        Self::with_shared(&self.shared.instance, Arc::clone(&self.shared.window))
    }

    fn with_shared(instance: &Arc<InstanceShared>, window: Arc<dyn Window>) -> Result<Self, Error> {
        let gone = |error: raw_window_handle::HandleError| Error::NoDisplay(error.to_string());
        let WindowFunctions { surface: functions, system: wanted, .. } = functions(instance)?;
        let functions = functions.clone();
        let system = WindowSystem::of(&window)?;
        if system != *wanted {
            let thing = "a window";
            let user = "an instance";
            let owner = "WindowSystem";
            return Err(Error::Foreign { thing, user, owner });
        }
        let display = display_for_drivers(window.display_handle().map_err(gone)?.as_raw());
        let handle = window_for_drivers(window.window_handle().map_err(gone)?.as_raw(), display);
        // SAFETY: the surface keeps the window, and with it both handles, until the surface is
        // destroyed; it also keeps the instance.
        let made = unsafe {
            ash_window::create_surface(&instance.entry, &instance.raw, display, handle, None)
        };
        let raw = made.called(system.surface_call())?;
        let instance = Arc::clone(instance);
        let is_wayland = system.is_wayland();
        let shared = SurfaceShared { instance, functions, raw, is_wayland, window };
        Ok(Self { shared: Arc::new(shared) })
    }

    pub(crate) fn instance(&self) -> &InstanceShared {
        &self.shared.instance
    }

    /// Returns the number of holders of the surface and its window: clones, swapchains, and retired
    /// swapchains that the GPU or the presentation engine still uses.
    pub fn holders(&self) -> usize {
        Arc::strong_count(&self.shared)
    }

    /// Returns the present modes that `device` supports for this window.
    ///
    /// # Errors
    /// [`Error::Foreign`] for a device of another instance; a failed call, for example for a closed
    /// window.
    pub fn present_modes(&self, device: &Device) -> Result<Vec<PresentMode>, Error> {
        self.check(device)?;
        let physical = device.adapter().physical;
        // SAFETY: device and surface are of one instance.
        let modes = unsafe {
            self.shared.functions.get_physical_device_surface_present_modes(physical, self.raw())
        };
        let modes = modes.called("vkGetPhysicalDeviceSurfacePresentModesKHR")?;
        Ok(modes.into_iter().filter_map(PresentMode::from_raw).collect())
    }

    /// Returns an error for a device of another instance.
    pub(crate) fn check(&self, device: &Device) -> Result<(), Error> {
        let ids = (self.shared.instance.id, device.instance().id);
        ownership::check(ids.0, ids.1, "a surface (`Surface`)", "a device", "Instance")
    }

    pub(crate) fn formats(&self, device: &Device) -> Result<Vec<vk::SurfaceFormatKHR>, Error> {
        let physical = device.adapter().physical;
        // SAFETY: as above.
        unsafe { self.shared.functions.get_physical_device_surface_formats(physical, self.raw()) }
            .called("vkGetPhysicalDeviceSurfaceFormatsKHR")
    }

    /// Returns the size of the surface and its other present capabilities.
    pub(crate) fn state(&self, device: &Device) -> Result<vk::SurfaceCapabilitiesKHR, vk::Result> {
        let physical = device.adapter().physical;
        // SAFETY: as above.
        unsafe {
            self.shared.functions.get_physical_device_surface_capabilities(physical, self.raw())
        }
    }

    /// Returns true if `device` can present to the window; false once the window is closed.
    pub(crate) fn is_there(&self, device: &Device) -> Result<bool, Error> {
        let physical = device.adapter().physical;
        let family = device.queue_family();
        // SAFETY: device and surface are of one instance, the family is the device's own.
        let presents = unsafe {
            self.shared.functions.get_physical_device_surface_support(physical, family, self.raw())
        };
        match presents {
            Err(vk::Result::ERROR_SURFACE_LOST_KHR) => Ok(false),
            other => other.called("vkGetPhysicalDeviceSurfaceSupportKHR"),
        }
    }

    /// Returns true if presenting in a queued mode may wait for a compositor while the window is
    /// not visible.
    pub(crate) fn may_hold_presents(&self) -> bool {
        self.shared.is_wayland
    }

    pub(crate) fn raw(&self) -> vk::SurfaceKHR {
        self.shared.raw
    }

    /// Returns the first queue family of `adapter` that draws, computes and presents to this
    /// surface, and the number of its timestamp bits.
    fn presenting_family(&self, adapter: &Adapter) -> Result<Option<(u32, u32)>, Error> {
        let raw = &self.shared.instance.raw;
        // SAFETY: an adapter of this instance.
        let families = unsafe { raw.get_physical_device_queue_family_properties(adapter.physical) };
        let needed = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
        for (index, family) in (0..).zip(&families) {
            if !family.queue_flags.contains(needed) {
                continue;
            }
            // SAFETY: adapter and surface are of one instance, the index is one of its families.
            let presents = unsafe {
                self.shared.functions.get_physical_device_surface_support(
                    adapter.physical,
                    index,
                    self.raw(),
                )
            };
            if presents.called("vkGetPhysicalDeviceSurfaceSupportKHR")? {
                return Ok(Some((index, family.timestamp_valid_bits)));
            }
        }
        Ok(None)
    }

    /// Returns `adapter` with a queue that presents to this surface, or the reason why there is
    /// none.
    pub(crate) fn presenting(&self, adapter: &Adapter) -> Result<Result<Adapter, String>, Error> {
        let name = &adapter.name;
        if !adapter.capabilities.has(OptionalFeature::Swapchain) {
            return Ok(Err(format!("{name} lacks {}", OptionalFeature::Swapchain.name())));
        }
        Ok(match self.presenting_family(adapter)? {
            Some((family, timestamp_bits)) => {
                Ok(Adapter { queue_family: Some(family), timestamp_bits, ..adapter.clone() })
            }
            None => Err(format!("{name} has no queue that can show frames in this window")),
        })
    }
}

fn functions(instance: &InstanceShared) -> Result<&WindowFunctions, Error> {
    let missing = || Error::NoWindows("the option `InstanceOptions::windows`".to_owned());
    instance.windows.as_ref().ok_or_else(missing)
}

impl Drop for SurfaceShared {
    fn drop(&mut self) {
        // SAFETY: every swapchain holds the surface, so no swapchain is left; window and instance
        // are still alive.
        unsafe { self.functions.destroy_surface(self.raw, None) };
    }
}
