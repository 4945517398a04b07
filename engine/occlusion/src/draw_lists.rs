//! The draws of a frame as lists: for hosts that record their draws themselves, with no commands of
//! the engine in between, and for rounds whose draws are compacted.

use std::ops::Range;

use gpu::{
    Buffer, BufferSlice, Device, DrawRange, Frame, IndirectDraw, MemoryKind, OptionalFeature,
    PredicationMode, ResultSource, Reveal, vk,
};

use crate::error::Error;
use crate::leaf_table::{BucketId, LeafTable};
use crate::passes::{ListDrawsIo, ListedRange, RANGE_SIZE_BYTES};
use crate::quirks::DriverQuirks;
use crate::test_layout::{RevealedRange, StepRounds, TestLayout, take_bucket};

/// The indirect draws of one bucket in one phase of a frame. Their buffers live until the frame is
/// over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawList {
    /// The bucket.
    pub bucket: BucketId,
    /// The commands: [`IndirectDraw`]s without gaps.
    pub commands: BufferSlice,
    /// The highest possible number of commands; `commands` has room for them.
    pub most: u32,
    /// The number of commands, 32 bits in a buffer. `None` where the device does not support
    /// counted draws of this size ([`OptionalFeature::DrawIndirectCount`]) or cannot be trusted
    /// with them: then draw all `most` commands, some of which are empty.
    pub count: Option<BufferSlice>,
}

/// The highest number of commands in a list with a count.
#[derive(Clone, Copy, Debug)]
struct CountLimit(u32);

impl CountLimit {
    /// Returns the limit of a device; 0 where draw counts are missing or not trusted.
    fn of(device: &Device, quirks: &DriverQuirks) -> Self {
        let has_counts = device.capabilities().has(OptionalFeature::DrawIndirectCount);
        if has_counts && quirks.allows_executor(PredicationMode::Counts) {
            Self(device.adapter().limits.max_draw_indirect_count)
        } else {
            Self(0)
        }
    }

    fn counts(self, commands: u32) -> bool {
        commands <= self.0
    }
}

/// The lists of the newest frame of a view, and their memory, kept to allocate nothing in the
/// steady state.
#[derive(Default)]
pub(crate) struct DrawLists {
    visible: Vec<DrawList>,
    revealed: Vec<DrawList>,
    /// The bucket of each list of revealed draws, and its place among all commands.
    places: Vec<(BucketId, Range<u32>)>,
    ranges: Vec<ListedRange>,
    /// The steps whose draws are listed; a single step where a host records the draws.
    steps: Vec<ListedStep>,
    /// The memory of each frame in flight.
    slots: Vec<ListMemory>,
}

/// The draws that one rendering of a frame reveals.
#[derive(Clone, Debug)]
pub(crate) struct ListedStep {
    /// The step's part of the ranges of all steps.
    pub(crate) ranges: Range<u32>,
    /// The step's lists, one per bucket.
    lists: Range<usize>,
}

/// The memory that the lists of one frame are written to.
#[derive(Default)]
struct ListMemory {
    commands: Option<Buffer>,
    /// The number of commands of each list.
    counts: Option<Buffer>,
    /// The number of draws of each range, and of the ranges before it.
    sizes: Option<Buffer>,
}

impl DrawLists {
    /// Creates the lists for a number of frames in flight.
    pub(crate) fn new(frames_in_flight: usize) -> Self {
        let slots = (0..frames_in_flight.max(1)).map(|_| ListMemory::default()).collect();
        Self { slots, ..Self::default() }
    }

    /// Returns the draws that are taken as visible.
    pub(crate) fn visible(&self) -> &[DrawList] {
        &self.visible
    }

    /// Returns the draws that tests reveal.
    pub(crate) fn revealed(&self) -> &[DrawList] {
        &self.revealed
    }

    /// Returns a step of a frame whose draws are compacted, with its lists.
    pub(crate) fn step(&self, step: usize) -> Option<(&ListedStep, &[DrawList])> {
        let step = self.steps.get(step)?;
        Some((step, self.revealed.get(step.lists.clone())?))
    }

    /// Lists the draws of a frame: the visible draws, whose commands are in `visible`, and the
    /// draws that tests may reveal. Returns the buffers for the passes that write the latter, if
    /// there are any.
    pub(crate) fn write(
        &mut self,
        frame: &mut Frame<'_>,
        device: &Device,
        layout: &TestLayout,
        leaves: &LeafTable,
        visible: BufferSlice,
        quirks: &DriverQuirks,
    ) -> Result<Option<ListDrawsIo>, Error> {
        let limit = CountLimit::of(device, quirks);
        self.visible.clear();
        // Each list has its own count: on Lavapipe (Mesa 22.3) a draw without a count takes the
        // count of the counted draw before it.
        let buckets = layout.visible.buckets();
        let counts =
            frame.uploads().push_iter(buckets.iter().map(|bucket| bucket.draws.len() as u32))?;
        self.visible.extend((0..).zip(buckets).map(|(list, bucket)| {
            let most = bucket.draws.len() as u32;
            let count = limit.counts(most).then(|| counts.part(list * 4, 4));
            DrawList {
                bucket: bucket.bucket,
                commands: visible.elements::<IndirectDraw>(bucket.draws.clone()),
                most,
                count,
            }
        }));
        self.clear_revealed();
        let round = layout.rounds.first();
        self.lay_out(layout, StepRounds { before: round, known: round });
        self.write_revealed(frame, device, leaves, limit)
    }

