//! Ranges of draws that depend on results and are drawn by one executor, to measure and test it.

use gpu::{
    Buffer, BufferSlice, Commands, Device, DrawRange, Frame, IndirectDraw, MemoryKind,
    PredicatedRange, Predicates, PredicationMode, ResultSource, Reveal, vk,
};

use crate::error::Error;
use crate::passes::{ListDrawsIo, ListDrawsPass, ListedRange, RANGE_SIZE_BYTES};
use crate::shader_set::ShaderSet;

/// Ranges of draws, each of which depends on a result, under one executor.
pub struct SkippedRanges {
    predicates: Predicates,
    lists: Option<Lists>,
    /// The source of the results of the newest frame.
    source: ResultSource,
    /// The ranges of the newest frame.
    count: u32,
}

/// The passes and memory of [`PredicationMode::Compacted`].
struct Lists {
    pass: ListDrawsPass,
    sizes: Buffer,
    commands: Buffer,
    counts: Buffer,
    /// A result that is not zero, for ranges without a result.
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
            commands: buffer("measured list", most * IndirectDraw::BYTES)?,
            counts: buffer("measured list count", 4)?,
            shown: device.upload("measured result", &[1_u32], usage)?,
            io: None,
        })
    }
}

impl SkippedRanges {
    /// Creates the ranges of an executor, which are made of `draws`.
    ///
    /// # Errors
    /// A device that lacks what the executor needs or cannot count this number of draws; no memory.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        predication: PredicationMode,
        draws: &[IndirectDraw],
    ) -> Result<Self, Error> {
        let predicates = Predicates::new(device, Some(predication), draws, 2)?;
        let lists = (predication == PredicationMode::Compacted)
            .then(|| Lists::new(device, shaders, draws.len() as u32))
            .transpose()?;
        Ok(Self { predicates, lists, source: ResultSource::Fragments, count: 0 })
    }

    /// Returns the executor.
    pub fn predication(&self) -> PredicationMode {
        self.predicates.predication()
    }

    /// Begins a frame of `ranges` ranges of `width` draws each. Range `n` is drawn if result `n` of
    /// `source` is not zero; without results, every range is drawn.
    ///
    /// # Errors
    /// A frame or results of another device; no memory.
    pub fn begin(
        &mut self,
        frame: &mut Frame<'_>,
        source: ResultSource,
        results: Option<BufferSlice>,
        ranges: u32,
        width: u32,
    ) -> Result<(), Error> {
        self.source = source;
        self.count = ranges;
        let result_of = |number| if results.is_some() { number } else { 0 };
        let decided = (0..ranges).map(|number| PredicatedRange {
            result: result_of(number),
            range: DrawRange { first: number * width, count: width },
            reveal: Reveal::Draws,
        });
        self.predicates.begin(frame, source, results, decided)?;
        let Some(lists) = &mut self.lists else { return Ok(()) };
        let results = results.unwrap_or(lists.shown.whole());
        let listed = (0..ranges).map(|number| ListedRange {
            first: number * width,
            count: width,
            source: source as u32,
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
                results: ResultSource::ALL.map(|of| (of == source).then_some(results)),
                threshold_samples: 0,
                sizes: lists.sizes.whole(),
                commands: lists.commands.whole(),
                counts: lists.counts.whole(),
            }),
        };
        Ok(())
    }

    /// Records the passes that turn results into predicates or lists. Outside of rendering.
    pub fn record_resolve(&self, commands: &Commands) {
        match &self.lists {
            Some(lists) => {
                if let Some(io) = &lists.io {
                    lists.pass.record(commands, io);
                }
            }
            None if self.count > 0 => {
                self.predicates.resolve(commands, &[(self.source, 0..self.count)], 0);
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
            None => {
                (0..self.count).for_each(|index| self.predicates.draw(commands, self.source, index))
            }
        }
    }
}
