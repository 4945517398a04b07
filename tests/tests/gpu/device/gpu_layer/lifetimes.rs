//! Dropped objects are freed as soon as they cannot be used any more, and not earlier.

use gpu::{Buffer, Device, FrameRing, MemoryKind, Tick, Timeline, vk};
use tests::run_on_all;

const BOTH_WAYS: vk::BufferUsageFlags = vk::BufferUsageFlags::from_raw(
    vk::BufferUsageFlags::TRANSFER_SRC.as_raw() | vk::BufferUsageFlags::TRANSFER_DST.as_raw(),
);

fn sevens(device: &Device) -> Buffer {
    device.upload("sevens", &[7u32; 1024], BOTH_WAYS).unwrap()
}

fn readback(device: &Device) -> Buffer {
    Buffer::new(device, "readback", 4096, BOTH_WAYS, MemoryKind::ReadBack).unwrap()
}

#[test]
fn what_is_dropped_lives_until_its_tick() {
    run_on_all(|device| {
        let gate = Timeline::new(device, "gate").unwrap();
        let mut ring = FrameRing::new(device, 2).unwrap();
        let usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        let from = device.upload("from", &[5u32; 1024], usage).unwrap();
        let to = Buffer::new(device, "to", 4096, usage, MemoryKind::ReadBack).unwrap();
        // The staging memory of the upload is retired, too.
        device.wait_idle().unwrap();
        let in_use = device.memory_use().used_bytes;
        let frame = ring.begin().unwrap();
        frame.commands().copy_buffer(from.whole(), to.whole());
        frame.submit(Some(gate.at(Tick(1)))).unwrap();
        drop(from);
        ring.begin().unwrap().submit(None).unwrap();
        assert_eq!((device.retired(), device.memory_use().used_bytes), (1, in_use));
        gate.signal(Tick(1)).unwrap();
        device.wait_idle().unwrap();
        assert_eq!(to.read::<u32>(0..1024), [5; 1024]);
        assert_eq!(device.retired(), 0);
        assert!(device.memory_use().used_bytes < in_use);
    });
}

#[test]
fn what_is_dropped_outlives_the_commands_being_recorded() {
    run_on_all(|device| {
        let mut ring = FrameRing::new(device, 2).unwrap();
        let mut other_ring = FrameRing::new(device, 1).unwrap();
        let from = sevens(device);
        let to = readback(device);
        device.wait_idle().unwrap();
        assert_eq!(device.retired(), 0);
        let frame = ring.begin().unwrap();
        frame.commands().copy_buffer(from.whole(), to.whole());
        drop(from);
        // Other submits, and the objects that they free, do not affect this frame.
        drop(device.upload("another", &[1u32; 1024], BOTH_WAYS).unwrap());
        other_ring.begin().unwrap().submit(None).unwrap();
        device.wait_idle().unwrap();
        assert!(device.retired() > 0, "freed under a recording");
        frame.submit(None).unwrap();
        device.wait_idle().unwrap();
        assert_eq!(to.read::<u32>(0..1024), [7; 1024]);
        assert_eq!(device.retired(), 0);
    });
}

#[test]
fn all_pieces_of_a_frame_keep_alive_what_is_dropped() {
    run_on_all(|device| {
        let mut ring = FrameRing::new(device, 1).unwrap();
        let from = sevens(device);
        let first = readback(device);
        let second = readback(device);
        let mut frame = ring.begin().unwrap();
        let slice = from.whole();
        frame.commands().copy_buffer(slice, first.whole());
        drop(from);
        let piece = frame.flush(None).unwrap();
        frame.wait(piece).unwrap();
        device.run_once("another submit", |_| {}).unwrap();
        frame.commands().copy_buffer(slice, second.whole());
        frame.submit(None).unwrap();
        device.wait_idle().unwrap();
        for readback in [&first, &second] {
            assert_eq!(readback.read::<u32>(0..1024), [7; 1024]);
        }
        assert_eq!(device.retired(), 0);
    });
}

#[test]
fn a_frame_that_is_given_up_keeps_nothing_alive() {
    run_on_all(|device| {
        let mut ring = FrameRing::new(device, 1).unwrap();
        let frame = ring.begin().unwrap();
        drop(sevens(device));
        drop(frame);
        device.wait_idle().unwrap();
        assert_eq!(device.retired(), 0);
    });
}

#[test]
fn what_is_dropped_after_the_last_submit_needs_no_further_one() {
    run_on_all(|device| {
        drop(sevens(device));
        device.wait_idle().unwrap();
        assert_eq!(device.retired(), 0);
    });
}

#[test]
fn large_uploads_are_freed_by_frames_that_do_not_need_them() {
    run_on_all(|device| {
        const WORDS: u32 = 5 << 20;
        let mut ring = FrameRing::new(device, 2).unwrap();
        let to = readback(device);
        let copy = |ring: &mut FrameRing, words: u32| {
            let mut frame = ring.begin().unwrap();
            let from = frame.uploads().push_iter(0..words).unwrap();
            let last = u64::from(words - 1024) * 4;
            frame.commands().copy_buffer(from.part(last, 4096), to.whole());
            frame.submit(None).unwrap();
            device.wait_idle().unwrap();
            assert_eq!(to.read::<u32>(0..1024), Vec::from_iter(words - 1024..words));
            device.memory_use().used_bytes
        };
        let small = [copy(&mut ring, 1024), copy(&mut ring, 1024)][1];
        // A slot keeps its buffer as long as each of its frames needs it.
        let large = [(); 4].map(|()| copy(&mut ring, WORDS));
        assert!(large[0] >= small + u64::from(WORDS) * 4, "{small} {large:?}");
        assert_eq!(large[1..], [large[3]; 3]);
        // The frame of a slot after the first one that does not need it frees it.
        let after = [(); 4].map(|()| copy(&mut ring, 1024));
        assert_eq!(after[3], small, "{after:?}");
    });
}
