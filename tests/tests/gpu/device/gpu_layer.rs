//! The GPU layer alone, on both software drivers, under synchronization validation.

mod instance_numbers;
mod lifetimes;
mod misuse;
mod pass_times;
mod predicates;

use std::time::Duration;

use glam::Vec3;
use gpu::{
    Buffer, Device, DeviceOptions, Error, FrameRing, MemoryKind, Predicates, PredicationMode,
    QueryIndex, QueryRing, Target, Tick, Timeline, vk,
};
use occlusion::{ProxyBox, ProxyIo};
use tests::shapes::{DepthBoxes, box_at, proxy_pass, square_view};
use tests::{Driver, instance, messages_of, open, run, run_on_all};

#[test]
fn the_canary_sings() {
    // A copy reads the result of another copy without a barrier in between, an obvious hazard.
    let messages = messages_of(Driver::Lavapipe, |device| {
        let usage = vk::BufferUsageFlags::TRANSFER_SRC;
        let [a, b, c] =
            ["a", "b", "c"].map(|name| device.upload(name, &[7u32; 64], usage).unwrap());
        let record = |commands: &gpu::Commands| {
            commands.copy_buffer(a.whole(), b.whole());
            commands.copy_buffer(b.whole(), c.whole());
        };
        device.run_once("canary", record).unwrap();
    });
    assert!(messages.iter().any(|m| m.id.contains("SYNC-HAZARD")), "{messages:?}");
}

#[test]
#[should_panic(expected = "the validation layer said")]
fn a_message_fails_a_test() {
    run(Driver::Lavapipe, |device| {
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let target = device.upload("not a source", &[0u32; 4], usage).unwrap();
        let record = |commands: &gpu::Commands| {
            commands.copy_buffer(target.whole().part(0, 8), target.whole().part(8, 8));
        };
        device.run_once("a copy out of what may not be read", record).unwrap();
    });
}

/// Draws a wall, and tests a box in front of it and a box behind it, `pairs` times per frame.
fn ask(
    device: &Device,
    frames_in_flight: usize,
    frames: u64,
    pairs: impl Fn(u64) -> usize,
) -> Vec<(u64, bool, u32)> {
    let wall_pass = DepthBoxes::new(device);
    let proxies = proxy_pass(device);
    let view = square_view(device, 64);
    let mut target = Target::new(device, [64, 64], "target").unwrap();
    let mut ring = FrameRing::new(device, frames_in_flight).unwrap();
    let mut queries = QueryRing::<(u64, bool)>::new(device, frames_in_flight, "test").unwrap();
    let boxes = [
        box_at(Vec3::new(0.0, 0.0, -10.0), Vec3::new(4.0, 4.0, 1.0)),
        box_at(Vec3::new(0.0, 0.0, -5.0), Vec3::splat(0.5)),
        box_at(Vec3::new(0.0, 0.0, -15.0), Vec3::splat(0.5)),
    ]
    .map(ProxyBox::from);
    let mut answers = Vec::new();
    for number in 0..frames {
        let mut frame = ring.begin().unwrap();
        let mut collect = |(asked, visible): (u64, bool), samples| {
            assert!(number - asked <= frames_in_flight as u64, "an answer outlived its slot");
            answers.push((asked, visible, samples));
        };
        queries.collect(device.completed().unwrap(), &mut collect);
        let tags: Vec<_> =
            (0..pairs(number)).flat_map(|_| [(number, true), (number, false)]).collect();
        queries.begin(&mut frame, &tags).unwrap();
        let boxes = frame.uploads().push(&boxes).unwrap();
        let commands = frame.commands();
        target.prepare(commands);
        commands.rendering(target.render_target(Some([0.0; 4])), |commands| {
            wall_pass.draw(commands, boxes, &view, 0);
            proxies.bind(commands, &ProxyIo { boxes, flags: None }, &view);
            for (query, (_, visible)) in tags.iter().enumerate() {
                queries.scope(commands, QueryIndex(query as u32), |commands| {
                    proxies.draw(commands, if *visible { 1 } else { 2 });
                });
            }
        });
        queries.resolve(commands, 0..tags.len() as u32);
        queries.read_back(commands);
        let tick = frame.submit(None).unwrap();
        queries.submitted(tick);
    }
    device.wait_idle().unwrap();
    let mut collect = |(asked, visible), samples| answers.push((asked, visible, samples));
    queries.collect(device.completed().unwrap(), &mut collect);
    answers
}

#[test]
fn answers_come_home_once_with_their_tags() {
    run_on_all(|device| {
        for frames_in_flight in 1..=4 {
            let waits = device.wait_counts().other;
            let answers = ask(device, frames_in_flight, 12, |_| 3);
            // One wait: the drain at the end.
            assert_eq!(device.wait_counts().other, waits + 1);
            assert_eq!(answers.len(), 12 * 6);
            for (_, visible, samples) in &answers {
                assert_eq!(*samples > 0, *visible);
            }
            assert!(answers.is_sorted_by_key(|(asked, ..)| *asked), "oldest answers first");
        }
    });
}

#[test]
fn the_ring_grows_and_shrinks_with_what_is_asked() {
    run_on_all(|device| {
        let pairs = |frame: u64| [0, 1, 200, 0, 700, 3][frame as usize % 6];
        let answers = ask(device, 2, 12, pairs);
        assert_eq!(answers.len(), 2 * 2 * (1 + 200 + 700 + 3));
        assert!(answers.iter().all(|(_, visible, samples)| (*samples > 0) == *visible));
    });
}

