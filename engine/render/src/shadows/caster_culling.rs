//! The choice of casters for maps that are not kept, and for volumes: casters whose shadow volumes
//! are visible.
//!
//! ```text
//! plan     per light, by a history of its own: casters to draw, and boxes to test
//! upload   the draws: per map what is drawn, then what each test decides
//! test     the shadow volumes of the boxes, against the finished depth of the view
//! draw     the maps, each range under its predicate
//! ```
//!
//! A local light with few casters has a single test: of the box around everything that it lights.

use std::collections::HashMap;

use ::shadows::{LitArea, ShadowLightId};
use cull::{
    BoxShadowVolumes, CullConfig, CullView, Culler, DrawPhases, FramePlan, Hierarchy, LeafIndex,
    MultiView, PendingTest, ResultReader, Strategy, VisibilityTestSupport,
};
use gpu::{
    Access, Commands, Device, FlagRing, Frame, IndirectDraw, MemoryBarrier, Predicates,
    PredicationMode, RenderTarget, ResultSource, Tick,
};
use occlusion::{BoxVolumeIo, BoxVolumePass};

use crate::error::Error;
use crate::shadows::culled_draws::{
    CasterGroup, CastersInView, CulledDraws, CulledGroup, TestedCasters, TestedLight,
};

/// The highest number of casters that a single test of a local light decides about.
const FEW_CASTERS: usize = 64;

/// The number of caster draws per frame that an executor must be able to skip.
const DRAWS_MAX: u64 = 1 << 24;

/// The highest number of lights with a history. A further lamp has one test for all of its casters,
/// and a further sun has none.
const HISTORIES_MAX: usize = 16;

/// The number of frames after its last use for which a history is kept.
const KEPT_FRAMES: u64 = 64;

/// The highest number of boxes that a light tests in a frame.
const TESTS_MAX: usize = 1024;

/// The share of the casters' triangles that is assumed to be drawn before any result.
const FIRST_SHARE: f32 = 0.25;

/// The culled casters of one frame's maps, and their histories.
pub(super) struct CasterCulling {
    device: Device,
    histories: HashMap<ShadowLightId, LightHistory>,
    frame: u64,
    flags: FlagRing<PendingTest<TestedCasters>>,
    reader: ResultReader<TestedCasters>,
    predicates: Predicates,
    capacity: u32,
    draws: CulledDraws,
    revealed_triangles: u64,
    /// The drawn share of the triangles of all casters. Tests count with the triangles of their
    /// boxes.
    drawn_share: f32,
    io: Option<BoxVolumeIo>,
}

/// The history of a light's casters in one view.
struct LightHistory {
    culler: Culler,
    plan: FramePlan,
    used: u64,
}

/// Returns true if a device supports skipping any number of casters by an executor.
pub(crate) fn can_skip(device: &Device, executor: PredicationMode) -> bool {
    PredicationMode::choose(device, Some(executor), DRAWS_MAX, 0).is_ok()
}

impl CasterCulling {
    /// Creates an empty history for every light.
    pub(super) fn new(device: &Device, frames_in_flight: usize) -> Result<Self, Error> {
        let source = ResultSource::Fragments;
        let capacity = 1024;
        // An executor that supports the highest number of draws, so that growing needs no other
        // one.
        let predication = PredicationMode::choose(device, None, DRAWS_MAX, 0)?;
        Ok(Self {
            device: device.clone(),
            histories: HashMap::new(),
            frame: 0,
            flags: FlagRing::new(device, frames_in_flight, source, "shadow flags"),
            reader: ResultReader::default(),
            predicates: Predicates::unlinked(
                device,
                Some(predication),
                capacity,
                frames_in_flight,
            )?,
            capacity,
            draws: CulledDraws::default(),
            revealed_triangles: 0,
            drawn_share: FIRST_SHARE,
            io: None,
        })
    }

    /// Skips casters from now on by an executor that [can](can_skip) skip them.
    pub(super) fn skip_by(
        &mut self,
        executor: PredicationMode,
        frames: usize,
    ) -> Result<(), Error> {
        if executor != self.predicates.predication() {
            let wanted = executor;
            let capacity = self.capacity;
            self.predicates = Predicates::unlinked(&self.device, Some(wanted), capacity, frames)?;
        }
        Ok(())
    }

