//! Commands that cannot be run: an error says so, and nothing of the recording reaches the driver.

use gpu::{
    Access, Buffer, BufferSlice, Commands, ComputePipeline, Device, Error, MemoryBarrier, Place,
    Spirv, StorageLayout, vk,
};
use tests::{Driver, run, run_on_all};

/// Turns words into counts: the words, what they decide, the counts.
fn compute(device: &Device) -> ComputePipeline {
    let bytes = include_bytes!("../../../shaders/predicate_counts.comp.spv");
    let spirv = Spirv::from_bytes("predicate_counts.comp", bytes).unwrap();
    let storage = StorageLayout { buffers: 3, push_bytes: 8 };
    ComputePipeline::new(device, "counts", &spirv, storage).unwrap()
}

struct Lists {
    words: Buffer,
    decided: Buffer,
    counts: Buffer,
}

impl Lists {
    fn new(device: &Device) -> Self {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC;
        Self {
            words: device.upload("words", &[0u32, 9], usage).unwrap(),
            decided: device.upload("decided", &[[0u32, 5, 0, 1], [5, 2, 0, 0]], usage).unwrap(),
            counts: Buffer::new(device, "counts", 8, usage, Place::Device).unwrap(),
        }
    }

    fn slices(&self) -> [BufferSlice; 3] {
        [self.words.whole(), self.decided.whole(), self.counts.whole()]
    }
}

#[test]
fn commands_that_run_once_bind_what_they_read() {
    run_on_all(|device| {
        let (pipeline, lists) = (compute(device), Lists::new(device));
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let home = Buffer::new(device, "home", 8, usage, Place::ReadBack).unwrap();
        let between = MemoryBarrier::between;
        let record = |commands: &Commands| {
            commands.bind_compute(&pipeline, &lists.slices());
            commands.push_compute_constants(&pipeline, &[0u32, 2]);
            commands.dispatch([1, 1, 1]);
            commands.barrier(between(&[Access::ComputeWrite], &[Access::CopyRead]));
            commands.copy_buffer(lists.counts.whole(), home.whole());
            commands.barrier(between(&[Access::CopyWrite], &[Access::HostRead]));
        };
        device.run_once("counts", record).unwrap();
        assert_eq!(home.read::<u32>(0..2), [5, 0]);
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