#[test]
fn the_loop_goes_on_while_the_gpu_is_held_back() {
    run_on_all(|device| {
        const FRAMES_IN_FLIGHT: usize = 3;
        let gate = Timeline::new(device, "gate").unwrap();
        let mut ring = FrameRing::new(device, FRAMES_IN_FLIGHT).unwrap();
        let before = device.completed().unwrap();
        let mut submitted = Vec::new();
        for _ in 0..FRAMES_IN_FLIGHT {
            let frame = ring.begin().unwrap();
            submitted.push(frame.submit(Some(gate.at(Tick(1)))).unwrap());
        }
        // All slots are in flight and not over, so no call has waited for them.
        assert_eq!(device.completed().unwrap(), before);
        assert_eq!(device.wait_counts().other, 0);
        gate.signal(Tick(1)).unwrap();
        ring.begin().unwrap().submit(None).unwrap();
        assert!(device.completed().unwrap() >= submitted[0]);
    });
}

#[test]
fn a_wait_has_a_bound() {
    let instance = instance();
    for driver in Driver::ALL {
        let adapter = instance.pick_adapter(Some(driver.device_name())).unwrap();
        let wait_bound = Duration::from_millis(100);
        let options = DeviceOptions { wait_bound, ..Default::default() };
        let device = Device::new(&instance, &adapter, &options).unwrap();
        let gate = Timeline::new(&device, "gate").unwrap();
        let mut ring = FrameRing::new(&device, 1).unwrap();
        ring.begin().unwrap().submit(Some(gate.at(Tick(1)))).unwrap();
        assert!(matches!(ring.begin().err(), Some(Error::Timeout { .. })));
        gate.signal(Tick(1)).unwrap();
    }
    assert_eq!(instance.validation_log().drain(), []);
}

#[test]
fn upload_memory_holds_what_a_frame_writes() {
    run_on_all(|device| {
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let mut ring = FrameRing::new(device, 2).unwrap();
        let big = 300_000usize;
        for round in 0..5u32 {
            let readback =
                Buffer::new(device, "readback", 4 * big as u64, usage, MemoryKind::ReadBack)
                    .unwrap();
            let small = Buffer::new(device, "small", 16, usage, MemoryKind::ReadBack).unwrap();
            let mut frame = ring.begin().unwrap();
            let items = (0..big as u32).map(|i| i ^ round);
            let large = frame.uploads().push_iter(items.clone()).unwrap();
            let second = frame.uploads().push(&[round; 4]).unwrap();
            frame.commands().copy_buffer(large, readback.whole());
            frame.commands().copy_buffer(second, small.whole());
            frame.submit(None).unwrap();
            device.wait_idle().unwrap();
            assert!(readback.read::<u32>(0..big).iter().copied().eq(items));
            assert_eq!(small.read::<u32>(0..4), [round; 4]);
        }
    });
}

#[test]
fn sizes_beyond_the_device_are_refused_by_name() {
    run_on_all(|device| {
        for size in [[0, 10], [10, 0], [1 << 20, 10], [10, u32::MAX]] {
            let error = Target::new(device, size, "target").err().expect("an error").to_string();
            assert!(error.contains("of the image"), "{error}");
        }
    });
}

#[test]
fn a_way_to_skip_draws_that_the_device_lacks_is_refused() {
    run(Driver::SwiftShader, |device| {
        for predication in
            [PredicationMode::Conditional, PredicationMode::Counts, PredicationMode::Compacted]
        {
            let error = Predicates::new(device, Some(predication), &[], 1).err().expect("an error");
            assert!(error.to_string().contains("SwiftShader"), "{error}");
        }
        let best = Predicates::new(device, None, &[], 1).unwrap();
        assert_eq!(best.predication(), PredicationMode::Instances);
    });
    run(Driver::Lavapipe, |device| {
        let best = Predicates::new(device, None, &[], 1).unwrap();
        assert_eq!(best.predication(), PredicationMode::Conditional);
    });
}

#[test]
fn the_pipeline_cache_survives_and_garbage_does_no_harm() {
    let folder = std::env::temp_dir().join(format!("antumbra-cache-{}", std::process::id()));
    let file = folder.join("pipelines.bin");
    let instance = instance();
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let options = DeviceOptions { pipeline_cache: Some(file.clone()), ..Default::default() };
    let compile = || {
        let device = Device::new(&instance, &adapter, &options).unwrap();
        drop(proxy_pass(&device));
        drop(device);
        std::fs::read(&file).unwrap()
    };
    let first = compile();
    assert!(first.len() >= 32, "at least the header");
    assert_eq!(compile().len(), first.len());
    let mut damaged = first.clone();
    damaged[first.len() / 2..].fill(0);
    for wrong in [b"not a cache", &first[..first.len() / 2], &damaged[..]] {
        std::fs::write(&file, wrong).unwrap();
        assert_eq!(compile().len(), first.len());
    }
    let left: Vec<_> = std::fs::read_dir(&folder).unwrap().collect();
    assert_eq!(left.len(), 1, "nothing half-written is left: {left:?}");
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(instance.validation_log().drain(), []);
}

#[test]
fn a_frame_that_is_dropped_never_happened() {
    run_on_all(|device| {
        let mut ring = FrameRing::new(device, 2).unwrap();
        let _never_submitted = ring.begin().unwrap();
        let tick = ring.begin().unwrap().submit(None).unwrap();
        assert_eq!(tick, device.submitted());
        let _never_submitted = ring.begin().unwrap();
        drop(ring);
        let (_instance, other) = open(Driver::Lavapipe);
        assert_eq!(other.submitted(), Tick::ZERO);
    });
}