    /// Changes the number of frames in flight. Tests in flight then have no result.
    pub(super) fn set_frames_in_flight(&mut self, frames_in_flight: usize) {
        let source = ResultSource::Fragments;
        self.flags = FlagRing::new(&self.device, frames_in_flight, source, "shadow flags");
        self.predicates.set_frames_in_flight(frames_in_flight);
    }

    pub(super) fn groups(&self) -> &[CulledGroup] {
        &self.draws.groups
    }

    /// Returns the number of tests.
    pub(super) fn tests(&self) -> u32 {
        self.draws.tags.len() as u32
    }

    /// Returns the number of triangles of casters that are drawn without a test, and of casters
    /// that tests revealed in the newest frame with results.
    pub(super) fn triangles(&self) -> [u64; 2] {
        [self.draws.triangles, self.revealed_triangles]
    }

    /// Returns the recently drawn share of the triangles of all casters, above 0.
    pub(super) fn drawn_share(&self) -> f32 {
        self.drawn_share
    }

    /// Reads the results of frames that are over.
    pub(super) fn collect(&mut self, completed: Tick, hierarchy: &Hierarchy) {
        let Self { flags, reader, histories, revealed_triangles, drawn_share, draws, .. } = self;
        reader.clear();
        flags.collect(completed, |tests, values| {
            reader.read_flags(tests, values);
            let shown = tests.iter().zip(values).filter(|(_, value)| **value != 0);
            *revealed_triangles = shown.map(|(test, _)| u64::from(test.contents.triangles)).sum();
            if tests.is_empty() || draws.groups.is_empty() {
                return;
            }
            // The draws without a test change little from frame to frame, so the newest plan is
            // used.
            let tested: u64 = tests.iter().map(|test| u64::from(test.contents.triangles)).sum();
            let drawn = draws.triangles
                + *revealed_triangles
                + BoxVolumePass::TRIANGLES * tests.len() as u64;
            *drawn_share = drawn as f32 / (draws.triangles + tested).max(1) as f32;
        });
        reader.finish();
        for (light, history) in histories {
            let of_light =
                reader.results().iter().filter(|result| result.contents.light == Some(*light));
            history.culler.ingest(hierarchy, of_light.map(|result| result.answer));
        }
    }

    /// Begins the plan of a frame.
    pub(super) fn begin(&mut self) {
        self.frame += 1;
        self.draws.clear();
        let frame = self.frame;
        self.histories.retain(|_, history| history.used + KEPT_FRAMES > frame);
    }

