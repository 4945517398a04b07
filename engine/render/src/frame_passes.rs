//! The GPU's half of a frame: what is visible, then round by round what turns out to be.

use cull::View;
use gpu::{
    Access, BufferSlice, Commands, Frame, IndirectDraw, MemoryBarrier, Parts, Predicates,
    QueryIndex, RenderTarget, Reveal, Target, WordSource,
};
use scene::Light;

use crate::blended::Blended;
use crate::deformers::Deformers;
use crate::error::Error;
use crate::geometry::Geometry;
use crate::passes::{
    ComputeTest, ComputeTestIo, CountPass, LeafBoxIo, LeafBoxPass, OpaqueIo, OpaquePass, ProxyBox,
    ProxyIo, ProxyPass,
};
use crate::questions::{RoundQuestions, draw_range};
use crate::shading::Shading;
use crate::view_state::ViewState;
use crate::views::Area;

/// Everything a frame of a scene is recorded with.
pub(crate) struct FramePasses {
    pub(crate) target: Target,
    pub(crate) geometry: Geometry,
    pub(crate) predicates: Predicates,
    pub(crate) opaque: OpaquePass,
    pub(crate) proxies: ProxyPass,
    // Made for the first frame that tests so.
    pub(crate) compute_test: Option<ComputeTest>,
    // Where fragment shaders can write to buffers.
    pub(crate) leaf_boxes: Option<LeafBoxPass>,
    // Made for the first frame that counts.
    pub(crate) counts: Option<CountPass>,
    pub(crate) light: Light,
    /// Where meshes change their form.
    pub(crate) deformers: Option<Deformers>,
    /// Where objects are blended.
    pub(crate) blended: Option<Blended>,
    /// For scenes with surfaces.
    pub(crate) shading: Option<Shading>,
}

/// What one frame reads from its slot's memory.
pub(crate) struct FrameIo {
    visible: BufferSlice,
    queried: BufferSlice,
    proxies: ProxyIo,
    computed: Option<ComputeTestIo>,
    parts: Option<Parts>,
}

const DRAW_BYTES: u64 = size_of::<IndirectDraw>() as u64;

impl FrameIo {
    /// Writes the newest plan of `history` into the memory of `frame`, and starts its questions.
    pub(crate) fn write(
        frame: &mut Frame<'_>,
        history: &mut ViewState,
        passes: &mut FramePasses,
    ) -> Result<Self, Error> {
        let geometry = &passes.geometry;
        let draw = |leaf: &cull::LeafIndex| geometry.draw(*leaf);
        history.queries.begin(frame, &history.questions.query_tags)?;
        history.flags.begin(frame, history.questions.flag_tags.iter().copied())?;
        history.computed.begin(frame, history.questions.compute_tags.iter().copied())?;
        history.follow_draws(geometry);
        let has_parts = |test: &&cull::ProxyTest| test.tag.kind == cull::QueryKind::Parts;
        let tested = history.plan.tests.iter().filter(has_parts).map(draw_range);
        let (frame_id, generation) = (history.plan.frame, history.generation);
        history.parts.begin(frame, (frame_id, generation), tested, |number| {
            draw(&cull::LeafIndex(number))
        })?;
        let words = [
            (WordSource::Queries, history.queries.results()),
            (WordSource::Fragments, history.flags.words()),
            (WordSource::Compute, history.computed.words()),
        ];
        for (source, words) in words {
            let decided = history.questions.decided(source).iter().copied();
            passes.predicates.begin(frame, source, words, decided)?;
        }
        let (plan, uploads) = (history.plan(), frame.uploads());
        let queried = plan.queried_draws.iter();
        let boxes = uploads.push_iter(plan.tests.iter().map(|t| ProxyBox::from(t.bounds)))?;
        let words = history.computed.words();
        Ok(Self {
            visible: uploads.push_iter(plan.draws.iter().map(draw))?,
            queried: uploads.push_iter(queried.map(|(leaf, _)| draw(leaf)))?,
            proxies: ProxyIo { boxes, flags: history.flags.words() },
            computed: words.map(|words| ComputeTestIo { boxes, words, first: 0, count: 0 }),
            parts: history.parts.parts(),
        })
    }
}

