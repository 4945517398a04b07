//! The probe: frames of boxes in separate cells, drawn and tested without a plan, with one tester
//! and one executor at a time.

use std::ops::Range;

use cull::CullView;
use gpu::{
    Access, BufferSlice, Commands, Counting, Device, FlagRing, IndirectDraw, Load, MemoryBarrier,
    OptionalFeature, PredicationMode, QueryIndex, QueryRing, Readback, ResultSource,
};
use occlusion::{
    BucketId, ComputeTest, ComputeTestIo, CostModel, ObjectRenderer, ProxyBox, ProxyIo, ProxyPass,
    Rect, ShaderSet, SkippedRanges,
};

use super::probe_scene::{self, PROBES, SIZE, TWINS};
use crate::error::Error;
use crate::renderer::{Renderer, RendererOptions};
use crate::resources::object_bounds::object_bounds;
use crate::scene_renderer::SceneRenderer;
use crate::views::{FrameRequest, finish_image};

/// The number of draws per predicate.
pub(super) const PER_DECISION: usize = 4;

/// The number of consecutive frames whose results are read late.
const LATE_FRAMES: u32 = 8;

/// The number of queries in such a frame.
const LATE_QUERIES: u32 = 32;

/// The depth that hides everything, and the depth that hides nothing.
const HIDES_ALL: f32 = 1.0;
const HIDES_NOTHING: f32 = 0.0;

/// The boxes on a device, with the passes that draw and test them.
pub(super) struct Probe {
    renderer: Renderer,
    device: Device,
    view: CullView,
    /// The draws of the objects, followed by the draws of their twins.
    draws: Vec<IndirectDraw>,
    boxes: Vec<ProxyBox>,
    image: Readback,
}

/// The samples that queries counted, for each object.
#[derive(Clone, Debug, Default)]
pub(super) struct QueriedSamples {
    /// The samples of the object itself.
    pub objects: Vec<u32>,
    /// The samples of its proxy in front of the object, within the object's area.
    pub proxies: Vec<u32>,
    /// The samples of its proxy alone, within the object's area.
    pub alone: Vec<u32>,
    /// The samples of its proxy, within the object's area, over a depth that hides everything.
    pub hidden: Vec<u32>,
}

/// The results of a tester for the proxy of each object: in front of the object, and over a depth
/// that hides everything.
#[derive(Clone, Debug, Default)]
pub(super) struct TestedProxies {
    pub shown: Vec<u32>,
    pub hidden: Vec<u32>,
}

impl Probe {
    /// Creates the boxes and the passes of `options`.
    pub(super) fn new(device: &Device, options: &RendererOptions) -> Result<Self, Error> {
        let scene = probe_scene::probes();
        let options = RendererOptions { size: SIZE, cost_model: CostModel::Off, ..options.clone() };
        let renderer = Renderer::new(device, &scene, &options)?;
        let view = renderer.view_of(&probe_scene::camera());
        let draws = (0..(PROBES + TWINS) as u32).map(|object| {
            let leaf =
                renderer.scene.hierarchy().leaf_of(cull::ObjectId(object)).map_or(0, |leaf| leaf.0);
            let mesh = renderer.passes.gpu_scene.geometry.mesh_draw(scene::MeshId(0));
            IndirectDraw { first_instance: leaf, instance_count: 1, ..mesh }
        });
        let boxes = object_bounds(&scene)?.into_iter().take(PROBES);
        let boxes = boxes.filter_map(|bounds| view.margin.proxy(&bounds)).map(ProxyBox::from);
        Ok(Self {
            draws: draws.collect(),
            boxes: boxes.collect(),
            device: device.clone(),
            image: Readback::new(device, SIZE)?,
            view,
            renderer,
        })
    }

    /// Returns true if queries count samples exactly on this device.
    pub(super) fn can_count(&self) -> bool {
        self.device.capabilities().has(OptionalFeature::PreciseQueries)
    }

    /// Returns the image of a frame of frustum culling.
    pub(super) fn whole_image(&mut self) -> Result<Vec<u8>, Error> {
        let mut state = self.renderer.new_view()?;
        let request = FrameRequest {
            image: Some(&self.image),
            ..FrameRequest::new(cull::Strategy::FRUSTUM, probe_scene::camera())
        };
        self.renderer.render(&mut state, request)?;
        self.renderer.wait_idle(&mut state)?;
        self.rgba()
    }

    fn rgba(&self) -> Result<Vec<u8>, Error> {
        Ok(self.image.rgba8()?.to_vec())
    }