    /// Plans groups of casters of a light. `area` is the part of the view that the light reaches.
    pub(super) fn plan(
        &mut self,
        light: ShadowLightId,
        area: LitArea,
        scene: &CastersInView<'_>,
        volumes: &BoxShadowVolumes<'_>,
        groups: &[CasterGroup<'_>],
    ) {
        let casters = groups.iter().map(|group| group.casters.len()).sum::<usize>();
        let is_local = volumes.light().light.w != 0.0;
        let has_room = self.histories.len() < HISTORIES_MAX || self.histories.contains_key(&light);
        if casters == 0 {
            self.draws.add_untested(scene, groups);
        } else if is_local && (casters <= FEW_CASTERS || !has_room) {
            self.draws.add_light(scene, volumes, area, groups);
        } else if has_room {
            let history = self.histories.entry(light).or_insert_with(LightHistory::new);
            history.used = self.frame;
            history.plan(scene, volumes);
            self.draws.add_nodes(light, &history.plan, scene, volumes, area, groups);
        } else {
            self.draws.add_untested(scene, groups);
        }
    }

    /// Writes the plan into the memory of a frame. `draw` returns the draw of a caster.
    pub(super) fn upload(
        &mut self,
        frame: &mut Frame<'_>,
        draw: impl Fn(&LeafIndex) -> IndirectDraw,
    ) -> Result<(), Error> {
        self.io = None;
        let CulledDraws { leaves, boxes, tags, decided, .. } = &self.draws;
        self.flags.begin(frame, tags.iter().copied())?;
        if self.draws.groups.is_empty() {
            return Ok(());
        }
        let count = leaves.len() as u32;
        if count > self.capacity {
            let capacity = count.next_power_of_two();
            self.predicates.grow(capacity)?;
            self.capacity = capacity;
        }
        let flags = self.flags.results();
        for source in ResultSource::ALL {
            let (results, decided) = match source {
                ResultSource::Fragments => (flags, &decided[..]),
                ResultSource::Queries | ResultSource::Compute => (None, &[][..]),
            };
            self.predicates.begin(frame, source, results, decided.iter().copied())?;
        }
        let uploads = frame.uploads();
        let draws = uploads.push_iter(leaves.iter().map(draw))?;
        let boxes = uploads.push(boxes)?;
        self.io = flags.map(|flags| BoxVolumeIo { boxes, flags });
        // The previous frame may still draw and decide.
        let uses = [Access::IndirectRead, Access::ComputeRead, Access::ComputeWrite];
        let commands = frame.commands();
        commands.barrier(MemoryBarrier::between(&uses, &[Access::CopyWrite]));
        commands.copy_buffer(draws, self.predicates.draws());
        let reset = [
            Access::IndirectRead,
            Access::ComputeRead,
            Access::ComputeWrite,
            Access::FragmentWrite,
        ];
        commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &reset));
        Ok(())
    }

    /// Tests the boxes against the finished depth of a view, and turns the results into predicates.
    /// Outside of rendering.
    pub(super) fn record_tests(
        &self,
        commands: &Commands,
        pass: &BoxVolumePass,
        depth: RenderTarget,
        view: &CullView,
    ) {
        commands.pass("test shadows", |commands| {
            commands.rendering(depth, |commands| self.test(commands, pass, view));
        });
        commands.pass("resolve shadow tests", |commands| {
            let decisions = 0..self.draws.decided.len() as u32;
            self.predicates.resolve(commands, &[(ResultSource::Fragments, decisions)], 0);
        });
    }

    fn test(&self, commands: &Commands, pass: &BoxVolumePass, view: &CullView) {
        let Some(io) = &self.io else { return };
        commands.set_viewport(&gpu::Viewport::covering(view.origin, view.size));
        for TestedLight { light, area, tests } in &self.draws.lights {
            // Nothing is shadowed elsewhere.
            let origin = [0, 1].map(|side| view.origin[side].saturating_add(area.origin[side]));
            commands.clip(origin, area.size);
            pass.draw(commands, io, view, *light, tests.clone());
        }
    }

    pub(super) fn draw(&self, commands: &Commands, group: &CulledGroup) {
        if !group.always.is_empty() {
            let draws = self.predicates.draws().elements::<IndirectDraw>(group.always.clone());
            self.predicates.draw_after_counted(commands, draws);
        }
        for decision in group.decisions.clone() {
            self.predicates.draw(commands, ResultSource::Fragments, decision);
        }
    }

    /// Copies the results to mapped memory, as their last use in a frame.
    pub(super) fn read_back(&self, commands: &Commands) {
        self.flags.read_back(commands);
    }

    /// Notes that the frame of the last plan was submitted.
    pub(super) fn submitted(&mut self, tick: Tick) {
        self.flags.submitted(tick);
    }
}

impl LightHistory {
    fn new() -> Self {
        let testers = VisibilityTestSupport {
            flags: true,
            draw_phases: DrawPhases::Two,
            ..Default::default()
        };
        Self {
            culler: Culler::with_testers(CullConfig::default(), testers),
            plan: FramePlan::default(),
            used: 0,
        }
    }

    fn plan(&mut self, scene: &CastersInView<'_>, volumes: &BoxShadowVolumes<'_>) {
        let views = MultiView::of_shadows(scene.view, volumes);
        let hierarchy = scene.hierarchy;
        let plan = &mut self.plan;
        self.culler.plan(hierarchy, Strategy::ANTUMBRA_FLAGS, views, TESTS_MAX, plan);
    }
}
