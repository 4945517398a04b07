//! A program on the device of a host. The calls of the host itself do not fail.

use std::sync::{Arc, Mutex};

use gpu::{Device, HostDevice, HostQueue, Purpose, Tick, Timeline};
use tests::every_call;
use tests::host_device::Host;

use super::{Outcome, Program, Stage};

impl Program {
    /// Draws on the device and the queue of a host, and returns the last image.
    pub(super) fn draw_for_host(&self, stage: &Stage) -> Outcome {
        let host = Host::new(stage.driver, Purpose::Renderer);
        let queue = host.share_queue(Arc::new(Mutex::new(())));
        let outcome = self.draw_on(&host, queue);
        every_call::forget_devices();
        host.finish();
        outcome
    }

    fn draw_on(&self, host: &Host, queue: HostQueue) -> Outcome {
        let device = adopt(host, Some(queue))?;
        let timeline = Timeline::new(&device, "work of the host")?;
        timeline.signal(Tick(1))?;
        self.walk(&device)
    }
}

/// Lets the engine adopt the device of a host, through the loader in which calls fail.
pub(super) fn adopt(host: &Host, queue: Option<HostQueue>) -> Result<Device, gpu::Error> {
    let entry = every_call::entry();
    // SAFETY: handles of the host, which outlive the engine's device.
    let instance = unsafe { ash::Instance::load(entry.static_fn(), host.instance.handle()) };
    // SAFETY: as above.
    let device = unsafe { ash::Device::load(instance.fp_v1_0(), host.device.handle()) };
    every_call::watch(host.device.handle());
    host.try_adopt(HostDevice { entry, instance, device, queue, ..host.describe() })
}
