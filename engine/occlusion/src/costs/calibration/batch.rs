//! The batches that are timed: many items of one kind and little else.

use cull::{Aabb, Camera, CullView, Projection, SkipTimes};
use glam::Vec3;
use gpu::{
    Access, Buffer, BufferSlice, Commands, FlagRing, Frame, IndirectDraw, Load, MemoryBarrier,
    MemoryKind, PredicationMode, QueryIndex, QueryRing, ResultSource, vk,
};

use super::CalibrationScene;
use crate::costs::skipped_ranges::SkippedRanges;
use crate::error::Error;
use crate::leaf_table::BucketId;
use crate::object_renderer::ObjectRenderer;
use crate::passes::{ComputeTest, ComputeTestIo, OcclusionPasses, ProxyBox, ProxyIo};
use crate::rect::Rect;

/// A number of items of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Batch {
    thing: Thing,
    count: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Thing {
    /// Hidden objects of a triangle each.
    Draws,
    /// Hidden objects of [`PATCH_TRIANGLES`] each.
    Patches,
    /// Draws under a query.
    Queries,
    /// Small hidden boxes under a query.
    QueriedBoxes,
    /// Small hidden boxes with flags.
    Flags,
    /// Large boxes with flags, no fragment of which passes.
    HiddenPixels,
    /// Large boxes with flags, every fragment of which passes.
    FlaggedPixels,
    /// A single draw, since some drivers leave out a rendering without draws.
    Nothing,
    /// Indirect calls of a draw without instances.
    Calls,
    /// Ranges of `width` draws each, all of which an executor skips.
    Ranges { executor: PredicationMode, width: u32 },
    /// Breaks: the end of a rendering and the begin of the next.
    Breaks,
    /// Preparations of the compute tester.
    Grids,
    /// Tests by the compute tester.
    ComputedBoxes,
}

impl Batch {
    pub(super) const DRAWS: Self = Self { thing: Thing::Draws, count: 256 };
    pub(super) const PATCHES: Self = Self { thing: Thing::Patches, count: 24 };
    pub(super) const QUERIES: Self = Self { thing: Thing::Queries, count: 48 };
    pub(super) const QUERIED_BOXES: Self = Self { thing: Thing::QueriedBoxes, count: 48 };
    pub(super) const FLAGS: Self = Self { thing: Thing::Flags, count: 256 };
    pub(super) const HIDDEN_PIXELS: Self = Self { thing: Thing::HiddenPixels, count: 8 };
    pub(super) const FLAGGED_PIXELS: Self = Self { thing: Thing::FlaggedPixels, count: 2 };
    pub(super) const CALLS: Self = Self { thing: Thing::Calls, count: 256 };
    pub(super) const NOTHING: Self = Self { thing: Thing::Nothing, count: 0 };
    pub(super) const BREAKS: Self = Self { thing: Thing::Breaks, count: 4 };
    pub(super) const GRIDS: Self = Self { thing: Thing::Grids, count: 1 };
    pub(super) const COMPUTED_BOXES: Self = Self { thing: Thing::ComputedBoxes, count: 128 };

    pub(super) const ALL: [Self; 11] = [
        Self::DRAWS,
        Self::PATCHES,
        Self::QUERIES,
        Self::QUERIED_BOXES,
        Self::FLAGS,
        Self::HIDDEN_PIXELS,
        Self::FLAGGED_PIXELS,
        Self::CALLS,
        Self::BREAKS,
        Self::GRIDS,
        Self::COMPUTED_BOXES,
    ];

    /// Returns the batches that measure an executor: few ranges, many ranges, and few wide ranges.
    pub(super) fn of_ranges(executor: PredicationMode) -> [Self; 3] {
        let few = SkipTimes::RANGES;
        [(few, 1), (2 * few, 1), (few, SkipTimes::WIDE_DRAWS)]
            .map(|(count, width)| Self { thing: Thing::Ranges { executor, width }, count })
    }

    pub(super) fn count(self) -> u32 {
        self.count
    }

    pub(super) fn doubled(self) -> Self {
        Self { count: 2 * self.count, ..self }
    }
}

/// The tests of a frame: none, or one that breaks the rendering.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TestLoad {
    Nothing,
    Once,
}

/// The triangles of a patch. Half of them face away, as in a solid object.
pub const PATCH_TRIANGLES: u32 = 2 * 16 * 16;

/// The highest number of items in a batch.
const MOST: u32 = 512;

/// The distance of everything from the eye (metres).
const DISTANCE_M: f32 = 10.0;

/// The objects and passes that batches are recorded with.
pub(super) struct Bench<'a> {
    passes: &'a OcclusionPasses,
    objects: &'a mut dyn ObjectRenderer,
    ranges: Vec<SkippedRanges>,
    compute: Option<ComputeTest>,
    results: Buffer,
    queries: QueryRing<()>,
    flags: FlagRing<()>,
    view: CullView,
    /// The draws of a single triangle and of a patch.
    draws: [IndirectDraw; 2],
    /// The buffers that the newest frame reads.
    io: Option<Io>,
}

