//! The passes that compact draws: lists of thousands of ranges, in the order of the CPU.

use gpu::{
    Access, Buffer, BufferSlice, Device, Frame, FrameRing, IndirectDraw, MemoryBarrier, MemoryKind,
    ResultSource, vk,
};
use occlusion::{ListDrawsIo, ListDrawsPass, ListedRange, RANGE_SIZE_BYTES, ShaderSet};
use tests::run_on_all;

/// The number of ranges in each list. The first list belongs to another step.
const RANGES: [u32; 5] = [40, 1, 6000, 700, 129];

/// The number of samples that a result must exceed.
const THRESHOLD: u32 = 1;

/// Returns numbers that look random, the same in each run.
fn noise(number: u32) -> u32 {
    let mixed = number.wrapping_mul(0x9E37_79B9);
    (mixed ^ (mixed >> 15)).wrapping_mul(0x85EB_CA6B) >> 8
}

/// The ranges of all lists with the results that decide about them, and the draws of the scene,
/// some of which are empty.
struct Ranges {
    ranges: Vec<ListedRange>,
    draws: Vec<IndirectDraw>,
    enabled: Vec<IndirectDraw>,
    results: [Vec<u32>; ResultSource::ALL.len()],
}

impl Ranges {
    fn new() -> Self {
        let count: u32 = RANGES.iter().sum();
        let mut ranges = Vec::new();
        let mut draws = Vec::new();
        let mut end = 0;
        for (list, count) in (0..).zip(RANGES) {
            let first_of_list = ranges.len() as u32;
            let first_command = end;
            for _ in 0..count {
                let seed = ranges.len() as u32;
                // Some ranges are longer than a workgroup.
                let draw_count = if seed % 500 == 499 { 150 } else { noise(seed) % 4 };
                ranges.push(ListedRange {
                    first: draws.len() as u32,
                    count: draw_count,
                    source: noise(seed + 1) % 3,
                    result: noise(seed + 2) % count,
                    is_enabled: u32::from(noise(seed + 3).is_multiple_of(5)),
                    list,
                    first_of_list,
                    first_command,
                });
                let first = draws.len() as u32;
                draws.extend((first..first + draw_count).map(|number| IndirectDraw {
                    index_count: number,
                    instance_count: u32::from(!noise(number).is_multiple_of(7)),
                    ..IndirectDraw::default()
                }));
                end += draw_count;
            }
        }
        let enabled = draws.iter().map(|draw| IndirectDraw {
            instance_count: u32::from(noise(draw.index_count + 9).is_multiple_of(2)),
            first_instance: 1,
            ..*draw
        });
        let results =
            [5, 6, 7].map(|factor| (0..count).map(|number| noise(number * factor) % 4).collect());
        Self { enabled: enabled.collect(), ranges, draws, results }
    }

    /// Returns the commands of a list, one range after the other.
    fn expected(&self, list: u32) -> Vec<IndirectDraw> {
        let mut commands = Vec::new();
        for drawn in self.ranges.iter().filter(|range| range.list == list) {
            if self.results[drawn.source as usize][drawn.result as usize] > THRESHOLD {
                let draws = if drawn.is_enabled == 1 { &self.enabled } else { &self.draws };
                let range = drawn.first as usize..(drawn.first + drawn.count) as usize;
                commands.extend(draws[range].iter().filter(|draw| draw.instance_count > 0));
            }
        }
        commands
    }

    /// Uploads everything, with room for the lists.
    fn io(&self, device: &Device, frame: &mut Frame<'_>, all: &Buffer, counts: &Buffer) -> Listed {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let bytes = self.ranges.len() as u64 * RANGE_SIZE_BYTES;
        let sizes = Buffer::new(device, "sizes", bytes, usage, MemoryKind::Device).unwrap();
        let uploads = frame.uploads();
        let io = ListDrawsIo {
            ranges: uploads.push(&self.ranges).unwrap(),
            first: RANGES[0],
            end: self.ranges.len() as u32,
            draws: uploads.push(&self.draws).unwrap(),
            enabled: Some(uploads.push(&self.enabled).unwrap()),
            results: std::array::from_fn(|index| Some(uploads.push(&self.results[index]).unwrap())),
            threshold_samples: THRESHOLD,
            sizes: sizes.whole(),
            commands: all.whole(),
            counts: counts.whole(),
        };
        Listed { io, _sizes: sizes }
    }
}

struct Listed {
    io: ListDrawsIo,
    _sizes: Buffer,
}

fn read<T: bytemuck::Pod>(device: &Device, ring: &mut FrameRing, from: BufferSlice) -> Vec<T> {
    let usage = vk::BufferUsageFlags::TRANSFER_DST;
    let to = Buffer::new(device, "readback", from.size_bytes, usage, MemoryKind::ReadBack).unwrap();
    let frame = ring.begin().unwrap();
    frame.commands().copy_buffer(from, to.whole());
    frame.commands().barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]));
    frame.submit(None).unwrap();
    device.wait_idle().unwrap();
    to.read::<T>(0..from.size_bytes as usize / size_of::<T>()).to_vec()
}

#[test]
fn thousands_of_ranges_become_lists_in_their_order() {
    run_on_all(|device| {
        let ranges = Ranges::new();
        let pass = ListDrawsPass::new(device, &ShaderSet::embedded().unwrap()).unwrap();
        let mut ring = FrameRing::new(device, 1).unwrap();
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let buffer = |name, bytes| Buffer::new(device, name, bytes, usage, MemoryKind::Device);
        let all = buffer("lists", size_of_val(&ranges.draws[..]) as u64).unwrap();
        let counts = buffer("counts", RANGES.len() as u64 * 4).unwrap();
        let mut frame = ring.begin().unwrap();
        let listed = ranges.io(device, &mut frame, &all, &counts);
        frame.commands().fill(counts.whole(), 77);
        pass.record(frame.commands(), &listed.io);
        frame.submit(None).unwrap();
        let commands = read::<IndirectDraw>(device, &mut ring, all.whole());
        let counts = read::<u32>(device, &mut ring, counts.whole());
        assert_eq!(counts[0], 77, "a list of an earlier step is left alone");
        for list in 1..RANGES.len() as u32 {
            let first =
                ranges.ranges.iter().find(|range| range.list == list).unwrap().first_command;
            let first = first as usize;
            let count = counts[list as usize] as usize;
            let expected = ranges.expected(list);
            assert_eq!(count, expected.len(), "list {list}");
            assert!(commands[first..first + count] == expected[..], "list {list}");
        }
        assert!(ranges.expected(2).len() > 2000, "{}", ranges.expected(2).len());
    });
}
