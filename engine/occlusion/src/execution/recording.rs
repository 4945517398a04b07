//! The recording of a plan: the visible leaves, then round by round the leaves that tests reveal.
//!
//! ```text
//! draw visible   clear; all visible leaves front to back in few multi-draws, some under a query
//!                each; proxies of round 0
//! per step       test boxes: where a compute shader answers for them
//!                resolve tests: results of the round just tested decide
//!                list draws: where draws are compacted, what is revealed becomes a list per
//!                            bucket
//!                draw revealed: leaves that the step before enabled; predicated ranges of this
//!                               round; boxes of the leaves below nodes that showed; proxies of
//!                               the next
//! shade          all draws once more for their colour, where the owner of the objects does that;
//!                in the last rendering above if nothing has to be known before
//! copy results   results and lists -> mapped memory of this slot
//! ```

use std::ops::Range;

use cull::CullView;
use gpu::{
    Access, Commands, IndirectDraw, LeafDrawBuffers, MemoryBarrier, Predicate, QueryIndex, Reveal,
    Target, Viewport,
};

use super::io::FrameIo;
use crate::culled_scene::CulledScene;
use crate::leaf_table::{BucketId, draw_range};
use crate::object_renderer::{ObjectRenderer, Rendering};
use crate::occlusion_state::OcclusionState;
use crate::passes::{ComputeTestIo, LeafBoxIo, ListDrawsIo};
use crate::rect::Rect;
use crate::shaded_objects::{ShadedObjects, UpcomingDraws, render, render_last};
use crate::test_layout::{RevealedRange, RoundLayout, StepRounds, take_bucket};
use crate::visible_draws::QueriedDraws;

/// A plan and the objects that it is recorded with.
pub(super) struct Recording<'a> {
    pub(super) scene: &'a CulledScene,
    pub(super) state: &'a OcclusionState,
    /// The view, or the first of several.
    pub(super) view: &'a CullView,
    pub(super) io: &'a FrameIo,
}