    /// Returns the image of the draws of these objects, with one call per range.
    pub(super) fn image_of(&mut self, calls: &[Range<usize>]) -> Result<Vec<u8>, Error> {
        let Self { renderer, view, draws, image, .. } = self;
        let Renderer { frames, passes, .. } = renderer;
        let mut frame = frames.begin()?;
        let all = frame.uploads().push(draws)?;
        frame.commands().pass("self-test order", |commands| {
            rendering(passes, commands, HIDES_NOTHING, |passes, commands| {
                bind(passes, commands, view);
                for call in calls {
                    let draws = call.start as u32..call.end as u32;
                    commands.draw_indirect(all.elements::<IndirectDraw>(draws));
                }
            });
        });
        finish_image(&mut frame, passes, None, Some(image))?;
        let tick = frame.submit(None)?;
        renderer.submitted(tick);
        self.device.wait_idle()?;
        self.rgba()
    }

    /// Counts the samples of objects and proxies by queries. Proxies are clipped to `areas`, the
    /// areas of the objects.
    pub(super) fn by_queries(&mut self, areas: &[Rect]) -> Result<QueriedSamples, Error> {
        let mut queries = QueryRing::new(&self.device, 1, "self-test queries")?;
        if self.can_count() {
            queries.set_counting(Counting::Samples);
        }
        let Self { renderer, device, view, draws, boxes, .. } = self;
        let count = boxes.len();
        let Renderer { frames, passes, scene, .. } = renderer;
        let mut frame = frames.begin()?;
        queries.begin(&mut frame, &vec![(); 4 * count])?;
        let draws = frame.uploads().push(draws)?;
        let io = ProxyIo { boxes: frame.uploads().push(boxes)?, flags: None };
        let proxies = &scene.passes().proxies;
        let test = |commands: &Commands, first: usize| {
            proxies.bind(commands, &io, &*view);
            for (number, area) in (0..count as u32).zip(areas) {
                let query = QueryIndex(first as u32 + number);
                commands.clip(area.origin, area.size);
                queries.scope(commands, query, |commands| proxies.draw(commands, number));
            }
        };
        frame.commands().pass("self-test queries", |commands| {
            rendering(passes, commands, HIDES_NOTHING, |passes, commands| {
                bind(passes, commands, view);
                for number in 0..count as u32 {
                    let draw = draws.elements::<IndirectDraw>(number..number + 1);
                    queries.scope(commands, QueryIndex(number), |commands| {
                        commands.draw_indirect(draw);
                    });
                }
                test(commands, count);
            });
            for (depth, first) in [(HIDES_NOTHING, 2 * count), (HIDES_ALL, 3 * count)] {
                rendering(passes, commands, depth, |_, commands| test(commands, first));
            }
        });
        queries.resolve(frame.commands(), 0..4 * count as u32);
        queries.read_back(frame.commands());
        let tick = frame.submit(None)?;
        queries.submitted(tick);
        renderer.submitted(tick);
        device.wait_idle()?;
        let mut samples = Vec::new();
        queries.collect(device.completed()?, |(), found| samples.push(found));
        let part = |number| samples.iter().copied().skip(number * count).take(count).collect();
        Ok(QueriedSamples { objects: part(0), proxies: part(1), alone: part(2), hidden: part(3) })
    }

    /// Tests proxies by flags; `None` if the device does not support them.
    pub(super) fn by_flags(&mut self) -> Result<Option<TestedProxies>, Error> {
        let Self { renderer, device, view, draws, boxes, .. } = self;
        let Renderer { frames, passes, scene, .. } = renderer;
        let proxies = &scene.passes().proxies;
        if !proxies.can_flag() {
            return Ok(None);
        }
        let mut flags = FlagRing::new(device, 1, ResultSource::Fragments, "self-test flags");
        let count = boxes.len();
        let mut frame = frames.begin()?;
        flags.begin(&frame, std::iter::repeat_n((), 2 * count))?;
        let draws = frame.uploads().push(draws)?;
        let doubled = [&boxes[..], &boxes[..]].concat();
        let io = ProxyIo { boxes: frame.uploads().push(&doubled)?, flags: flags.results() };
        frame.commands().pass("self-test flags", |commands| {
            wait_for_reset(commands);
            rendering(passes, commands, HIDES_NOTHING, |passes, commands| {
                draw_objects(passes, commands, view, draws);
                proxies.bind_flags(commands, &io, &*view);
                proxies.draw_all(commands, 0..count as u32);
            });
            rendering(passes, commands, HIDES_ALL, |_, commands| {
                proxies.bind_flags(commands, &io, &*view);
                proxies.draw_all(commands, count as u32..2 * count as u32);
            });
        });
        flags.read_back(frame.commands());
        let tick = frame.submit(None)?;
        flags.submitted(tick);
        renderer.submitted(tick);
        device.wait_idle()?;
        tested(&mut flags, device, count).map(Some)
    }

