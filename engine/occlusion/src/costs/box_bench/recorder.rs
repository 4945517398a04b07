//! Records the frames of a bench.

use cull::{Aabb, Camera, CullView, Projection, VisibilityTest};
use glam::Vec3;
use gpu::{
    Access, Buffer, BufferSlice, Commands, FlagRing, Frame, IndirectDraw, Load, MemoryBarrier,
    MemoryKind, QueryIndex, QueryRing, ResultSource, vk,
};

use super::{BenchItem, BoxSize, CalibrationScene, PredicateResult};
use crate::costs::skipped_ranges::SkippedRanges;
use crate::error::Error;
use crate::leaf_table::BucketId;
use crate::object_renderer::ObjectRenderer;
use crate::passes::{ComputeTest, ComputeTestIo, OcclusionPasses, ProxyBox, ProxyIo, ProxyPass};
use crate::rect::Rect;

/// The distance of all boxes from the eye (metres).
const DISTANCE_M: f32 = 10.0;

/// The objects and passes that items are recorded with.
pub(in crate::costs) struct BoxRecorder<'a> {
    pub(super) passes: &'a OcclusionPasses,
    /// The proxy pass in which all fragments may set flags, on a device that normally chooses one.
    pub(super) all_fragments: Option<ProxyPass>,
    objects: &'a mut dyn ObjectRenderer,
    ranges: Vec<SkippedRanges>,
    compute: Option<ComputeTest>,
    computed: Buffer,
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
    boxes: BufferSlice,
}

impl<'a> BoxRecorder<'a> {
    pub(super) fn new(scene: CalibrationScene<'a>, most: u32) -> Result<Self, Error> {
        let CalibrationScene { device, shaders, passes, executors, objects, draws, .. } = scene;
        let size = objects.target().size();
        let camera = Camera {
            eye: Vec3::ZERO,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(1.0),
            near: 0.1,
        };
        let ranged = vec![draws[0]; most as usize];
        let ranges = executors
            .iter()
            .map(|executor| SkippedRanges::new(device, shaders, *executor, &ranged));
        Ok(Self {
            ranges: ranges.collect::<Result<_, _>>()?,
            compute: ComputeTest::sized(device, shaders, passes.attachments().samples, size).ok(),
            computed: Buffer::new(
                device,
                "bench results",
                u64::from(most) * 4,
                vk::BufferUsageFlags::STORAGE_BUFFER,
                MemoryKind::Device,
            )?,
            queries: QueryRing::new(device, 2, "bench queries")?,
            flags: FlagRing::new(device, 2, ResultSource::Fragments, "bench flags"),
            view: CullView::new(&camera, size, device.adapter().limits.sub_pixel_precision_bits),
            all_fragments: None,
            draws,
            passes,
            objects,
            io: None,
        })
    }

    pub(super) fn can(&self, item: BenchItem) -> bool {
        let can_flag = self.passes.proxies.can_flag();
        match item {
            BenchItem::Ranges { .. } => can_flag && self.ranges_of(item).is_some(),
            BenchItem::Boxes(VisibilityTest::Flag, _) | BenchItem::VisibleBoxes => can_flag,
            BenchItem::BoxesOfAllFragments(_) => can_flag && self.all_fragments.is_some(),
            BenchItem::Boxes(VisibilityTest::Compute, _) | BenchItem::Grids => {
                self.compute.is_some()
            }
            _ => true,
        }
    }

    /// Returns the number of pixels of a large box: a quarter of the image.
    pub(in crate::costs) fn large_box_pixels(&self) -> f64 {
        let [width, height] = self.view.size.map(f64::from);
        width * height / 4.0
    }

