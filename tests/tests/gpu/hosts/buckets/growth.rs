//! More objects than fit, and no memory for more: nothing is lost, and images stay right.

use ash::vk;
use cull::{Aabb, Strategy};
use glam::vec3;
use gpu::{Device, DeviceOptions, PredicationMode};
use tests::fault_injection::{Fault, FaultInjection, calls};
use tests::walk::images_that_differ;
use tests::{Driver, instance_with, run_on_all};

use super::boxes::Part;
use super::host::{Host, Recorder};
use super::{camera, wall};

/// Returns a grid of objects with one draw each, behind and beside the wall.
pub fn grid(count: usize) -> Vec<Vec<Part>> {
    let part = |number: usize| {
        let low = vec3((number % 40) as f32 * 0.5 - 10.0, (number / 40) as f32 * 0.5 - 3.0, -9.0);
        vec![Part { bucket: number as u32 % 3, boxes: vec![Aabb::new(low, low + 0.4)] }]
    };
    (0..count).map(part).collect()
}

pub fn assert_all_equal(device: &Device, host: &Host, what: &str) {
    device.wait_idle().unwrap();
    for (frame, [culled, all]) in host.images.iter().enumerate() {
        assert_eq!(images_that_differ(culled, all), 0, "{what}, frame {frame}");
    }
}

#[test]
fn objects_that_come_one_by_one_find_room() {
    run_on_all(|device| {
        let mut host = Host::new(device, 3, PredicationMode::Instances, Recorder::Engine);
        host.wall = host.add(vec![wall(3)])[0];
        for (frame, object) in grid(120).into_iter().enumerate() {
            host.add(vec![object]);
            host.upload().unwrap();
            if frame % 3 == 0 {
                host.draw(Strategy::ANTUMBRA, &camera((frame % 7) as f32 / 3.0 - 1.0, 0.0));
            }
        }
        assert_all_equal(device, &host, "one by one");
    });
}

#[test]
fn growth_that_fails_is_tried_again_and_loses_nothing() {
    const CREATE: &std::ffi::CStr = c"vkCreateBuffer";
    let instance = instance_with(FaultInjection::default().entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    let mut failed = 0;
    for number in 0.. {
        let mut host = Host::new(&device, 3, PredicationMode::Counts, Recorder::Engine);
        host.wall = host.add(vec![wall(3)])[0];
        (0..3).for_each(|_| host.draw(Strategy::ANTUMBRA, &camera(0.0, 0.0)));
        // More leaves and more draws than the buffers hold.
        let added = host.add(grid(300));
        let code = vk::Result::ERROR_OUT_OF_DEVICE_MEMORY;
        let faults = vec![Fault { call: CREATE, fails: number..usize::MAX, code }];
        FaultInjection { faults, ..FaultInjection::default() }.install();
        let uploaded = host.upload();
        let made = calls(CREATE);
        FaultInjection::default().install();
        let is_done = uploaded.is_ok();
        if let Err(error) = uploaded {
            let error = error.to_string();
            assert!(error.contains("vkCreateBuffer") && error.contains("MEMORY"), "{error}");
            failed += 1;
        } else {
            assert_eq!(made, number, "a call that failed was no error");
        }
        // Changes between the frames are drawn, too.
        host.remove(&added[..20]);
        for side in 0..6 {
            host.draw(Strategy::ANTUMBRA, &camera(side as f32 / 3.0 - 1.0, 0.0));
        }
        assert_all_equal(&device, &host, &format!("call {number}"));
        let (fewest, there) = host.fewest_and_all();
        assert!(fewest < there && there == 2 + 280, "{fewest} of {there}");
        if is_done {
            break;
        }
    }
    // The buffers of boxes, first draws, commands and links.
    assert_eq!(failed, 4);
    let log = instance.validation_log().clone();
    drop((device, instance));
    assert_eq!(log.drain(), []);
}
