//! The frames that costs are measured with: one item many times and little else.

use std::time::Instant;

use cull::{Aabb, Camera, CullView, Projection, VisibilityTest};
use glam::Vec3;
use gpu::{
    Access, BufferSlice, Commands, Device, FlagRing, FragmentChoice, Frame, FrameRing,
    IndirectDraw, Load, MemoryBarrier, OptionalFeature, PredicationMode, QueryIndex, QueryRing,
    Resubmission, ResultSource,
};
use occlusion::{
    ComputeTest, ComputeTestIo, CostModel, ProxyBox, ProxyIo, ProxyPass, Rect, ShaderSet,
    SkippedRanges,
};
use scene::{Mesh, Scene};

use super::CostListOptions;
use super::item::{BoxSize, CostItem, PredicateResult};
use crate::error::Error;
use crate::probe_recording::{HIDES_ALL, bind, rendering, wait_for_reset};
use crate::renderer::{Renderer, RendererOptions};
use crate::scene_renderer::SceneRenderer;

/// The distance of everything from the eye (metres).
const DISTANCE_M: f32 = 10.0;

const DRAW_BYTES: u64 = size_of::<IndirectDraw>() as u64;

/// The objects and passes that items are recorded with.
pub(super) struct CostBench {
    device: Device,
    renderer: Renderer,
    frames: FrameRing,
    has_timestamps: bool,
    view: CullView,
    most: u32,
    ranges: Vec<SkippedRanges>,
    /// The proxy pass in which all fragments may set flags, on a device that normally chooses one.
    all_fragments: Option<ProxyPass>,
    compute: Option<ComputeTest>,
    queries: QueryRing<()>,
    flags: FlagRing<()>,
    computed: FlagRing<()>,
}

/// The buffers of a frame.
struct Io {
    draws: BufferSlice,
    boxes: BufferSlice,
}