    /// Lists the draws that the tests of a frame may reveal, step by step. Returns the buffers for
    /// the passes that write the lists, if there are any.
    pub(crate) fn compact(
        &mut self,
        frame: &mut Frame<'_>,
        device: &Device,
        layout: &TestLayout,
        leaves: &LeafTable,
    ) -> Result<Option<ListDrawsIo>, Error> {
        self.visible.clear();
        self.clear_revealed();
        for step in 0..layout.step_count() {
            self.lay_out(layout, layout.step(step));
        }
        let limit = CountLimit::of(device, &DriverQuirks::default());
        self.write_revealed(frame, device, leaves, limit)
    }

    fn clear_revealed(&mut self) {
        self.revealed.clear();
        self.places.clear();
        self.ranges.clear();
        self.steps.clear();
    }

    /// Reserves the memory of the lists that are laid out.
    fn write_revealed(
        &mut self,
        frame: &mut Frame<'_>,
        device: &Device,
        leaves: &LeafTable,
        limit: CountLimit,
    ) -> Result<Option<ListDrawsIo>, Error> {
        let Some((_, last)) = self.places.last() else { return Ok(None) };
        let slot = frame.slot().0 % self.slots.len();
        let ListMemory { commands: memory, counts, sizes } = &mut self.slots[slot];
        // Hosts may inspect the lists, so they can be the source of copies.
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let bytes = u64::from(last.end) * IndirectDraw::BYTES;
        let all = reserve(device, memory, "listed draws", usage, bytes)?;
        let bytes = self.places.len() as u64 * 4;
        let counts = reserve(device, counts, "list counts", usage, bytes)?;
        let bytes = self.ranges.len() as u64 * RANGE_SIZE_BYTES;
        let sizes = reserve(device, sizes, "list sizes", usage, bytes)?;
        let is_counted = |place: &Range<u32>| limit.counts(place.len() as u32);
        if !self.places.iter().all(|(_, place)| is_counted(place)) {
            frame.commands().fill(all, 0);
        }
        let lists = self.places.iter().enumerate();
        self.revealed.extend(lists.map(|(list, (bucket, place))| DrawList {
            bucket: *bucket,
            commands: all.elements::<IndirectDraw>(place.clone()),
            most: place.len() as u32,
            count: is_counted(place).then(|| counts.part(list as u64 * 4, 4)),
        }));
        Ok(Some(ListDrawsIo {
            ranges: frame.uploads().push(&self.ranges)?,
            first: 0,
            end: self.ranges.len() as u32,
            draws: leaves.predicates.draws(),
            enabled: None,
            results: [None; ResultSource::ALL.len()],
            threshold_samples: 0,
            sizes,
            commands: all,
            counts,
        }))
    }

    /// Lays out the ranges of a step, bucket by bucket, in the order of their tests: the leaves
    /// that boxes of the round `before` enable, and the ranges that the `known` round reveals.
    fn lay_out(&mut self, layout: &TestLayout, rounds: StepRounds<'_>) {
        let mut enabled = layout.revealed(rounds.before, Reveal::EnabledDraws);
        let mut whole = layout.revealed(rounds.known, Reveal::Draws);
        let first = |list: &[RevealedRange]| list.first().map(|first| first.bucket);
        let mut end = self.places.last().map_or(0, |(_, place)| place.end);
        let first_range = self.ranges.len() as u32;
        let first_place = self.places.len();
        while let Some(bucket) = [enabled, whole].into_iter().filter_map(first).min() {
            let list = self.places.len() as u32;
            let first_of_list = self.ranges.len() as u32;
            let first_command = end;
            for (is_enabled, revealed) in [(1, &mut enabled), (0, &mut whole)] {
                for range in take_bucket(revealed, bucket) {
                    let Some(decided) = layout.decided(range.source).get(range.predicate as usize)
                    else {
                        continue;
                    };
                    let DrawRange { first, count } = decided.range;
                    let source = range.source as u32;
                    self.ranges.push(ListedRange {
                        first,
                        count,
                        source,
                        result: decided.result,
                        is_enabled,
                        list,
                        first_of_list,
                        first_command,
                    });
                    end += count;
                }
            }
            self.places.push((bucket, first_command..end));
        }
        self.steps.push(ListedStep {
            ranges: first_range..self.ranges.len() as u32,
            lists: first_place..self.places.len(),
        });
    }
}

/// Returns a buffer of at least this size, a new one if necessary. The frame that used it is over.
fn reserve(
    device: &Device,
    memory: &mut Option<Buffer>,
    name: &str,
    usage: vk::BufferUsageFlags,
    bytes: u64,
) -> Result<BufferSlice, Error> {
    if let Some(buffer) = memory.as_ref().filter(|buffer| buffer.size_bytes() >= bytes) {
        return Ok(buffer.whole().part(0, bytes));
    }
    let buffer = Buffer::new(device, name, bytes.next_power_of_two(), usage, MemoryKind::Device)?;
    Ok(memory.insert(buffer).whole().part(0, bytes))
}