    /// Writes the data of `count` of an item into the frame's memory.
    pub(in crate::costs) fn prepare(
        &mut self,
        frame: &mut Frame<'_>,
        item: BenchItem,
        count: u32,
    ) -> Result<(), Error> {
        let number = count.max(1) as usize;
        self.queries.begin(frame, &vec![(); if is_queried(item) { number } else { 1 }])?;
        self.flags.begin(frame, std::iter::repeat_n((), number))?;
        if let BenchItem::Ranges { executor, width, result } = item {
            // All flags are zero; ranges without a flag are drawn.
            let results = match result {
                PredicateResult::Skipped => self.flags.results(),
                PredicateResult::Taken => None,
            };
            for ranges in self.ranges.iter_mut().filter(|range| range.predication() == executor) {
                ranges.begin(frame, ResultSource::Fragments, results, count, width)?;
            }
        }
        let [single, patch] = self.draws;
        let draw = match item {
            BenchItem::Patches => patch,
            BenchItem::EmptyCalls => IndirectDraw { instance_count: 0, ..single },
            _ => single,
        };
        let share = match item {
            BenchItem::VisibleBoxes
            | BenchItem::BoxesOfAllFragments(BoxSize::Large)
            | BenchItem::Boxes(_, BoxSize::Large) => [0.5, 0.5],
            _ => self.view.size.map(|pixels| 2.0 / pixels as f32),
        };
        let rays = &self.view.rays;
        let half = (rays.right * share[0] - rays.down * share[1]) * DISTANCE_M;
        let front = Vec3::new(0.0, 0.0, -DISTANCE_M);
        let bounds = ProxyBox::from(Aabb::new(front - half - Vec3::Z, front + half));
        let uploads = frame.uploads();
        self.io = Some(Io {
            draws: uploads.push_iter(std::iter::repeat_n(draw, number))?,
            boxes: uploads.push_iter(std::iter::repeat_n(bounds, number))?,
        });
        Ok(())
    }

    pub(super) fn record(&mut self, commands: &Commands, item: BenchItem, count: u32) {
        let Some(io) = self.io else { return };
        wait_for_reset(commands);
        if let Some(ranges) = self.ranges_of(item) {
            ranges.record_resolve(commands);
        }
        self.objects.target().prepare(commands);
        // The near plane (1) hides all items. Only pixels that must pass get the far plane (0).
        let depth = if item == BenchItem::VisibleBoxes { 0.0 } else { 1.0 };
        let mut target = self.objects.target().render_target(None);
        (target.colour_load, target.depth_load) = (Load::Clear([0.0; 4]), Load::Clear(depth));
        commands.rendering(target, |commands| {
            self.bind_opaque(commands);
            self.record_inside(commands, item, count, &io);
        });
        match item {
            BenchItem::Breaks => self.record_breaks(commands, count, &io),
            BenchItem::Grids => {
                for _ in 0..count {
                    self.test_by_compute(commands, 1, &io);
                }
            }
            BenchItem::Boxes(VisibilityTest::Compute, _) if count > 0 => {
                self.test_by_compute(commands, count, &io);
            }
            _ if is_queried(item) => self.queries.resolve(commands, 0..count),
            _ => {}
        }
    }

