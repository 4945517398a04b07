//! The frame of a method that needs results before it can continue. Each batch is submitted before
//! the next is decided. A state machine in `cull` decides about the draws and tests.
//!
//! ```text
//! batch       the first clears; draws, some under a query each, then boxes under a query each;
//!             results -> mapped memory; submit
//! ...         as long as the method has tests; it says when to wait for a result
//! shaded      the image, where the batches drew the depth only; `surfaces` in scenes that have
//!             any
//! ```
//!
//! The results of a batch are read when its tick is over; queries are not read through the driver.

use std::collections::VecDeque;
use std::ops::Range;

use cull::{
    Batch, BatchDraw, BlockingCuller, BlockingKind, BlockingStats, CullView, FirstPass, LeafIndex,
    NextAction, PlanStats, Strategy, TestAnswer, TestToken,
};
use gpu::{
    BlockingQueryPool, BufferSlice, Commands, Counting, Frame, IndirectDraw, OptionalFeature,
    QueryIndex, Tick,
};
use occlusion::{
    BucketId, CulledScene, Error, LeafTable, Method, MethodConstructor, MethodRequest, MethodState,
    MethodStats, MethodSupport, ObjectPass, OcclusionState, ProxyBox, ProxyIo, ProxyPass,
    Rendering, ShadedObjects, ShaderSet, UpcomingDraws, render,
};

/// The state of one view for all blocking methods. Each method keeps its history while another is
/// in use.
struct BlockingState {
    cullers: Vec<(BlockingKind, BlockingCuller)>,
    queries: BlockingQueryPool,
}

impl MethodState for BlockingState {}

/// A blocking method.
#[derive(Clone, Copy)]
struct BlockingMethod {
    strategy: [Strategy; 1],
    kind: BlockingKind,
}

pub(crate) fn blocking(strategy: Strategy, kind: BlockingKind) -> MethodConstructor {
    let method = BlockingMethod { strategy: [strategy], kind };
    MethodConstructor::new(move || Box::new(method))
}

/// A submitted part of a frame with results to come.
struct Submission {
    queries: Range<u32>,
    tick: Tick,
}

/// A batch in the memory of its frame.
struct BatchIo {
    draws: BufferSlice,
    proxies: ProxyIo,
    queries: Range<u32>,
}

impl Method for BlockingMethod {
    fn strategies(&self) -> &[Strategy] {
        &self.strategy
    }

    fn supports(&self, strategy: Strategy, support: &MethodSupport<'_>) -> Result<(), Error> {
        support.needs_one_draw_per_leaf(strategy)?;
        let is_precise = support.scene.device().capabilities().has(OptionalFeature::PreciseQueries);
        match self.counting() {
            Counting::Samples if !is_precise => {
                Err(support.missing(OptionalFeature::PreciseQueries, strategy))
            }
            _ => Ok(()),
        }
    }

    fn prepare(
        &mut self,
        _scene: &CulledScene,
        objects: &mut dyn ShadedObjects,
        shaders: &ShaderSet,
    ) -> Result<(), Error> {
        if !self.is_depth_first(objects) {
            return Ok(());
        }
        objects.prepare(ObjectPass::Depth, shaders)?;
        objects.prepare(ObjectPass::Colour, shaders)
    }

    fn record(
        &mut self,
        frame: &mut Frame<'_>,
        state: &mut OcclusionState,
        scene: &mut CulledScene,
        objects: &mut dyn ShadedObjects,
        request: &MethodRequest<'_>,
    ) -> Result<MethodStats, Error> {
        state.check(scene)?;
        state.begin_unplanned(frame, scene, request.view)?;
        let mut kept = state.take_method_state::<BlockingState>().unwrap_or_else(|| {
            let slots = state.frames_in_flight();
            let name = "blocking queries";
            let queries = BlockingQueryPool::new(scene.device(), slots, name);
            Box::new(BlockingState { cullers: Vec::new(), queries })
        });
        let stats = self.record_batches(frame, state, &mut kept, scene, objects, request);
        state.put_method_state(kept);
        let stats = stats?;
        state.note_samples_below_threshold(stats.samples_below_threshold);
        Ok(MethodStats { tests: stats.boxes, queries: stats.boxes + stats.visible_draw_queries })
    }

