//! The GPU's half of a frame: what is visible, then round by round what turns out to be.

use cull::View;
use gpu::{
    BufferSlice, Commands, Frame, IndirectDraw, Predicates, QueryIndex, Readback, RenderTarget,
    Target,
};

use crate::error::Error;
use crate::geometry::Geometry;
use crate::passes::{OpaqueIo, OpaquePass, ProxyBox, ProxyIo, ProxyPass};
use crate::scene::Light;
use crate::view_history::ViewHistory;

/// Everything a frame of a scene is recorded with.
pub(crate) struct FramePasses {
    pub(crate) target: Target,
    pub(crate) geometry: Geometry,
    pub(crate) predicates: Predicates,
    pub(crate) opaque: OpaquePass,
    pub(crate) proxies: ProxyPass,
    pub(crate) light: Light,
}

/// What one frame reads from its slot's memory.
pub(crate) struct FrameIo {
    visible: BufferSlice,
    queried: BufferSlice,
    boxes: BufferSlice,
}

const DRAW_BYTES: u64 = size_of::<IndirectDraw>() as u64;

impl FrameIo {
    /// Writes the newest plan of `history` into the memory of `frame`.
    pub(crate) fn write(
        frame: &mut Frame<'_>,
        history: &mut ViewHistory,
        passes: &mut FramePasses,
    ) -> Result<Self, Error> {
        history.queries.begin(frame, &history.tags)?;
        let words = history.queries.results();
        passes.predicates.begin(frame, words, history.draw_ranges())?;
        let draw = |leaf: &cull::LeafIndex| passes.geometry.draw(*leaf);
        let (plan, uploads) = (history.plan(), frame.uploads());
        let queried = plan.queried_draws.iter();
        Ok(Self {
            visible: uploads.push_iter(plan.draws.iter().map(draw))?,
            queried: uploads.push_iter(queried.map(|(leaf, _)| draw(leaf)))?,
            boxes: uploads.push_iter(plan.tests.iter().map(|t| ProxyBox::from(t.bounds)))?,
        })
    }
}

impl FramePasses {
    /// Records one view's frame. Queries are numbered: first those on visible draws, then the tests.
    ///
    /// The proxies of a round are drawn in the same rendering as what precedes them, so that a
    /// round costs one break and not two.
    pub(crate) fn record(
        &mut self,
        commands: &Commands,
        history: &ViewHistory,
        view: &View,
        io: &FrameIo,
        picture: Option<&Readback>,
    ) {
        let plan = history.plan();
        let own = plan.queried_draws.len() as u32;
        let no_tests = 0..0;
        let first_round = plan.rounds.first().unwrap_or(&no_tests);

        self.target.prepare(commands);
        commands.pass("visible", |commands| {
            let [red, green, blue] = self.light.sky;
            commands.rendering(self.target_of(view, Some([red, green, blue, 1.0])), |commands| {
                self.draw_visible(commands, history, view, io);
                self.draw_proxies(commands, history, view, io, first_round.clone());
            });
        });
        let mut asked = 0;
        for (number, round) in plan.rounds.iter().enumerate() {
            let answered = asked..own + round.end as u32;
            asked = answered.end;
            commands.pass("answers", |commands| {
                history.queries.resolve(commands, answered.clone());
                self.predicates.resolve(commands, answered.clone());
            });
            self.target.prepare(commands);
            commands.pass("revealed", |commands| {
                commands.rendering(self.target_of(view, None), |commands| {
                    self.opaque.bind(commands, &self.opaque_io(), view, &self.light);
                    for test in round.clone().filter(|test| plan.tests[*test].leaves.count > 0) {
                        self.predicates.draw(commands, own + test as u32);
                    }
                    let next = plan.rounds.get(number + 1).unwrap_or(&no_tests);
                    self.draw_proxies(commands, history, view, io, next.clone());
                });
            });
        }
        commands.pass("read back", |commands| {
            history.queries.resolve(commands, asked..own);
            history.queries.read_back(commands);
            if let Some(picture) = picture {
                self.target.copy_to(commands, picture);
            }
        });
    }

    /// Where a view is drawn: its part of the target.
    fn target_of(&self, view: &View, clear: Option<[f32; 4]>) -> RenderTarget {
        self.target.render_target(clear).within(view.origin, view.size)
    }

    /// Draws what is taken as visible: all in one call, then those that are asked about. They come
    /// last, so that what hides them is there already.
    fn draw_visible(&self, commands: &Commands, history: &ViewHistory, view: &View, io: &FrameIo) {
        let plan = history.plan();
        self.opaque.bind(commands, &self.opaque_io(), view, &self.light);
        if !plan.draws.is_empty() {
            self.predicates.draw_always(commands, io.visible);
        }
        for query in 0..plan.queried_draws.len() as u32 {
            history.queries.scope(commands, QueryIndex(query), |commands| {
                let at = u64::from(query) * DRAW_BYTES;
                self.predicates.draw_always(commands, io.queried.part(at, DRAW_BYTES));
            });
        }
    }

    /// Tests the proxies of one round against the depth so far, each under its query.
    fn draw_proxies(
        &self,
        commands: &Commands,
        history: &ViewHistory,
        view: &View,
        io: &FrameIo,
        round: std::ops::Range<usize>,
    ) {
        if round.is_empty() {
            return;
        }
        let own = history.plan().queried_draws.len() as u32;
        commands.label("proxies", |commands| {
            self.proxies.bind(commands, &ProxyIo { boxes: io.boxes }, view);
            for test in round.start as u32..round.end as u32 {
                history.queries.scope(commands, QueryIndex(own + test), |commands| {
                    self.proxies.draw(commands, test);
                });
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