impl CostBench {
    pub(super) fn new(device: &Device, options: &CostListOptions) -> Result<Self, Error> {
        let corners = [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.0, 0.5, 0.0]];
        let mesh = Mesh::of_triangles("triangle", &corners.map(|corner| (corner, [1.0; 3])));
        let size = options.size;
        let plain =
            RendererOptions { size, cost_model: CostModel::Off, ..RendererOptions::default() };
        let renderer = Renderer::new(device, &Scene::single(mesh), &plain)?;
        let projection = Projection::perspective(1.0);
        let eye = Vec3::ZERO;
        let forward = Vec3::NEG_Z;
        let up = Vec3::Y;
        let view = renderer.view_of(&Camera { eye, forward, up, projection, near: 0.1 });
        let draw = renderer.passes.gpu_scene.geometry.mesh_draw(scene::MeshId(0));
        let draw = IndirectDraw { instance_count: 1, ..draw };
        let shaders = ShaderSet::embedded()?;
        let most = options.most.max(1);
        let has = |predication: &PredicationMode| {
            PredicationMode::choose(device, Some(*predication), most.into(), 0).is_ok()
        };
        let ranges = PredicationMode::ALL.into_iter().filter(has);
        let ranges = ranges.map(|range| SkippedRanges::new(device, &shaders, range, draw, most));
        let is_chosen = device.capabilities().has(OptionalFeature::RepresentativeFragments);
        let attachments = renderer.scene.passes().attachments();
        let all_fragments = is_chosen
            .then(|| ProxyPass::of_fragments(device, &shaders, attachments, FragmentChoice::All));
        let has_timestamps = device.capabilities().has(OptionalFeature::Timestamps);
        let mut frames = FrameRing::new(device, 1)?;
        if has_timestamps {
            frames.time_passes()?;
        }
        let flags = |source, name| FlagRing::new(device, 1, source, name);
        Ok(Self {
            ranges: ranges.collect::<Result<_, _>>()?,
            all_fragments: all_fragments.transpose()?,
            compute: ComputeTest::sized(device, &shaders, attachments.samples, size).ok(),
            queries: QueryRing::new(device, 1, "cost queries")?,
            flags: flags(ResultSource::Fragments, "cost flags"),
            computed: flags(ResultSource::Compute, "cost results"),
            device: device.clone(),
            most,
            renderer,
            frames,
            has_timestamps,
            view,
        })
    }

    /// Returns true if the device supports `count` of an item.
    pub(super) fn can(&self, item: CostItem, count: u32) -> bool {
        let can_flag = self.renderer.scene.passes().proxies.can_flag();
        match item {
            CostItem::Predicates(executor, _) => {
                can_flag && self.ranges.iter().any(|range| range.predication() == executor)
            }
            CostItem::Boxes(VisibilityTest::Flag, _) => can_flag,
            CostItem::Boxes(VisibilityTest::Compute, _) => self.compute.is_some(),
            CostItem::BoxesOfAllFragments(_) => can_flag && self.all_fragments.is_some(),
            CostItem::IndirectDraws { per_call } => count >= per_call,
            CostItem::Resets(Resubmission::Never) => {
                self.device.capabilities().has(OptionalFeature::HostQueryReset)
            }
            _ => true,
        }
    }

    /// Returns the time of a frame with `count` of an item (ns), alone on the GPU; for resets by
    /// the CPU, the CPU time.
    pub(super) fn time_ns(&mut self, item: CostItem, count: u32) -> Result<f64, Error> {
        let count = count.min(self.most);
        if let CostItem::Resets(by) = item {
            return self.time_reset_ns(by, count);
        }
        let Self { frames, renderer, .. } = self;
        let mut frame = frames.begin()?;
        let (queries, results) = match item {
            CostItem::Queries | CostItem::Boxes(VisibilityTest::Query, _) => (count, 1),
            _ => (0, count.max(1)),
        };
        self.queries.begin(&mut frame, &vec![(); queries as usize])?;
        self.flags.begin(&frame, std::iter::repeat_n((), results as usize))?;
        self.computed.begin(&frame, std::iter::repeat_n((), results as usize))?;
        begin_ranges(&mut self.ranges, &self.flags, &mut frame, item, count)?;
        let draw = renderer.passes.gpu_scene.geometry.mesh_draw(scene::MeshId(0));
        let draw = IndirectDraw { instance_count: 1, ..draw };
        let bounds = match item {
            CostItem::Boxes(_, BoxSize::Large) | CostItem::BoxesOfAllFragments(BoxSize::Large) => {
                box_of([0.5, 0.5], &self.view)
            }
            _ => box_of(self.view.size.map(|pixels| 2.0 / pixels as f32), &self.view),
        };
        let number = count.max(1) as usize;
        let io = Io {
            draws: frame.uploads().push_iter(std::iter::repeat_n(draw, number))?,
            boxes: frame.uploads().push_iter(std::iter::repeat_n(bounds, number))?,
        };
        wait_for_reset(frame.commands());
        let Renderer { passes, scene, .. } = renderer;
        let recorder = Recorder {
            ranges: &self.ranges,
            compute: self.compute.as_ref(),
            computed: self.computed.results(),
            proxies: match (item, &self.all_fragments) {
                (CostItem::BoxesOfAllFragments(_), Some(proxies)) => proxies,
                _ => &scene.passes().proxies,
            },
            flags: self.flags.results(),
            queries: &self.queries,
            view: &self.view,
        };
        frame.commands().pass("cost", |commands| {
            recorder.record(commands, passes, item, count, &io);
        });
        let began = Instant::now();
        let tick = frame.submit(None)?;
        self.queries.submitted(tick);
        self.flags.submitted(tick);
        self.computed.submitted(tick);
        self.renderer.submitted(tick);
        self.device.wait_idle()?;
        let elapsed_ns = began.elapsed().as_secs_f64() * 1.0e9;
        if self.has_timestamps
            && let Some(time) = self.frames.begin()?.pass_times().first()
        {
            return Ok(time.gpu_ms * 1.0e6);
        }
        Ok(elapsed_ns)
    }

    /// Returns the time of resetting `count` queries (ns): of the call on the CPU, or from submit
    /// to completion.
    fn time_reset_ns(&mut self, by: Resubmission, count: u32) -> Result<f64, Error> {
        let mut frames = FrameRing::new(&self.device, 1)?;
        frames.set_resubmission(by);
        let mut frame = frames.begin()?;
        let tags = vec![(); count as usize];
        let began = Instant::now();
        self.queries.begin(&mut frame, &tags)?;
        let reset_ns = began.elapsed().as_secs_f64() * 1.0e9;
        let began = Instant::now();
        let tick = frame.submit(None)?;
        self.queries.submitted(tick);
        self.device.wait_idle()?;
        match by {
            Resubmission::Never => Ok(reset_ns),
            Resubmission::Allowed => Ok(began.elapsed().as_secs_f64() * 1.0e9),
        }
    }
}

/// Begins a range for each predicated draw.
fn begin_ranges(
    ranges: &mut [SkippedRanges],
    flags: &FlagRing<()>,
    frame: &mut Frame<'_>,
    item: CostItem,
    count: u32,
) -> Result<(), Error> {
    let CostItem::Predicates(executor, result) = item else { return Ok(()) };
    // All flags are zero; ranges without a flag are drawn.
    let results = match result {
        PredicateResult::Skipped => flags.results(),
        PredicateResult::Taken => None,
    };
    for ranges in ranges.iter_mut().filter(|range| range.predication() == executor) {
        ranges.begin(frame, results, count, 1)?;
    }
    Ok(())
}

