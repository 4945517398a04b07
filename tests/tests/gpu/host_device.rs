//! The engine on the device of a host, which is made from the engine's requirements alone.

use gpu::{Buffer, Error, FrameRing, MemoryKind, Purpose, vk};
use tests::Driver;
use tests::host_device::Host;

#[test]
fn a_device_without_a_queue_submits_nothing_and_frees_what_frames_are_over() {
    for driver in Driver::ALL {
        let host = Host::new(driver, Purpose::Executor);
        let device = host.adopt(None);
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let errors = [
            FrameRing::new(&device, 2).unwrap().begin().err(),
            device.run_once("nothing", |_| {}).err(),
            device.drain().err(),
        ];
        for error in errors {
            let error = error.expect("an error");
            assert!(matches!(error, Error::NoQueue { .. }), "{error}");
        }
        let before = device.retired();
        drop(Buffer::new(&device, "dropped", 64, usage, MemoryKind::Device).unwrap());
        assert_eq!(device.retired(), before + 1);
        host.say_all_is_over(&device);
        assert_eq!(device.retired(), 0);
        drop(device);
        host.finish();
    }
}