    /// Draws visible patches: in one rendering, or in two renderings with a query in the second.
    pub(in crate::costs) fn record_load(&mut self, commands: &Commands, load: TestLoad) {
        let Some(io) = self.io else { return };
        let parts = match load {
            TestLoad::Nothing => 1,
            TestLoad::Once => 2,
        };
        let count = (io.draws.size_bytes / IndirectDraw::BYTES) as u32 / parts;
        for part in 0..parts {
            self.objects.target().prepare(commands);
            let clear = (part == 0).then_some([0.0; 4]);
            commands.rendering(self.objects.target().render_target(clear), |commands| {
                self.bind_opaque(commands);
                let draws = io.draws.elements::<IndirectDraw>(part * count..(part + 1) * count);
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

    fn ranges_of(&self, item: BenchItem) -> Option<&SkippedRanges> {
        let BenchItem::Ranges { executor, .. } = item else { return None };
        self.ranges.iter().find(|range| range.predication() == executor)
    }

    fn record_inside(&self, commands: &Commands, item: BenchItem, count: u32, io: &Io) {
        let draw = |first: u32, count: u32| {
            commands.draw_indirect(io.draws.elements::<IndirectDraw>(first..first + count));
        };
        let proxies = &self.passes.proxies;
        match item {
            BenchItem::Nothing => draw(0, 1),
            BenchItem::Patches => draw(0, count),
            BenchItem::Draws { per_call } => {
                let per_call = per_call.clamp(1, count.max(1));
                (0..count / per_call).for_each(|call| draw(call * per_call, per_call));
            }
            BenchItem::EmptyCalls => (0..count).for_each(|number| draw(number, 1)),
            BenchItem::Ranges { .. } => {
                if let Some(ranges) = self.ranges_of(item) {
                    ranges.record_draws(commands);
                }
            }
            BenchItem::EmptyQueries => self.each_query(commands, count, |_| {}),
            BenchItem::QueriedDraws => self.each_query(commands, count, |number| draw(number, 1)),
            BenchItem::Boxes(VisibilityTest::Query, _) => {
                let io = ProxyIo { boxes: io.boxes, flags: None };
                proxies.bind(commands, &io, &self.view);
                self.each_query(commands, count, |number| proxies.draw(commands, number));
            }
            BenchItem::Boxes(VisibilityTest::Flag, _) | BenchItem::VisibleBoxes => {
                self.draw_flagged(commands, proxies, count, io);
            }
            BenchItem::BoxesOfAllFragments(_) => {
                let proxies = self.all_fragments.as_ref().unwrap_or(proxies);
                self.draw_flagged(commands, proxies, count, io);
            }
            BenchItem::Boxes(..) | BenchItem::Grids | BenchItem::Breaks | BenchItem::Resets(_) => {}
        }
    }

    /// Records `count` queries. `record` draws inside of each query, and gets its index.
    fn each_query(&self, commands: &Commands, count: u32, record: impl Fn(u32)) {
        for number in 0..count {
            self.queries.scope(commands, QueryIndex(number), |_| record(number));
        }
    }

    fn draw_flagged(&self, commands: &Commands, proxies: &ProxyPass, count: u32, io: &Io) {
        if count > 0 {
            let io = ProxyIo { boxes: io.boxes, flags: self.flags.results() };
            proxies.bind_flags(commands, &io, &self.view);
            proxies.draw_all(commands, 0..count);
        }
    }

    fn record_breaks(&mut self, commands: &Commands, count: u32, io: &Io) {
        for _ in 0..count {
            let flags = MemoryBarrier::between(&[Access::FragmentWrite], &[Access::IndirectRead]);
            commands.barrier(flags);
            self.objects.target().prepare(commands);
            commands.rendering(self.objects.target().render_target(None), |commands| {
                self.bind_opaque(commands);
                commands.draw_indirect(io.draws.elements::<IndirectDraw>(0..1));
            });
        }
    }

    /// Prepares the compute tester, and tests `count` boxes.
    fn test_by_compute(&mut self, commands: &Commands, count: u32, io: &Io) {
        let Some(compute) = &self.compute else { return };
        let area = Rect::whole(self.objects.target().size());
        compute.record_grid(commands, self.objects.target(), area, self.view.depth);
        let again = [Access::ComputeWrite];
        commands.barrier(MemoryBarrier::between(&again, &again));
        let results = self.computed.whole();
        let tests = ComputeTestIo { boxes: io.boxes, results, first: 0, count };
        compute.record_tests(commands, &tests, &self.view);
    }

    fn bind_opaque(&self, commands: &Commands) {
        self.objects.bind(commands, &self.view, BucketId(0));
    }
}

/// The tests of a frame of patches: none, or one that breaks the rendering.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::costs) enum TestLoad {
    Nothing,
    Once,
}

fn is_queried(item: BenchItem) -> bool {
    use BenchItem::{Boxes, EmptyQueries, QueriedDraws};
    matches!(item, EmptyQueries | QueriedDraws | Boxes(VisibilityTest::Query, _))
}

/// Waits until the results of the frame have been cleared.
fn wait_for_reset(commands: &Commands) {
    let reset =
        [Access::FragmentWrite, Access::IndirectRead, Access::ComputeRead, Access::ComputeWrite];
    commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &reset));
}
