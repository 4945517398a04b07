//! The loss of a device as C reports it, and the next device.

use std::ptr::null;

use ash::vk;
use capi::decisions::camera::AntumbraCamera;
use capi::error::AntumbraResult::{DeviceLost, Ok};
use capi::executor::frame::AntumbraViewFrame;
use capi::executor::target::AntumbraTargetDesc;
use capi::layout::Versioned;
use gpu::{Features, Purpose};
use tests::drivers;
use tests::fault_injection::{Fault, FaultInjection, calls};
use tests::host_device::Host;

use super::{CHost, camera, expect, text};

fn view<'a>(
    c: &CHost<'_>,
    camera: &'a AntumbraCamera,
    target: &'a AntumbraTargetDesc,
) -> AntumbraViewFrame {
    AntumbraViewFrame { view: c.view, camera, target, ..Versioned::INIT }
}

#[test]
fn a_lost_device_is_told_and_another_one_draws() {
    for driver in drivers() {
        let entry = FaultInjection::default().entry();
        let host = Host::through(entry, driver, Purpose::Executor, &[], Features::default());
        let mut lost = CHost::new(&host, null());
        let camera = camera();
        let target = lost.target();
        let lost_view = view(&lost, &camera, &target);
        // The first frame of a view creates its objects.
        let call = c"vkCreateBuffer";
        let code = vk::Result::ERROR_DEVICE_LOST;
        let faults = vec![Fault { call, fails: 0..usize::MAX, code }];
        FaultInjection { faults, ..FaultInjection::default() }.install();
        for _ in 0..3 {
            let recorded = lost.record(&[&lost_view], |_| {});
            expect(recorded, DeviceLost, "vkCreateBuffer", &lost.error);
        }
        assert!(calls(call) > 0);
        // Everything is destroyed without a wait for the GPU, which will never be idle.
        lost.finish();
        assert_eq!(calls(c"vkDeviceWaitIdle"), 0);
        FaultInjection::default().install();
        host.finish();

        let host = Host::new(driver, Purpose::Executor);
        let mut next = CHost::new(&host, null());
        let target = next.target();
        let next_view = view(&next, &camera, &target);
        assert_eq!(next.record(&[&next_view], |_| {}), Ok, "{}", text(&next.error));
        next.finish();
        host.finish();
    }
}
