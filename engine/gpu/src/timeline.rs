//! Ticks: values of a timeline semaphore, the one proof that work on the GPU is over.

use ash::vk;

use crate::deletion::Garbage;
use crate::device::Device;
use crate::error::{Called, Error};
use crate::ownership::of_device;

/// A value of a timeline. Ticks of one device are numbered from 1 in the order of its submits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Tick(pub u64);

impl Tick {
    /// Before all work.
    pub const ZERO: Tick = Tick(0);

    /// The tick after this one.
    pub fn next(self) -> Tick {
        Tick(self.0 + 1)
    }
}

/// A timeline of a host's own, for frames that must wait for something: hand it to
/// [`crate::Frame::submit`], signal it from the CPU or from a queue of the host.
pub struct Timeline {
    device: Device,
    pub(crate) raw: vk::Semaphore,
}

impl Timeline {
    /// A timeline at tick 0.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(device: &Device, name: &str) -> Result<Self, Error> {
        let raw = create_semaphore(device.raw())?;
        device.name(raw, name);
        Ok(Self { device: device.clone(), raw })
    }

    /// Signals `tick` from the CPU. Ticks must rise.
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
        self.device.retire(Garbage::Semaphore(self.raw));
    }
}

pub(crate) fn create_semaphore(device: &ash::Device) -> Result<vk::Semaphore, Error> {
    let mut kind =
        vk::SemaphoreTypeCreateInfo::default().semaphore_type(vk::SemaphoreType::TIMELINE);
    let info = vk::SemaphoreCreateInfo::default().push_next(&mut kind);
    // SAFETY: timelineSemaphore is a required feature.
    unsafe { device.create_semaphore(&info, None) }.called("vkCreateSemaphore")
}
