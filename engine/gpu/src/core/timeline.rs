//! Timelines of a host that frames can wait for.

use ash::vk;

use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::ownership::{Ownership, of_device};
use crate::core::tick::{Tick, create_semaphore};

/// A timeline for frames that must wait for other work. Pass it to [`crate::Frame::submit`], and
/// signal it from the CPU or from a queue of the host.
pub struct Timeline {
    device: Device,
    pub(crate) raw: vk::Semaphore,
    ownership: Ownership,
}

/// A tick of a timeline that a submit waits for on the GPU.
#[derive(Clone, Copy)]
pub struct TimelineWait<'a> {
    /// The timeline.
    pub timeline: &'a Timeline,
    /// The tick that the timeline must have reached.
    pub tick: Tick,
}

impl Timeline {
    /// Creates a timeline at tick 0.
    ///
    /// # Errors
    /// [`Error::NoQueue`] on a device without a queue; a failed call.
    pub fn new(device: &Device, name: &str) -> Result<Self, Error> {
        device.check_queue("a timeline")?;
        let raw = create_semaphore(device.raw(), device.callbacks())?;
        device.name(raw, name);
        Ok(Self { device: device.clone(), raw, ownership: Ownership::Ours })
    }

    /// Wraps a timeline semaphore that a host created and keeps owning.
    ///
    /// # Safety
    /// `raw` is a timeline semaphore of this device. It lives until every frame that waits for it
    /// is over.
    ///
    /// # Errors
    /// [`Error::NoQueue`] on a device without a queue.
    pub unsafe fn from_raw(device: &Device, raw: vk::Semaphore) -> Result<Self, Error> {
        device.check_queue("a timeline")?;
        Ok(Self { device: device.clone(), raw, ownership: Ownership::Host })
    }

    /// Returns the wait of a submit for `tick` of this timeline.
    pub fn at(&self, tick: Tick) -> TimelineWait<'_> {
        TimelineWait { timeline: self, tick }
    }

    /// Signals `tick` from the CPU. Ticks must increase.
    ///
    /// # Errors
    /// A failed call.
    pub fn signal(&self, tick: Tick) -> Result<(), Error> {
        let info = vk::SemaphoreSignalInfo::default().semaphore(self.raw).value(tick.0);
        // SAFETY: a timeline semaphore of this device.
        unsafe { self.device.raw().signal_semaphore(&info) }.called("vkSignalSemaphore")
    }
}

of_device!(Timeline: "a timeline (`Timeline`)");

impl Drop for Timeline {
    fn drop(&mut self) {
        if self.ownership == Ownership::Ours {
            self.device.retire(Retired::Semaphore(self.raw));
        }
    }
}