    /// Tests proxies by the compute tester; `None` if the device does not support it.
    pub(super) fn by_compute(
        &mut self,
        shaders: &ShaderSet,
    ) -> Result<Option<TestedProxies>, Error> {
        let Self { renderer, device, view, draws, boxes, .. } = self;
        let Renderer { frames, passes, scene, .. } = renderer;
        if !scene.passes().testers(device, &passes.target).compute {
            return Ok(None);
        }
        let compute =
            ComputeTest::sized(device, shaders, passes.target.attachments().samples, SIZE)?;
        let mut results = FlagRing::new(device, 1, ResultSource::Compute, "self-test results");
        let count = boxes.len();
        let mut frame = frames.begin()?;
        results.begin(&frame, std::iter::repeat_n((), 2 * count))?;
        let draws = frame.uploads().push(draws)?;
        let boxes = frame.uploads().push(&[&boxes[..], &boxes[..]].concat())?;
        let Some(written) = results.results() else { return Ok(None) };
        frame.commands().pass("self-test compute", |commands| {
            wait_for_reset(commands);
            for (depth, first) in [(HIDES_NOTHING, 0), (HIDES_ALL, count as u32)] {
                rendering(passes, commands, depth, |passes, commands| {
                    if depth == HIDES_NOTHING {
                        draw_objects(passes, commands, view, draws);
                    }
                });
                let area = Rect::whole(SIZE);
                compute.record_grid(commands, &mut passes.target, area, view.depth);
                let again = [Access::ComputeWrite];
                commands.barrier(MemoryBarrier::between(&again, &again));
                let io = ComputeTestIo { boxes, results: written, first, count: count as u32 };
                compute.record_tests(commands, &io, view);
            }
        });
        results.read_back(frame.commands());
        let tick = frame.submit(None)?;
        results.submitted(tick);
        renderer.submitted(tick);
        device.wait_idle()?;
        tested(&mut results, device, count).map(Some)
    }

    /// Returns the image of all objects, in ranges of [`PER_DECISION`]. Tests of `source` enable
    /// the ranges with even numbers. `None` if there is no such tester.
    pub(super) fn predicated(
        &mut self,
        executor: PredicationMode,
        source: ResultSource,
        shaders: &ShaderSet,
    ) -> Result<Option<Vec<u8>>, Error> {
        if source == ResultSource::Fragments && !self.renderer.scene.passes().proxies.can_flag() {
            return Ok(None);
        }
        let decisions = PROBES / PER_DECISION;
        let draws = self.draws.get(..PROBES).unwrap_or_default();
        let mut ranges = SkippedRanges::new(&self.device, shaders, executor, draws)?;
        let mut queries = QueryRing::new(&self.device, 1, "self-test predicates")?;
        let mut flags = FlagRing::new(&self.device, 1, ResultSource::Fragments, "self-test flags");
        let Self { renderer, view, boxes, image, .. } = self;
        let Renderer { frames, passes, scene, .. } = renderer;
        let mut frame = frames.begin()?;
        queries.begin(&mut frame, &vec![(); decisions])?;
        flags.begin(&frame, std::iter::repeat_n((), decisions))?;
        let results = match source {
            ResultSource::Queries => queries.results(),
            _ => flags.results(),
        };
        let numbers = 0..decisions as u32;
        ranges.begin(&mut frame, source, results, numbers.end, PER_DECISION as u32)?;
        let io = ProxyIo { boxes: frame.uploads().push(boxes)?, flags: flags.results() };
        let proxies = &scene.passes().proxies;
        frame.commands().pass("self-test predicates", |commands| {
            wait_for_reset(commands);
            rendering(passes, commands, HIDES_NOTHING, |_, commands| {
                test_even(proxies, &io, commands, view, &queries, source, numbers.clone());
            });
            queries.resolve(commands, numbers.clone());
            ranges.record_resolve(commands);
            rendering(passes, commands, HIDES_NOTHING, |passes, commands| {
                bind(passes, commands, view);
                ranges.record_draws(commands);
            });
        });
        finish_image(&mut frame, passes, None, Some(image))?;
        let tick = frame.submit(None)?;
        queries.submitted(tick);
        flags.submitted(tick);
        renderer.submitted(tick);
        self.device.wait_idle()?;
        self.rgba().map(Some)
    }