    fn reloaded(
        &self,
        _scene: &CulledScene,
        _objects: &mut dyn ShadedObjects,
        _shaders: &ShaderSet,
    ) -> Result<Box<dyn Method>, Error> {
        Ok(Box::new(*self))
    }
}

impl BlockingMethod {
    /// Returns the kind of queries. They count samples if a threshold needs it.
    fn counting(&self) -> Counting {
        if self.kind.counts_samples() { Counting::Samples } else { Counting::Some }
    }

    /// Returns true if the batches draw only depth and the colour comes last: an option of the
    /// method, for scenes that are not drawn in this way anyway.
    fn is_depth_first(&self, objects: &dyn ShadedObjects) -> bool {
        self.kind.first_pass() == FirstPass::DepthOnly && !objects.shades_later()
    }

    /// Records a frame and submits all its batches except the last.
    fn record_batches(
        &self,
        frame: &mut Frame<'_>,
        state: &mut OcclusionState,
        kept: &mut BlockingState,
        scene: &CulledScene,
        objects: &mut dyn ShadedObjects,
        request: &MethodRequest<'_>,
    ) -> Result<BlockingStats, Error> {
        let BlockingState { cullers, queries } = kept;
        let mut decisions = culler_of(self.kind, cullers).begin(scene.hierarchy(), request.view);
        queries.begin(frame.slot());
        objects.prepare_draws(frame.commands(), UpcomingDraws::All);
        let plan = state.plan_mut();
        let mut batch = Batch::default();
        let mut answers = Vec::new();
        let mut under_way = VecDeque::new();
        let mut is_first = true;
        loop {
            let step = decisions.next(&answers, &mut batch);
            plan.draws.extend(batch.draws.iter().map(|draw| draw.leaf));
            if is_first || !batch.is_empty() {
                let io = BatchIo::write(frame, &batch, queries, scene.leaves())?;
                let rendering = if is_first { Rendering::First } else { Rendering::Next };
                let recorded = RecordedBatch { batch: &batch, io: &io, rendering };
                let proxies = &scene.passes().proxies;
                let commands = frame.commands();
                self.record_batch(commands, &recorded, queries, proxies, objects, request.view);
                is_first = false;
                if step != NextAction::Done {
                    let tick = frame.flush(request.after)?;
                    under_way.push_back(Submission { queries: io.queries, tick });
                }
            }
            match step {
                NextAction::Done => break,
                NextAction::Submit => {}
                NextAction::Wait(token) => wait(frame, &under_way, token)?,
            }
            collect(scene.device().completed()?, &mut under_way, queries, &mut answers);
        }
        let stats = decisions.stats();
        plan.stats = PlanStats {
            nodes_visited: stats.nodes_visited,
            frontier: stats.boxes,
            visible: stats.draws,
            too_near: stats.too_near,
            ..PlanStats::default()
        };
        self.record_end(frame, &plan.draws, scene, objects, request.view)?;
        Ok(stats)
    }

    /// Records one batch.
    fn record_batch(
        &self,
        commands: &Commands,
        recorded: &RecordedBatch<'_>,
        queries: &BlockingQueryPool,
        proxies: &ProxyPass,
        objects: &mut dyn ShadedObjects,
        view: &CullView,
    ) {
        let RecordedBatch { batch, io, rendering } = *recorded;
        let counting = self.counting();
        let is_depth_first = self.is_depth_first(objects);
        objects.target().prepare(commands);
        commands.pass("draw and query", |commands| {
            render(objects, commands, view, rendering, |commands, objects| {
                if !batch.draws.is_empty() {
                    if is_depth_first {
                        objects.bind_pass(commands, view, BucketId(0), ObjectPass::Depth);
                    } else {
                        objects.bind(commands, view, BucketId(0));
                    }
                    draw(commands, &batch.draws, io.draws, queries, counting);
                }
                if !batch.tests.is_empty() {
                    proxies.bind(commands, &io.proxies, view);
                }
                for (number, test) in (0..).zip(&batch.tests) {
                    queries.scope(commands, QueryIndex(test.token.0), counting, |commands| {
                        proxies.draw(commands, number);
                    });
                }
            });
            queries.read_back(commands, io.queries.clone());
        });
    }