#[derive(Clone, Copy)]
struct Io {
    draws: BufferSlice,
    small: BufferSlice,
    large: BufferSlice,
}

const DRAW_BYTES: u64 = size_of::<IndirectDraw>() as u64;

impl<'a> Bench<'a> {
    pub(super) fn new(scene: CalibrationScene<'a>) -> Result<Self, Error> {
        let CalibrationScene { device, shaders, passes, executors, objects, draws, .. } = scene;
        let size = objects.target().size();
        let camera = Camera {
            eye: Vec3::ZERO,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(1.0),
            near: 0.1,
        };
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let most = SkipTimes::RANGES * SkipTimes::WIDE_DRAWS;
        let ranges = executors
            .iter()
            .map(|executor| SkippedRanges::new(device, shaders, *executor, draws[0], most));
        Ok(Self {
            ranges: ranges.collect::<Result<_, _>>()?,
            compute: ComputeTest::sized(device, shaders, passes.attachments().samples, size).ok(),
            results: Buffer::new(
                device,
                "calibration results",
                u64::from(MOST) * 4,
                storage,
                MemoryKind::Device,
            )?,
            queries: QueryRing::new(device, 2, "calibration queries")?,
            flags: FlagRing::new(device, 2, ResultSource::Fragments, "calibration flags"),
            view: CullView::new(&camera, size, device.adapter().limits.sub_pixel_precision_bits),
            draws,
            passes,
            objects,
            io: None,
        })
    }

    /// Returns true if the device supports a batch.
    pub(super) fn can(&self, batch: Batch) -> bool {
        match batch.thing {
            Thing::Flags | Thing::HiddenPixels | Thing::FlaggedPixels | Thing::Ranges { .. } => {
                self.passes.proxies.can_flag()
            }
            Thing::Grids | Thing::ComputedBoxes => self.compute.is_some(),
            _ => true,
        }
    }

    /// Returns the number of pixels of a large box: a quarter of the image.
    pub(super) fn large_box_pixels(&self) -> f64 {
        let [width, height] = self.view.size.map(f64::from);
        width * height / 4.0
    }

    /// Writes the data of a batch into the frame's memory.
    pub(super) fn prepare(&mut self, frame: &mut Frame<'_>, batch: Batch) -> Result<(), Error> {
        let count = batch.count.min(MOST) as usize;
        self.queries.begin(frame, &[(); MOST as usize][..count])?;
        self.flags.begin(frame, std::iter::repeat_n((), MOST as usize))?;
        if let Thing::Ranges { executor, width } = batch.thing {
            let results = self.flags.results();
            for ranges in self.ranges.iter_mut().filter(|range| range.predication() == executor) {
                ranges.begin(frame, results, batch.count, width)?;
            }
        }
        let [single, patch] = self.draws;
        let draw = match batch.thing {
            Thing::Patches => patch,
            Thing::Calls => IndirectDraw { instance_count: 0, ..single },
            _ => single,
        };
        let rays = &self.view.rays;
        let face = |share_x: f32, share_y: f32| {
            let half = (rays.right * share_x - rays.down * share_y) * DISTANCE_M;
            let front = Vec3::new(0.0, 0.0, -DISTANCE_M);
            ProxyBox::from(Aabb::new(front - half - Vec3::Z, front + half))
        };
        let pixel = self.view.size.map(|pixels| 2.0 / pixels as f32);
        let small = face(pixel[0], pixel[1]);
        let uploads = frame.uploads();
        self.io = Some(Io {
            draws: uploads.push_iter(std::iter::repeat_n(draw, count.max(1)))?,
            small: uploads.push_iter(std::iter::repeat_n(small, MOST as usize))?,
            large: uploads.push_iter(std::iter::repeat_n(face(0.5, 0.5), MOST as usize))?,
        });
        Ok(())
    }