/// Returns a box whose width and height are a share of the image.
fn box_of(share: [f32; 2], view: &CullView) -> ProxyBox {
    let half = (view.rays.right * share[0] - view.rays.down * share[1]) * DISTANCE_M;
    let front = Vec3::new(0.0, 0.0, -DISTANCE_M);
    ProxyBox::from(Aabb::new(front - half - Vec3::Z, front + half))
}

/// The passes, rings and results that items are recorded with.
struct Recorder<'a> {
    ranges: &'a [SkippedRanges],
    compute: Option<&'a ComputeTest>,
    computed: Option<BufferSlice>,
    proxies: &'a ProxyPass,
    flags: Option<BufferSlice>,
    queries: &'a QueryRing<()>,
    view: &'a CullView,
}

impl Recorder<'_> {
    /// Records `count` of an item, over an image that is hidden entirely at the near plane.
    fn record(
        &self,
        commands: &Commands,
        passes: &mut SceneRenderer,
        item: CostItem,
        count: u32,
        io: &Io,
    ) {
        let ranges = match item {
            CostItem::Predicates(executor, _) => {
                self.ranges.iter().find(|range| range.predication() == executor)
            }
            _ => None,
        };
        if let Some(ranges) = ranges {
            ranges.record_resolve(commands);
        }
        rendering(passes, commands, HIDES_ALL, |passes, commands| {
            bind(passes, commands, self.view);
            match item {
                CostItem::Predicates(..) => {
                    if let Some(ranges) = ranges {
                        ranges.record_draws(commands);
                    }
                }
                CostItem::IndirectDraws { per_call } => {
                    let bytes = u64::from(per_call) * DRAW_BYTES;
                    for call in 0..u64::from(count / per_call.max(1)) {
                        commands.draw_indirect(io.draws.part(call * bytes, bytes));
                    }
                }
                CostItem::Queries => self.each_query(commands, count, |_, _| {}),
                CostItem::Boxes(tester, _) => self.draw_boxes(commands, tester, count, io),
                CostItem::BoxesOfAllFragments(_) => {
                    self.draw_boxes(commands, VisibilityTest::Flag, count, io);
                }
                CostItem::Breaks | CostItem::Resets(_) => {}
            }
        });
        match item {
            CostItem::Breaks => (0..count).for_each(|_| {
                let flags =
                    MemoryBarrier::between(&[Access::FragmentWrite], &[Access::IndirectRead]);
                commands.barrier(flags);
                // Some drivers leave out a rendering without a draw.
                rendering(passes, commands, Load::Keep, |passes, commands| {
                    bind(passes, commands, self.view);
                    commands.draw_indirect(io.draws.part(0, DRAW_BYTES));
                });
            }),
            CostItem::Boxes(VisibilityTest::Compute, _) => {
                self.test_boxes(commands, passes, count, io)
            }
            CostItem::Queries | CostItem::Boxes(VisibilityTest::Query, _) => {
                self.queries.resolve(commands, 0..count);
            }
            _ => {}
        }
    }

    /// Records `count` queries. `record` draws inside of each query, and gets its index.
    fn each_query(&self, commands: &Commands, count: u32, record: impl Fn(&Commands, u32)) {
        for number in 0..count {
            self.queries.scope(commands, QueryIndex(number), |commands| record(commands, number));
        }
    }

    fn draw_boxes(&self, commands: &Commands, tester: VisibilityTest, count: u32, io: &Io) {
        let proxies = ProxyIo { boxes: io.boxes, flags: self.flags };
        match tester {
            VisibilityTest::Flag if count > 0 => {
                self.proxies.bind_flags(commands, &proxies, self.view);
                self.proxies.draw_all(commands, 0..count);
            }
            VisibilityTest::Flag | VisibilityTest::Compute => {}
            _ => {
                self.proxies.bind(commands, &proxies, self.view);
                self.each_query(commands, count, |commands, number| {
                    self.proxies.draw(commands, number);
                });
            }
        }
    }

    fn test_boxes(&self, commands: &Commands, passes: &mut SceneRenderer, count: u32, io: &Io) {
        let (Some(compute), Some(results), 1..) = (self.compute, self.computed, count) else {
            return;
        };
        let area = Rect::whole(self.view.size);
        compute.record_grid(commands, &mut passes.target, area, self.view.depth);
        let tests = ComputeTestIo { boxes: io.boxes, results, first: 0, count };
        compute.record_tests(commands, &tests, self.view);
    }
}