impl FramePasses {
    /// Records one view's frame.
    ///
    /// Each rendering draws what the tests before it revealed and the proxies that are tested next,
    /// so that a round costs one break and not two. Leaves below a node that showed in round `n`
    /// are tested while round `n + 1` is, and drawn with what that reveals.
    pub(crate) fn record(
        &mut self,
        commands: &Commands,
        history: &ViewState,
        view: &View,
        io: &FrameIo,
    ) {
        let rounds = &history.questions.rounds;
        if io.proxies.flags.is_some() || io.parts.is_some() || io.computed.is_some() {
            let reset = [Access::FragmentWrite, Access::IndirectRead, Access::ComputeWrite];
            commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &reset));
        }
        self.target.prepare(commands);
        commands.pass("draw visible", |commands| {
            commands.rendering(self.first_target(view), |commands| {
                self.draw_visible(commands, history, view, io);
                self.draw_proxies(commands, history, view, io, rounds.first());
            });
        });
        let refined = rounds.last().is_some_and(|round| round.has_parts);
        for step in 0..rounds.len() + usize::from(refined) {
            let before = step.checked_sub(1).and_then(|round| rounds.get(round));
            let before = before.filter(|round| round.has_parts);
            let (known, next) = (rounds.get(step), rounds.get(step + 1));
            if let (Some(last), None, None) = (known, next, before)
                && history.questions.is_for_later(last)
            {
                commands.pass("resolve tests", |commands| {
                    history.queries.resolve(commands, last.queries.clone());
                });
                break;
            }
            self.test_by_compute(commands, view, io, known);
            commands.pass("resolve tests", |commands| {
                self.resolve(commands, history, known, before);
            });
            self.target.prepare(commands);
            commands.pass("draw revealed", |commands| {
                commands.rendering(self.next_target(view), |commands| {
                    self.draw_revealed(commands, history, view, io, known, before);
                    self.test_leaves(commands, history, view, io, known);
                    self.draw_proxies(commands, history, view, io, next);
                });
            });
        }
        self.shade(commands, view, |passes, commands| passes.draw_again(commands, history, io));
        commands.pass("copy results", |commands| {
            history.queries.resolve(commands, 0..history.questions.own_draws);
            history.queries.read_back(commands);
            history.flags.read_back(commands);
            history.computed.read_back(commands);
            history.parts.read_back(commands);
        });
    }

    /// Where a view is drawn: its part of the target.
    pub(crate) fn target_of(&self, view: &View, clear: Option<[f32; 4]>) -> RenderTarget {
        self.target.render_target(clear).within(view.origin, view.size)
    }

    /// Draws what is taken as visible: in one call from one that is asked about to the next.
    fn draw_visible(&self, commands: &Commands, history: &ViewState, view: &View, io: &FrameIo) {
        let plan = history.plan();
        self.bind_rounds(commands, view);
        let bytes = |draws: u32| u64::from(draws) * DRAW_BYTES;
        let mut drawn = 0;
        let mut draw_until = |end: u32| {
            if end > drawn {
                let draws = io.visible.part(bytes(drawn), bytes(end - drawn));
                self.predicates.draw_always(commands, draws);
                drawn = end;
            }
        };
        for (query, after) in (0..).zip(&plan.queried_after) {
            draw_until(*after);
            history.queries.scope(commands, QueryIndex(query), |commands| {
                let draws = io.queried.part(bytes(query), DRAW_BYTES);
                self.predicates.draw_always(commands, draws);
            });
        }
        draw_until(plan.draws.len() as u32);
    }

    /// Tests the proxies of one round against the depth so far.
    fn draw_proxies(
        &self,
        commands: &Commands,
        history: &ViewState,
        view: &View,
        io: &FrameIo,
        round: Option<&RoundQuestions>,
    ) {
        let Some(round) = round else { return };
        commands.label("proxies", |commands| {
            if !round.flags.is_empty() {
                self.proxies.bind_flags(commands, &io.proxies, view);
                self.proxies.draw_all(commands, round.flags.clone());
            }
            if !round.queries.is_empty() {
                self.proxies.bind(commands, &io.proxies, view);
            }
            for (query, test) in round.queries.clone().zip(round.queried_tests.clone()) {
                history.queries.scope(commands, QueryIndex(query), |commands| {
                    self.proxies.draw(commands, test);
                });
            }
        });
    }

    /// Tests the boxes of a round that a compute shader looks at, against the depth so far.
    fn test_by_compute(
        &mut self,
        commands: &Commands,
        view: &View,
        io: &FrameIo,
        round: Option<&RoundQuestions>,
    ) {
        let computed = round.map(|round| round.computed.clone()).filter(|tests| !tests.is_empty());
        let (Some(tests), Some(pass), Some(io)) = (computed, &self.compute_test, io.computed)
        else {
            return;
        };
        let target = &mut self.target;
        commands.pass("test boxes", |commands| {
            pass.record_grid(commands, target, Area::of(view));
            let count = tests.end - tests.start;
            pass.record_tests(commands, &ComputeTestIo { first: tests.start, count, ..io }, view);
        });
    }

    /// Makes the answers to the `known` round decide, and the tests of leaves under the round
    /// `before` it.
    fn resolve(
        &self,
        commands: &Commands,
        history: &ViewState,
        known: Option<&RoundQuestions>,
        before: Option<&RoundQuestions>,
    ) {
        if before.is_some() {
            let switched_on = MemoryBarrier::between(
                &[Access::FragmentWrite],
                &[Access::IndirectRead, Access::FragmentWrite],
            );
            commands.barrier(switched_on);
        }
        if let Some(known) = known {
            history.queries.resolve(commands, known.queries.clone());
            self.predicates.resolve(commands, &history.questions.made(known));
        }
    }

    /// Draws the ranges that showed in the `known` round, and single leaves of the round `before`.
    fn draw_revealed(
        &self,
        commands: &Commands,
        history: &ViewState,
        view: &View,
        io: &FrameIo,
        known: Option<&RoundQuestions>,
        before: Option<&RoundQuestions>,
    ) {
        self.bind_rounds(commands, view);
        self.draw_parts(commands, history, io, before);
        self.draw_whole(commands, history, known);
    }

    /// Draws the leaves of a round that were switched on one by one.
    fn draw_parts(
        &self,
        commands: &Commands,
        history: &ViewState,
        io: &FrameIo,
        round: Option<&RoundQuestions>,
    ) {
        let Some(parts) = io.parts else { return };
        for decision in history.questions.revealing(round, Reveal::Parts) {
            self.predicates.draw_parts(commands, decision.source, decision.number, parts.draws);
        }
    }

    /// Draws the ranges of a round that showed.
    fn draw_whole(&self, commands: &Commands, history: &ViewState, round: Option<&RoundQuestions>) {
        for decision in history.questions.revealing(round, Reveal::Whole) {
            self.predicates.draw(commands, decision.source, decision.number);
        }
    }

    /// Draws what all rounds of a frame drew: their words still say what that was.
    fn draw_again(&self, commands: &Commands, history: &ViewState, io: &FrameIo) {
        let plan = history.plan();
        for (draws, count) in
            [(io.visible, plan.draws.len()), (io.queried, plan.queried_draws.len())]
        {
            if count > 0 {
                let draws = draws.part(0, count as u64 * DRAW_BYTES);
                self.predicates.draw_always(commands, draws);
            }
        }
        for round in &history.questions.rounds {
            self.draw_whole(commands, history, Some(round));
            self.draw_parts(commands, history, io, Some(round));
        }
    }

    /// Tests the leaves of the nodes that showed, one by one.
    fn test_leaves(
        &self,
        commands: &Commands,
        history: &ViewState,
        view: &View,
        io: &FrameIo,
        known: Option<&RoundQuestions>,
    ) {
        let known = known.filter(|round| round.has_parts);
        let (Some(pass), Some(parts), Some(_)) = (&self.leaf_boxes, io.parts, known) else {
            return;
        };
        commands.label("leaf boxes", |commands| {
            let boxes = self.geometry.leaf_boxes.whole();
            pass.bind(commands, &LeafBoxIo { boxes, parts }, view);
            for decision in history.questions.revealing(known, Reveal::Parts) {
                self.predicates.draw_boxes(commands, decision.source, decision.number);
            }
        });
    }

    pub(crate) fn opaque_io(&self) -> OpaqueIo {
        OpaqueIo {
            vertices: self.geometry.vertices.whole(),
            indices: self.geometry.indices.whole(),
            instances: self.geometry.instances.whole(),
        }
    }
}