    /// Reads the results of several frames as soon as their ticks are over, without waiting for
    /// idle. Returns the number of wrong results, and of all.
    pub(super) fn late_results(&mut self) -> Result<[usize; 2], Error> {
        let mut queries = QueryRing::new(&self.device, 2, "self-test late queries")?;
        let mut counts = [0; 2];
        let mut judge = |(frame, number): (u32, u32), samples: u32| {
            counts[0] += usize::from((samples > 0) != shows(frame, number));
            counts[1] += 1;
        };
        for number in 0..LATE_FRAMES {
            let Self { renderer, device, view, boxes, .. } = self;
            let Renderer { frames, passes, scene, .. } = renderer;
            let mut frame = frames.begin()?;
            queries.collect(device.completed()?, &mut judge);
            let tags: Vec<(u32, u32)> = (0..LATE_QUERIES).map(|query| (number, query)).collect();
            queries.begin(&mut frame, &tags)?;
            let io = ProxyIo { boxes: frame.uploads().push(boxes)?, flags: None };
            frame.commands().pass("self-test late queries", |commands| {
                rendering(passes, commands, HIDES_NOTHING, |_, commands| {
                    scene.passes().proxies.bind(commands, &io, &*view);
                    for query in 0..LATE_QUERIES {
                        queries.scope(commands, QueryIndex(query), |commands| {
                            if shows(number, query) {
                                scene.passes().proxies.draw(commands, query);
                            }
                        });
                    }
                });
            });
            queries.resolve(frame.commands(), 0..LATE_QUERIES);
            queries.read_back(frame.commands());
            let tick = frame.submit(None)?;
            queries.submitted(tick);
            renderer.submitted(tick);
        }
        self.device.wait_idle()?;
        queries.collect(self.device.completed()?, &mut judge);
        Ok(counts)
    }
}

/// Records a rendering that clears to black and a depth.
fn rendering(
    passes: &mut SceneRenderer,
    commands: &Commands,
    depth: f32,
    record: impl FnOnce(&SceneRenderer, &Commands),
) {
    passes.target.prepare(commands);
    let mut target = passes.target.render_target(None);
    (target.colour_load, target.depth_load) = (Load::Clear([0.0; 4]), Load::Clear(depth));
    commands.rendering(target, |commands| record(passes, commands));
}

/// Binds the pass that draws objects in rounds.
fn bind(passes: &SceneRenderer, commands: &Commands, view: &CullView) {
    passes.bind(commands, view, BucketId(0));
}

/// Waits until the results of the frame have been cleared.
fn wait_for_reset(commands: &Commands) {
    let reset = [Access::FragmentWrite, Access::IndirectRead, Access::ComputeWrite];
    commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &reset));
}

/// Returns true if a query of a frame contains a box.
fn shows(frame: u32, query: u32) -> bool {
    (frame + query).is_multiple_of(2)
}

/// Draws every other proxy, from the first on, by queries and by flags, as requested.
fn test_even(
    proxies: &ProxyPass,
    io: &ProxyIo,
    commands: &Commands,
    view: &CullView,
    queries: &QueryRing<()>,
    source: ResultSource,
    numbers: Range<u32>,
) {
    if source == ResultSource::Fragments {
        proxies.bind_flags(commands, io, view);
        let even = numbers.clone().step_by(2);
        even.for_each(|number| proxies.draw_all(commands, number..number + 1));
    }
    proxies.bind(commands, io, view);
    for number in numbers {
        queries.scope(commands, QueryIndex(number), |commands| {
            if number % 2 == 0 {
                proxies.draw(commands, number);
            }
        });
    }
}

/// Reads the results of two tests per object.
fn tested(
    results: &mut FlagRing<()>,
    device: &Device,
    count: usize,
) -> Result<TestedProxies, Error> {
    let mut found = TestedProxies::default();
    results.collect(device.completed()?, |_, results| {
        let (shown, hidden) = results.split_at(count.min(results.len()));
        found = TestedProxies { shown: shown.to_vec(), hidden: hidden.to_vec() };
    });
    Ok(found)
}

/// Draws all objects without their twins.
fn draw_objects(passes: &SceneRenderer, commands: &Commands, view: &CullView, draws: BufferSlice) {
    bind(passes, commands, view);
    commands.draw_indirect(draws.elements::<IndirectDraw>(0..PROBES as u32));
}
