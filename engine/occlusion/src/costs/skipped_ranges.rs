//! Ranges of draws that depend on results and are drawn by one executor, to measure its costs.

use gpu::{
    Buffer, BufferSlice, Commands, Device, DrawRange, Frame, IndirectDraw, MemoryKind,
    PredicatedRange, Predicates, PredicationMode, ResultSource, Reveal, vk,
};

use crate::error::Error;
use crate::passes::{ListDrawsIo, ListDrawsPass, ListedRange, RANGE_SIZE_BYTES};
use crate::shader_set::ShaderSet;

const SOURCE: ResultSource = ResultSource::Fragments;

/// Ranges of equal draws, each of which depends on a flag, under one executor.
pub struct SkippedRanges {
    predicates: Predicates,
    lists: Option<Lists>,
    /// The ranges of the newest frame.
    count: u32,
}

/// The passes and memory of [`PredicationMode::Compacted`].
struct Lists {
    pass: ListDrawsPass,
    sizes: Buffer,
    commands: Buffer,
    counts: Buffer,
    /// A result that is not zero, for ranges without a flag.
    shown: Buffer,
    /// The buffers of the newest frame.
    io: Option<ListDrawsIo>,
}

impl Lists {
    fn new(device: &Device, shaders: &ShaderSet, most: u32) -> Result<Self, Error> {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::INDIRECT_BUFFER;
        let buffer = |name, bytes| Buffer::new(device, name, bytes, usage, MemoryKind::Device);
        let most = u64::from(most);
        Ok(Self {
            pass: ListDrawsPass::new(device, shaders)?,
            sizes: buffer("measured list sizes", most * RANGE_SIZE_BYTES)?,
            commands: buffer("measured list", most * size_of::<IndirectDraw>() as u64)?,
            counts: buffer("measured list count", 4)?,
            shown: device.upload("measured result", &[1_u32], usage)?,
            io: None,
        })
    }
}

impl SkippedRanges {
    /// Creates the ranges of an executor, with room for `draws` copies of `draw` in total.
    ///
    /// # Errors
    /// A device that lacks what the executor needs or cannot count this number of draws; no memory.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        predication: PredicationMode,
        draw: IndirectDraw,
        draws: u32,
    ) -> Result<Self, Error> {
        let most = draws.max(1);
        let predicates = Predicates::new(device, Some(predication), &vec![draw; most as usize], 2)?;
        let lists = (predication == PredicationMode::Compacted)
            .then(|| Lists::new(device, shaders, most))
            .transpose()?;
        Ok(Self { predicates, lists, count: 0 })
    }

    /// Returns the executor.
    pub fn predication(&self) -> PredicationMode {
        self.predicates.predication()
    }

    /// Begins a frame of `ranges` ranges of `width` draws each. Range `n` is drawn if flag `n` is
    /// not zero; without flags, every range is drawn.
    ///
    /// # Errors
    /// A frame or flags of another device; no memory.
    pub fn begin(
        &mut self,
        frame: &mut Frame<'_>,
        flags: Option<BufferSlice>,
        ranges: u32,
        width: u32,
    ) -> Result<(), Error> {
        self.count = ranges;
        let result_of = |number| if flags.is_some() { number } else { 0 };
        let decided = (0..ranges).map(|number| PredicatedRange {
            result: result_of(number),
            range: DrawRange { first: number * width, count: width },
            reveal: Reveal::Draws,
        });
        self.predicates.begin(frame, SOURCE, flags, decided)?;
        let Some(lists) = &mut self.lists else { return Ok(()) };
        let listed = (0..ranges).map(|number| ListedRange {
            first: number * width,
            count: width,
            source: SOURCE as u32,
            result: result_of(number),
            is_enabled: 0,
            list: 0,
            first_of_list: 0,
            first_command: 0,
        });
        lists.io = match ranges {
            0 => None,
            end => Some(ListDrawsIo {
                ranges: frame.uploads().push_iter(listed)?,
                first: 0,
                end,
                draws: self.predicates.draws(),
                enabled: None,
                results: [None, Some(flags.unwrap_or(lists.shown.whole())), None],
                threshold_samples: 0,
                sizes: lists.sizes.whole(),
                commands: lists.commands.whole(),
                counts: lists.counts.whole(),
            }),
        };
        Ok(())
    }

    /// Records the passes that turn flags into predicates or lists. Outside of rendering.
    pub fn record_resolve(&self, commands: &Commands) {
        match &self.lists {
            Some(lists) => {
                if let Some(io) = &lists.io {
                    lists.pass.record(commands, io);
                }
            }
            None if self.count > 0 => {
                self.predicates.resolve(commands, &[(SOURCE, 0..self.count)], 0);
            }
            None => {}
        }
    }

    /// Records the draws, inside a rendering with a bound pipeline.
    pub fn record_draws(&self, commands: &Commands) {
        match &self.lists {
            Some(lists) => {
                if let Some(io) = &lists.io {
                    commands.draw_indirect_count(io.commands, io.counts);
                }
            }
            None => (0..self.count).for_each(|index| self.predicates.draw(commands, SOURCE, index)),
        }
    }
}