    /// Records a batch.
    pub(super) fn record(&mut self, commands: &Commands, batch: Batch) {
        let Some(io) = self.io else { return };
        let reset = [Access::FragmentWrite, Access::IndirectRead, Access::ComputeRead];
        commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &reset));
        if let Some(ranges) = self.ranges_of(batch) {
            ranges.record_resolve(commands);
        }
        self.objects.target().prepare(commands);
        // The near plane (1) hides all items. Only pixels that must pass get the far plane (0).
        let depth = if batch.thing == Thing::FlaggedPixels { 0.0 } else { 1.0 };
        let mut from = self.objects.target().render_target(None);
        (from.colour_load, from.depth_load) = (Load::Clear([0.0; 4]), Load::Clear(depth));
        commands.rendering(from, |commands| {
            self.bind_opaque(commands);
            self.record_inside(commands, batch, &io);
        });
        self.record_outside(commands, batch, &io);
        if matches!(batch.thing, Thing::Queries | Thing::QueriedBoxes) {
            self.queries.resolve(commands, 0..batch.count);
        }
    }

    /// Returns the ranges of a batch of ranges.
    fn ranges_of(&self, batch: Batch) -> Option<&SkippedRanges> {
        let Thing::Ranges { executor, .. } = batch.thing else { return None };
        self.ranges.iter().find(|range| range.predication() == executor)
    }

    /// Draws visible patches: in one rendering, or in two renderings with a query in the second.
    pub(super) fn record_load(&mut self, commands: &Commands, load: TestLoad) {
        let Some(io) = self.io else { return };
        let parts = match load {
            TestLoad::Nothing => 1,
            TestLoad::Once => 2,
        };
        let bytes = io.draws.size_bytes / parts / DRAW_BYTES * DRAW_BYTES;
        for part in 0..parts {
            self.objects.target().prepare(commands);
            let clear = (part == 0).then_some([0.0; 4]);
            commands.rendering(self.objects.target().render_target(clear), |commands| {
                self.bind_opaque(commands);
                let draws = io.draws.part(part * bytes, bytes);
                let draw = |commands: &Commands| commands.draw_indirect(draws);
                match part {
                    0 => draw(commands),
                    _ => self.queries.scope(commands, QueryIndex(0), draw),
                }
            });
        }
        if load == TestLoad::Once {
            self.queries.resolve(commands, 0..1);
        }
    }

    fn record_inside(&self, commands: &Commands, batch: Batch, io: &Io) {
        match batch.thing {
            Thing::Draws | Thing::Patches | Thing::Nothing => commands.draw_indirect(io.draws),
            Thing::Queries => {
                for number in 0..batch.count {
                    let draw = io.draws.part(u64::from(number) * DRAW_BYTES, DRAW_BYTES);
                    self.queries.scope(commands, QueryIndex(number), |commands| {
                        commands.draw_indirect(draw);
                    });
                }
            }
            Thing::QueriedBoxes => {
                let proxies = &self.passes.proxies;
                proxies.bind(commands, &ProxyIo { boxes: io.small, flags: None }, &self.view);
                for number in 0..batch.count {
                    self.queries.scope(commands, QueryIndex(number), |commands| {
                        proxies.draw(commands, number);
                    });
                }
            }
            Thing::Flags => self.draw_boxes(commands, batch, io.small),
            Thing::HiddenPixels | Thing::FlaggedPixels => {
                self.draw_boxes(commands, batch, io.large);
            }
            Thing::Calls => {
                for number in 0..u64::from(batch.count) {
                    commands.draw_indirect(io.draws.part(number * DRAW_BYTES, DRAW_BYTES));
                }
            }
            Thing::Ranges { .. } => {
                if let Some(ranges) = self.ranges_of(batch) {
                    ranges.record_draws(commands);
                }
            }
            Thing::Breaks | Thing::Grids | Thing::ComputedBoxes => {}
        }
    }

    fn record_outside(&mut self, commands: &Commands, batch: Batch, io: &Io) {
        match batch.thing {
            Thing::Breaks => {
                for _ in 0..batch.count {
                    let flags =
                        MemoryBarrier::between(&[Access::FragmentWrite], &[Access::IndirectRead]);
                    commands.barrier(flags);
                    self.objects.target().prepare(commands);
                    commands.rendering(self.objects.target().render_target(None), |commands| {
                        self.bind_opaque(commands);
                        commands.draw_indirect(io.draws.part(0, DRAW_BYTES));
                    });
                }
            }
            Thing::Grids | Thing::ComputedBoxes => {
                let Some(compute) = &self.compute else { return };
                let (grids, count) = match batch.thing {
                    Thing::Grids => (batch.count, 1),
                    _ => (1, batch.count),
                };
                for _ in 0..grids {
                    let area = Rect::whole(self.objects.target().size());
                    compute.record_grid(commands, self.objects.target(), area, self.view.depth);
                    let results = self.results.whole();
                    let tests = ComputeTestIo { boxes: io.small, results, first: 0, count };
                    let again = [Access::ComputeWrite];
                    commands.barrier(MemoryBarrier::between(&again, &again));
                    compute.record_tests(commands, &tests, &self.view);
                }
            }
            _ => {}
        }
    }

    fn bind_opaque(&self, commands: &Commands) {
        self.objects.bind(commands, &self.view, BucketId(0));
    }

    fn draw_boxes(&self, commands: &Commands, batch: Batch, boxes: BufferSlice) {
        let io = ProxyIo { boxes, flags: self.flags.results() };
        self.passes.proxies.bind_flags(commands, &io, &self.view);
        self.passes.proxies.draw_all(commands, 0..batch.count);
    }

    /// Returns a batch of visible patches for [`Bench::record_load`].
    pub(super) fn load(patches: u32) -> Batch {
        Batch { thing: Thing::Patches, count: patches }
    }
}