    /// Draws the image if only its depth has been drawn so far.
    fn record_end(
        &self,
        frame: &mut Frame<'_>,
        drawn: &[LeafIndex],
        scene: &CulledScene,
        objects: &mut dyn ShadedObjects,
        view: &CullView,
    ) -> Result<(), Error> {
        let is_depth_first = self.is_depth_first(objects);
        if !is_depth_first && !objects.shades_later() {
            return Ok(());
        }
        let draws = drawn.iter().map(|leaf| scene.leaves().draw(*leaf));
        let draws =
            frame.uploads().push_iter(draws)?.elements::<IndirectDraw>(0..drawn.len() as u32);
        let commands = frame.commands();
        objects.shade(scene, commands, view, &|commands, bind| {
            bind(commands, BucketId(0));
            commands.draw_indirect(draws);
        });
        if is_depth_first {
            objects.target().prepare(commands);
            commands.pass("shade", |commands| {
                commands.rendering(objects.colour_rendering(view), |commands| {
                    objects.bind_pass(commands, view, BucketId(0), ObjectPass::Colour);
                    commands.draw_indirect(draws);
                });
            });
        }
        Ok(())
    }
}

/// A batch in the memory of its frame.
struct RecordedBatch<'a> {
    batch: &'a Batch,
    io: &'a BatchIo,
    rendering: Rendering,
}

impl BatchIo {
    /// Writes `batch` into the memory of `frame`, and takes a query for each of its tests. The
    /// tests of a batch have consecutive tokens, and a token is the number of its query.
    fn write(
        frame: &mut Frame<'_>,
        batch: &Batch,
        queries: &mut BlockingQueryPool,
        leaves: &LeafTable,
    ) -> Result<Self, Error> {
        let queried = batch.draws.iter().filter(|draw| draw.token.is_some()).count();
        let count = (queried + batch.tests.len()) as u32;
        let queries = queries.take(frame.commands(), count)?;
        let uploads = frame.uploads();
        let draws = batch.draws.iter().map(|draw| leaves.draw(draw.leaf));
        let boxes = batch.tests.iter().map(|test| ProxyBox::from(test.bounds));
        Ok(Self {
            draws: uploads.push_iter(draws)?,
            proxies: ProxyIo { boxes: uploads.push_iter(boxes)?, flags: None },
            queries,
        })
    }
}

/// Draws leaves. The leaves between two queried ones share one call.
fn draw(
    commands: &Commands,
    leaves: &[BatchDraw],
    draws: BufferSlice,
    queries: &BlockingQueryPool,
    counting: Counting,
) {
    let part =
        |range: Range<usize>| draws.elements::<IndirectDraw>(range.start as u32..range.end as u32);
    let mut drawn = 0;
    for (place, token) in
        leaves.iter().enumerate().filter_map(|(place, leaf)| Some((place, leaf.token?)))
    {
        if drawn < place {
            commands.draw_indirect(part(drawn..place));
        }
        queries.scope(commands, QueryIndex(token.0), counting, |commands| {
            commands.draw_indirect(part(place..place + 1));
        });
        drawn = place + 1;
    }
    if drawn < leaves.len() {
        commands.draw_indirect(part(drawn..leaves.len()));
    }
}

fn culler_of(
    kind: BlockingKind,
    cullers: &mut Vec<(BlockingKind, BlockingCuller)>,
) -> &mut BlockingCuller {
    let place = cullers.iter().position(|(of, _)| *of == kind).unwrap_or_else(|| {
        cullers.push((kind, BlockingCuller::new(kind)));
        cullers.len() - 1
    });
    &mut cullers[place].1
}

/// Waits for the submission that contains a query.
fn wait(
    frame: &mut Frame<'_>,
    under_way: &VecDeque<Submission>,
    token: TestToken,
) -> Result<(), Error> {
    match under_way.iter().find(|piece| piece.queries.contains(&token.0)) {
        Some(piece) => Ok(frame.wait(piece.tick)?),
        None => Ok(()),
    }
}

/// Reads the results of the submissions that are over, in their order.
fn collect(
    completed: Tick,
    under_way: &mut VecDeque<Submission>,
    queries: &BlockingQueryPool,
    answers: &mut Vec<TestAnswer>,
) {
    answers.clear();
    while let Some(piece) = under_way.pop_front_if(|piece| piece.tick <= completed) {
        answers.extend(piece.queries.map(|query| TestAnswer {
            token: TestToken(query),
            samples: queries.samples(QueryIndex(query)),
        }));
    }
}
