//! Impossible commands: an error reports them, and the recording does not reach the driver.

use gpu::{
    Access, BlockingQueryPool, Buffer, BufferSlice, Commands, ComputePipeline, Counting, Device,
    Error, FrameRing, MemoryBarrier, MemoryKind, QueryIndex, QueryRing, Reveal, Spirv,
    StorageLayout, Tick, Timeline, vk,
};
use tests::{Driver, open, run, run_on_all};

/// Creates a pipeline that turns predicates into counts. Its buffers are the predicates, the draws
/// that they decide about, and the counts.
fn compute(device: &Device) -> ComputePipeline {
    let shader = shaders::PREDICATE_COUNTS;
    let spirv = Spirv::from_bytes(shader.name, shader.spirv).unwrap();
    let storage = StorageLayout { buffers: 3, textures: 0, texture_arrays: 0, push_bytes: 12 };
    ComputePipeline::new(device, "counts", &spirv, storage).unwrap()
}

struct Lists {
    results: Buffer,
    decided: Buffer,
    counts: Buffer,
}

impl Lists {
    fn new(device: &Device) -> Self {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC;
        let decided = [[0, 5, Reveal::Draws as u32, 1], [5, 2, Reveal::Boxes as u32, 1]];
        Self {
            results: device.upload("results", &[0u32, 9], usage).unwrap(),
            decided: device.upload("decided", &decided, usage).unwrap(),
            counts: Buffer::new(device, "counts", 8, usage, MemoryKind::Device).unwrap(),
        }
    }

    fn slices(&self) -> [BufferSlice; 3] {
        [self.results.whole(), self.decided.whole(), self.counts.whole()]
    }
}

#[test]
fn commands_that_run_once_bind_what_they_read() {
    run_on_all(|device| {
        let pipeline = compute(device);
        let lists = Lists::new(device);
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let readback = Buffer::new(device, "readback", 8, usage, MemoryKind::ReadBack).unwrap();
        let between = MemoryBarrier::between;
        let record = |commands: &Commands, threshold: u32| {
            commands.bind_compute(&pipeline, &lists.slices());
            commands.push_compute_constants(&pipeline, &[0, 2, threshold]);
            commands.dispatch([1, 1, 1]);
            commands.barrier(between(&[Access::ComputeWrite], &[Access::CopyRead]));
            commands.copy_buffer(lists.counts.whole(), readback.whole());
            commands.barrier(between(&[Access::CopyWrite], &[Access::HostRead]));
        };
        for (threshold, shown) in [(0, [5, 1]), (8, [5, 1]), (9, [0, 0]), (u32::MAX, [0, 0])] {
            device.run_once("counts", |commands| record(commands, threshold)).unwrap();
            // The counts of a range, and of the single command for boxes.
            assert_eq!(readback.read::<u32>(0..2), shown, "{threshold}");
        }
    });
}

#[test]
fn commands_that_run_once_say_what_failed() {
    run(Driver::SwiftShader, |device| {
        let usage = vk::BufferUsageFlags::INDIRECT_BUFFER;
        let draws = device.upload("draws", &[0u32; 5], usage).unwrap();
        let before = device.submitted();
        let error = device
            .run_once("counted", |commands| {
                commands.draw_indirect_count(draws.whole(), draws.whole().part(0, 4));
            })
            .expect_err("an error");
        assert!(matches!(error, Error::Vulkan { .. }), "{error}");
        assert!(error.to_string().contains("vkCmdDrawIndexedIndirectCount"), "{error}");
        assert_eq!(device.submitted(), before);
    });
}

/// Returns the error message of a recording with an impossible command.
fn sentence(device: &Device, record: impl FnOnce(&Commands)) -> String {
    let before = device.submitted();
    let error = device.run_once("wrong", record).expect_err("an error");
    assert!(matches!(error, Error::WrongCommands(_)), "{error}");
    assert_eq!(device.submitted(), before);
    error.to_string()
}