impl Recording<'_> {
    /// Records one view's frame.
    ///
    /// Each rendering draws the leaves that the previous tests revealed, and the proxies of the
    /// next tests, so a round costs one break instead of two. Leaves below a node that showed in
    /// round `n` are tested together with round `n + 1`, and drawn together with the leaves that
    /// round `n + 1` reveals.
    pub(super) fn record(&self, commands: &Commands, objects: &mut dyn ShadedObjects) {
        let state = self.state;
        let view = self.view;
        let layout = &state.layout;
        self.wait_for_reset(commands);
        if objects.has_draws_to_prepare() {
            objects.prepare_draws(commands, UpcomingDraws::Visible(state.plan()));
        }
        objects.target().prepare(commands);
        let steps = self.drawn_steps();
        let mut is_shaded = false;
        commands.pass("draw visible", |commands| {
            let draw = |commands: &Commands, objects: &mut dyn ShadedObjects| {
                self.draw_visible(commands, &|commands, bucket| {
                    objects.bind(commands, view, bucket);
                });
                self.draw_proxies(commands, layout.rounds.first());
            };
            match steps {
                0 => is_shaded = self.render_last(commands, objects, Rendering::First, draw),
                _ => render(objects, commands, view, Rendering::First, draw),
            }
        });
        for step in 0..steps {
            let known = layout.step(step).known;
            let next = layout.rounds.get(step + 1);
            self.test_by_compute(commands, objects.target(), known);
            commands.pass("resolve tests", |commands| self.resolve(commands, step));
            self.list_revealed(commands, step);
            self.prepare_revealed(commands, objects, known);
            objects.target().prepare(commands);
            commands.pass("draw revealed", |commands| {
                let draw = |commands: &Commands, objects: &mut dyn ShadedObjects| {
                    self.draw_step(commands, step, &|commands, bucket| {
                        objects.bind(commands, view, bucket);
                    });
                    self.test_leaves(commands, known);
                    self.draw_proxies(commands, next);
                };
                if step + 1 == steps {
                    is_shaded = self.render_last(commands, objects, Rendering::Next, draw)
                } else {
                    render(objects, commands, view, Rendering::Next, draw)
                }
            });
        }
        if let Some(last) = layout.rounds.get(steps) {
            commands.pass("resolve tests", |commands| {
                state.rings().queries.resolve(commands, last.queries.clone());
            });
        }
        if is_shaded {
            objects.finish_shading(self.scene, commands, view)
        } else {
            objects.shade(self.scene, commands, view, &|commands, bind| {
                self.draw_again(commands, bind);
            })
        }
        self.copy_results(commands);
    }

    /// Records the last rendering that decides what is visible. Returns true if it also drew the
    /// colours: this is possible because all decisions are made before it.
    fn render_last(
        &self,
        commands: &Commands,
        objects: &mut dyn ShadedObjects,
        rendering: Rendering,
        draw: impl FnOnce(&Commands, &mut dyn ShadedObjects),
    ) -> bool {
        let shades = objects.prepare_to_shade_within(commands);
        render_last(objects, commands, self.view, rendering, |commands, objects| {
            draw(commands, objects);
            if shades {
                objects.shade_within(self.scene, commands, self.view, &|commands, bind| {
                    self.draw_again(commands, bind);
                });
            }
        });
        shades
    }

    /// Returns the number of steps that draw: all except a last step whose results only serve later
    /// frames.
    fn drawn_steps(&self) -> usize {
        let layout = &self.state.layout;
        let steps = layout.step_count();
        match steps.checked_sub(1).map(|last| layout.step(last)) {
            Some(StepRounds { before: None, known: Some(last) }) if layout.is_for_later(last) => {
                steps - 1
            }
            _ => steps,
        }
    }

    /// Records the tests of a plan of two phases, and the passes that list the draws which the
    /// tests reveal. The host records the draws before and after.
    pub(super) fn record_tests(
        &self,
        commands: &Commands,
        objects: &mut dyn ObjectRenderer,
        lists: Option<ListDrawsIo>,
    ) {
        let state = self.state;
        let view = self.view;
        let Some(round) = state.layout.rounds.first() else { return };
        self.wait_for_reset(commands);
        objects.target().prepare(commands);
        commands.pass("test proxies", |commands| {
            if objects.begin_rendering(commands, view, Rendering::Next) {
                self.draw_proxies(commands, Some(round));
                objects.end_rendering(commands);
            }
        });
        self.test_by_compute(commands, objects.target(), Some(round));
        commands.pass("resolve tests", |commands| self.resolve(commands, 0));
        if round.has_leaf_tests {
            objects.target().prepare(commands);
            commands.pass("test leaves", |commands| {
                if objects.begin_rendering(commands, view, Rendering::Next) {
                    self.test_leaves(commands, Some(round));
                    objects.end_rendering(commands);
                }
            });
        }
        if let Some(lists) = lists {
            self.list_draws(commands, lists);
        }
        self.copy_results(commands);
    }

    /// Records the passes that list the draws which a step reveals, if draws are compacted.
    fn list_revealed(&self, commands: &Commands, step: usize) {
        if let Some(lists) = self.listed(step) {
            self.list_draws(commands, lists);
        }
    }

    /// Returns the buffers of the lists of a step, if it has any.
    fn listed(&self, step: usize) -> Option<ListDrawsIo> {
        let (step, _) = self.state.listed_step(step)?;
        let Range { start: first, end } = step.ranges;
        self.io.lists.filter(|_| first < end).map(|lists| ListDrawsIo { first, end, ..lists })
    }

    /// Lists draws by the results of the tests.
    fn list_draws(&self, commands: &Commands, lists: ListDrawsIo) {
        let rings = self.state.rings();
        let io = ListDrawsIo {
            enabled: self.io.leaf_draws.map(|leaf_draw| leaf_draw.draws),
            results: [rings.queries.results(), rings.flags.results(), rings.computed.results()],
            threshold_samples: self.state.plan().sample_threshold,
            ..lists
        };
        commands.pass("list draws", |commands| self.scene.passes.list_draws.record(commands, &io));
    }

    /// Waits until the results of the frame have been cleared.
    fn wait_for_reset(&self, commands: &Commands) {
        let FrameIo { proxies, leaf_draws, computed, .. } = self.io;
        if proxies.flags.is_some() || leaf_draws.is_some() || computed.is_some() {
            let reset = [Access::FragmentWrite, Access::IndirectRead, Access::ComputeWrite];
            commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &reset));
        }
    }

    /// Copies all results of the frame to mapped memory.
    fn copy_results(&self, commands: &Commands) {
        let state = self.state;
        commands.pass("copy results", |commands| {
            state.rings().queries.resolve(commands, 0..state.layout.visible_draw_queries);
            state.rings().queries.read_back(commands);
            state.rings().flags.read_back(commands);
            state.rings().computed.read_back(commands);
            state.rings().leaf_draws.read_back(commands);
        });
    }

    /// Draws the visible leaves bucket by bucket. Draws between two queried draws share one call.
    fn draw_visible(&self, commands: &Commands, bind: &dyn Fn(&Commands, BucketId)) {
        let visible = &self.state.layout.visible;
        let draw = |commands: &Commands, draws: Range<u32>| {
            if !draws.is_empty() {
                let draws = self.io.visible.elements::<IndirectDraw>(draws);
                self.scene.leaves.predicates.draw_always(commands, draws);
            }
        };
        for bucket in visible.buckets() {
            bind(commands, bucket.bucket);
            let mut drawn = bucket.draws.start;
            for QueriedDraws { draws, query } in visible.queried(bucket) {
                draw(commands, drawn..draws.start);
                self.state.rings().queries.scope(commands, QueryIndex(*query), |commands| {
                    draw(commands, draws.clone());
                });
                drawn = draws.end;
            }
            draw(commands, drawn..bucket.draws.end);
        }
    }

    /// Tests the proxies of one round against the depth of the draws so far.
    fn draw_proxies(&self, commands: &Commands, round: Option<&RoundLayout>) {
        let Some(round) = round else { return };
        commands.label("proxies", |commands| {
            // The owner may have set another viewport.
            commands.set_viewport(&Viewport::covering(self.view.origin, self.view.size));
            let eyes = self.io.eyes(self.view);
            if !round.flags.is_empty() {
                self.scene.passes.proxies.bind_flags(commands, &self.io.proxies, eyes);
                self.scene.passes.proxies.draw_all(commands, round.flags.clone());
            }
            if !round.queries.is_empty() {
                self.scene.passes.proxies.bind(commands, &self.io.proxies, eyes);
            }
            for (query, test) in round.queries.clone().zip(round.queried_tests.clone()) {
                self.state.rings().queries.scope(commands, QueryIndex(query), |commands| {
                    self.scene.passes.proxies.draw(commands, test);
                });
            }
        });
    }

    /// Tests the boxes of a round by compute shader against the depth of the draws so far.
    fn test_by_compute(
        &self,
        commands: &Commands,
        target: &mut Target,
        round: Option<&RoundLayout>,
    ) {
        let computed = round.map(|round| round.computed.clone()).filter(|tests| !tests.is_empty());
        let (Some(tests), Some(io)) = (computed, self.io.computed) else { return };
        let pass = &self.scene.passes.compute_test;
        commands.pass("test boxes", |commands| {
            pass.record_grid(commands, target, Rect::of(self.view), self.view.depth);
            let io = ComputeTestIo { first: tests.start, count: tests.end - tests.start, ..io };
            pass.record_tests(commands, &io, self.view);
        });
    }

    /// Turns the results of a step into predicates: the results of its round, and of the leaf tests
    /// of the round before. Where the draws of a step are listed, they need no predicates.
    fn resolve(&self, commands: &Commands, step: usize) {
        let state = self.state;
        let StepRounds { before, known } = state.layout.step(step);
        if before.is_some() {
            let enabled = MemoryBarrier::between(
                &[Access::FragmentWrite],
                &[Access::IndirectRead, Access::FragmentWrite],
            );
            commands.barrier(enabled);
        }
        if let Some(known) = known {
            state.rings().queries.resolve(commands, known.queries.clone());
            let made = state.layout.made(known);
            let threshold = state.plan().sample_threshold;
            if known.has_leaf_tests || self.listed(step).is_none() {
                self.scene.leaves.predicates.resolve(commands, &made, threshold);
            }
        }
    }

    /// Lets the owner of the objects prepare the draws that a round may reveal: whole ranges, and
    /// leaves that are tested individually next.
    fn prepare_revealed(
        &self,
        commands: &Commands,
        objects: &mut dyn ShadedObjects,
        known: Option<&RoundLayout>,
    ) {
        if !objects.has_draws_to_prepare() {
            return;
        }
        let layout = &self.state.layout;
        let predicates = self.scene.leaves.predicates();
        let tests = &self.state.plan().tests;
        let threshold = self.state.plan().sample_threshold;
        let [draws, boxes] =
            [Reveal::Draws, Reveal::Boxes].map(|reveal| layout.revealed(known, reveal));
        let predicate = |revealed_range: &RevealedRange| {
            let leaves = draw_range(tests.get(revealed_range.test as usize)?.leaves);
            predicates.predicate(revealed_range.source, revealed_range.predicate, leaves, threshold)
        };
        // A test decides about its leaves once, although their draws may be in several buckets.
        let mut decided: Vec<&RevealedRange> = draws.iter().chain(boxes).collect();
        decided.sort_unstable_by_key(|range| range.test);
        decided.dedup_by_key(|range| range.test);
        let revealed: Vec<Predicate> = decided.into_iter().filter_map(predicate).collect();
        objects.prepare_draws(commands, UpcomingDraws::Revealed(&revealed));
    }

    /// Draws what a step reveals, bucket by bucket; where its draws are listed, in one call per
    /// bucket.
    fn draw_step(&self, commands: &Commands, step: usize, bind: &dyn Fn(&Commands, BucketId)) {
        if self.io.lists.is_none() {
            return self.draw_revealed(commands, self.state.layout.step(step), bind);
        }
        let lists = self.state.listed_step(step).map_or(&[][..], |(_, lists)| lists);
        for list in lists {
            bind(commands, list.bucket);
            match list.count {
                Some(count) => commands.draw_indirect_count(list.commands, count),
                None => commands.draw_indirect(list.commands),
            }
        }
    }

    /// Draws, bucket by bucket, the leaves that boxes of the round before enabled individually, and
    /// the visible ranges of the known round.
    fn draw_revealed(
        &self,
        commands: &Commands,
        rounds: StepRounds<'_>,
        bind: &dyn Fn(&Commands, BucketId),
    ) {
        let layout = &self.state.layout;
        let predicates = &self.scene.leaves.predicates;
        let mut enabled = layout.revealed(rounds.before, Reveal::EnabledDraws);
        let mut whole = layout.revealed(rounds.known, Reveal::Draws);
        let first = |list: &[RevealedRange]| list.first().map(|first| first.bucket);
        while let Some(bucket) = [enabled, whole].into_iter().filter_map(first).min() {
            bind(commands, bucket);
            for range in take_bucket(&mut enabled, bucket) {
                let Some(LeafDrawBuffers { draws, .. }) = self.io.leaf_draws else { continue };
                predicates.draw_enabled(commands, range.source, range.predicate, draws);
            }
            for range in take_bucket(&mut whole, bucket) {
                predicates.draw(commands, range.source, range.predicate);
            }
        }
    }

    /// Draws everything again that the rounds of a frame drew: their results still hold the
    /// decisions.
    fn draw_again(&self, commands: &Commands, bind: &dyn Fn(&Commands, BucketId)) {
        for bucket in self.state.layout.visible.buckets() {
            bind(commands, bucket.bucket);
            let draws = self.io.visible.elements::<IndirectDraw>(bucket.draws.clone());
            self.scene.leaves.predicates.draw_always(commands, draws);
        }
        for step in 0..self.state.layout.step_count() {
            self.draw_step(commands, step, bind);
        }
    }

    /// Tests the leaves below visible nodes individually.
    fn test_leaves(&self, commands: &Commands, known: Option<&RoundLayout>) {
        let known = known.filter(|round| round.has_leaf_tests);
        let (Some(pass), Some(leaf_draws), Some(_)) =
            (&self.scene.passes.leaf_boxes, self.io.leaf_draws, known)
        else {
            return;
        };
        commands.label("leaf boxes", |commands| {
            commands.set_viewport(&Viewport::covering(self.view.origin, self.view.size));
            let leaves = &self.scene.leaves;
            let io = LeafBoxIo { boxes: leaves.boxes(), leaf_draws, links: leaves.links() };
            pass.bind(commands, &io, self.io.eyes(self.view));
            for range in self.state.layout.revealed(known, Reveal::Boxes) {
                leaves.predicates.draw_boxes(commands, range.source, range.predicate);
            }
        });
    }
}