#[test]
fn buffers_and_constants_are_those_of_the_pipeline() {
    run_on_all(|device| {
        let pipeline = compute(device);
        let lists = Lists::new(device);
        let [results, decided, counts] = lists.slices();
        for storage in [&[][..], &[results, decided], &[results, decided, counts, results]] {
            let text = sentence(device, |commands| {
                commands.bind_compute(&pipeline, storage);
                commands.push_compute_constants(&pipeline, &[0u32, 2, 0]);
                commands.dispatch([1, 1, 1]);
            });
            assert!(text.contains("too many or too few buffers"), "{text}");
        }
        let text = sentence(device, |commands| {
            commands.bind_compute(&pipeline, &lists.slices());
            commands.push_compute_constants(&pipeline, &[0u32, 2, 0, 4]);
            commands.dispatch([1, 1, 1]);
        });
        assert!(text.contains("push constants"), "{text}");
    });
}

#[test]
fn no_more_workgroups_than_the_device_takes() {
    run_on_all(|device| {
        let pipeline = compute(device);
        let lists = Lists::new(device);
        let most = device.adapter().limits.max_compute_work_group_count;
        for axis in (0..3).filter(|axis| most[*axis] < u32::MAX) {
            let mut groups = [1; 3];
            groups[axis] = most[axis] + 1;
            let text = sentence(device, |commands| {
                commands.bind_compute(&pipeline, &lists.slices());
                commands.push_compute_constants(&pipeline, &[0u32, 0, 0]);
                commands.dispatch(groups);
                // The first error is reported, not later ones.
                commands.bind_compute(&pipeline, &[]);
            });
            assert!(text.contains("more workgroups"), "{text}");
        }
    });
}

#[test]
fn a_query_is_recorded_once_and_its_result_only_wanted_then() {
    run_on_all(|device| {
        let mut ring = FrameRing::new(device, 1).unwrap();
        let mut queries = QueryRing::<()>::new(device, 1, "test").unwrap();
        let mut pages = BlockingQueryPool::new(device, 1, "pages");
        let scopes: [&[u32]; 4] = [&[0, 1], &[0, 1, 0], &[1], &[]];
        for (scoped, sound) in scopes.into_iter().zip([true, false, false, false]) {
            let mut frame = ring.begin().unwrap();
            queries.begin(&mut frame, &[(); 2]).unwrap();
            for query in scoped {
                queries.scope(frame.commands(), QueryIndex(*query), |_| {});
            }
            queries.resolve(frame.commands(), 0..2);
            let in_ring = frame.submit(None);

            let frame = ring.begin().unwrap();
            pages.begin(frame.slot());
            let taken = pages.take(frame.commands(), 2).unwrap();
            for query in scoped {
                pages.scope(frame.commands(), QueryIndex(*query), Counting::Some, |_| {});
            }
            pages.read_back(frame.commands(), taken);
            for result in [in_ring, frame.submit(None)] {
                assert_eq!(result.is_ok(), sound, "{scoped:?}: {result:?}");
                assert!(sound || matches!(result, Err(Error::WrongCommands(_))), "{result:?}");
            }
        }
        // Queries that were begun for a frame that was given up are not issued in the next frame.
        let mut frame = ring.begin().unwrap();
        queries.begin(&mut frame, &[(); 2]).unwrap();
        drop(frame);
        let frame = ring.begin().unwrap();
        let mut drawn = false;
        queries.scope(frame.commands(), QueryIndex(0), |_| drawn = true);
        queries.resolve(frame.commands(), 0..2);
        frame.submit(None).unwrap();
        assert!(drawn);
        device.wait_idle().unwrap();
    });
}

#[test]
fn a_frame_waits_for_no_other_device() {
    run(Driver::Lavapipe, |device| {
        let (_instance, other) = open(Driver::Lavapipe);
        let elsewhere = Timeline::new(&other, "elsewhere").unwrap();
        let mut ring = FrameRing::new(device, 1).unwrap();
        let error =
            ring.begin().unwrap().submit(Some(elsewhere.at(Tick(1)))).expect_err("an error");
        assert!(matches!(error, Error::Foreign { .. }), "{error}");
    });
}
