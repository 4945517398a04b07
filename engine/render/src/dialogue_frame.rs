//! A frame of a dialogue from top to bottom: batch by batch, each sent off before the next is decided.
//!
//! ```text
//! batch       the first clears; draws, some under a query each, then boxes under a query each;
//!             answers -> mapped memory; submit
//! ...         as long as the method has something to ask; it says when to wait for an answer
//! shaded      the picture, where the batches drew the depth only; `surfaces` in scenes that have any
//! ```
//!
//! The answers to a batch are read when its tick is over: nothing asks the driver for a query.

use std::collections::VecDeque;
use std::ops::Range;

use cull::{
    Batch, BatchDraw, Dialogue, DialogueOptions, DialogueStats, FirstPass, Hierarchy, LeafIndex,
    PlanStats, Step, Strategy, TestAnswer, TestToken, View,
};
use gpu::{
    BufferSlice, Commands, Counting, Device, Frame, IndirectDraw, QueryIndex, QueryPages,
    RenderTarget, Tick, Timeline,
};

use crate::error::Error;
use crate::frame_passes::FramePasses;
use crate::passes::{OpaquePass, ProxyBox, ProxyIo};
use crate::shader_set::ShaderSet;
use crate::view_state::ViewState;

const DRAW_BYTES: u64 = size_of::<IndirectDraw>() as u64;

/// What one view keeps for dialogues.
pub(crate) struct DialogueHistory {
    dialogue: Dialogue,
    queries: QueryPages,
}

impl DialogueHistory {
    fn new(device: &Device, frames_in_flight: usize, options: DialogueOptions) -> Self {
        Self {
            dialogue: Dialogue::new(options),
            queries: QueryPages::new(device, frames_in_flight, "dialogue queries"),
        }
    }
}

/// What all views share.
pub(crate) struct DialogueFrame {
    options: DialogueOptions,
    depth_first: Option<DepthFirst>,
}

/// Where the batches draw the depth only.
struct DepthFirst {
    depth: OpaquePass,
    colour: OpaquePass,
}

/// What one frame is made from.
pub(crate) struct DialogueRequest<'a> {
    pub(crate) hierarchy: &'a Hierarchy,
    pub(crate) strategy: Strategy,
    pub(crate) view: &'a View,
    pub(crate) after: Option<(&'a Timeline, Tick)>,
}

/// A part of a frame that was sent off and has answers to give.
struct Piece {
    queries: Range<u32>,
    tick: Tick,
}

/// A batch in the memory of its frame.
struct BatchIo {
    draws: BufferSlice,
    proxies: ProxyIo,
    queries: Range<u32>,
}

impl DialogueFrame {
    /// Compiles what the options need.
    ///
    /// # Errors
    /// A failed call.
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        options: DialogueOptions,
    ) -> Result<Self, Error> {
        let depth_first = match options.coherent.first_pass {
            FirstPass::Shaded => None,
            FirstPass::DepthOnly => Some(DepthFirst {
                depth: OpaquePass::depth_only(device, shaders)?,
                colour: OpaquePass::colour_only(device, shaders)?,
            }),
        };
        Ok(Self { options, depth_first })
    }

    /// Records a frame up to its last batch, which is not sent off yet.
    ///
    /// # Errors
    /// No memory, a lost device, an answer that takes too long.
    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        history: &mut ViewState,
        passes: &mut FramePasses,
        request: &DialogueRequest<'_>,
    ) -> Result<DialogueStats, Error> {
        history.begin_unplanned(frame, request.hierarchy)?;
        let ViewState { dialogue: kept, plan, device, frames_in_flight, .. } = history;
        let neglected = &mut history.neglected_by_dialogue;
        let new = || DialogueHistory::new(device, *frames_in_flight, self.options);
        let DialogueHistory { dialogue, queries } = kept.get_or_insert_with(new);
        let (hierarchy, strategy, view) = (request.hierarchy, request.strategy, request.view);
        let Some(mut conversation) = dialogue.begin(hierarchy, strategy, view) else {
            return Ok(DialogueStats::default());
        };
        queries.begin(frame.slot());
        let (mut batch, mut home, mut under_way) = (Batch::default(), Vec::new(), VecDeque::new());
        let mut is_first = true;
        loop {
            let step = conversation.next(&home, &mut batch);
            plan.draws.extend(batch.draws.iter().map(|draw| draw.leaf));
            if is_first || !batch.is_empty() {
                let io = BatchIo::write(frame, &batch, queries, passes)?;
                let target = match is_first {
                    true => passes.first_target(view),
                    false => passes.next_target(view),
                };
                let batch = (&batch, &io);
                self.record_batch(frame.commands(), batch, queries, passes, request, target);
                is_first = false;
                if step != Step::Done {
                    let tick = frame.flush(request.after)?;
                    under_way.push_back(Piece { queries: io.queries, tick });
                }
            }
            match step {
                Step::Done => break,
                Step::Submit => {}
                Step::Wait(token) => wait(frame, &under_way, token)?,
            }
            collect(device.completed()?, &mut under_way, queries, &mut home);
        }
        let stats = conversation.stats();
        *neglected = stats.neglected_samples;
        plan.stats = PlanStats {
            nodes_visited: stats.nodes_visited,
            frontier: stats.boxes,
            visible: stats.draws,
            too_near: stats.too_near,
            ..PlanStats::default()
        };
        self.record_end(frame, &plan.draws, passes, request)?;
        Ok(stats)
    }

    /// Records one batch, from a colour or from what is there.
    fn record_batch(
        &self,
        commands: &Commands,
        (batch, io): (&Batch, &BatchIo),
        queries: &QueryPages,
        passes: &mut FramePasses,
        request: &DialogueRequest<'_>,
        target: RenderTarget,
    ) {
        let counting = match self.options.coherent.visibility_threshold_samples {
            0 => Counting::Some,
            _ => Counting::Samples,
        };
        passes.target.prepare(commands);
        commands.pass("draw and query", |commands| {
            commands.rendering(target, |commands| {
                if !batch.draws.is_empty() {
                    match self.depth_first(request.strategy, passes) {
                        Some(DepthFirst { depth, .. }) => {
                            let io = passes.opaque_io();
                            depth.bind(commands, &io, request.view, &passes.light);
                        }
                        None => passes.bind_rounds(commands, request.view),
                    }
                    draw(commands, &batch.draws, io.draws, queries, counting);
                }
                if !batch.tests.is_empty() {
                    passes.proxies.bind(commands, &io.proxies, request.view);
                }
                for (number, test) in (0..).zip(&batch.tests) {
                    queries.scope(commands, QueryIndex(test.token.0), counting, |commands| {
                        passes.proxies.draw(commands, number);
                    });
                }
            });
            queries.read_back(commands, io.queries.clone());
        });
    }

    /// The option's passes, in scenes that are not drawn depth first anyway.
    fn depth_first(&self, strategy: Strategy, passes: &FramePasses) -> Option<&DepthFirst> {
        let wants = strategy == Strategy::Coherent && passes.shading.is_none();
        self.depth_first.as_ref().filter(|_| wants)
    }

    /// Draws the picture if there is only its depth so far.
    fn record_end(
        &self,
        frame: &mut Frame<'_>,
        drawn: &[LeafIndex],
        passes: &mut FramePasses,
        request: &DialogueRequest<'_>,
    ) -> Result<(), Error> {
        let depth_first = self.depth_first(request.strategy, passes);
        if depth_first.is_none() && passes.shading.is_none() {
            return Ok(());
        }
        let geometry = &passes.geometry;
        let draws = drawn.iter().map(|leaf| geometry.draw(*leaf));
        let draws = frame.uploads().push_iter(draws)?.part(0, drawn.len() as u64 * DRAW_BYTES);
        let commands = frame.commands();
        passes.shade(commands, request.view, |_, commands| commands.draw_indirect(draws));
        if let Some(DepthFirst { colour, .. }) = depth_first {
            passes.target.prepare(commands);
            commands.pass("shade", |commands| {
                commands.rendering(passes.target_of(request.view, None), |commands| {
                    colour.bind(commands, &passes.opaque_io(), request.view, &passes.light);
                    commands.draw_indirect(draws);
                });
            });
        }
        Ok(())
    }
}

impl BatchIo {
    /// Writes `batch` into the memory of `frame`, and takes a query for each of its questions: those
    /// of a batch have consecutive tokens, and a token is the number of its query.
    fn write(
        frame: &mut Frame<'_>,
        batch: &Batch,
        queries: &mut QueryPages,
        passes: &FramePasses,
    ) -> Result<Self, Error> {
        let asked = batch.draws.iter().filter(|draw| draw.token.is_some()).count();
        let count = (asked + batch.tests.len()) as u32;
        let queries = queries.take(frame.commands(), count)?;
        let uploads = frame.uploads();
        let draws = batch.draws.iter().map(|draw| passes.geometry.draw(draw.leaf));
        let boxes = batch.tests.iter().map(|test| ProxyBox::from(test.bounds));
        Ok(Self {
            draws: uploads.push_iter(draws)?,
            proxies: ProxyIo { boxes: uploads.push_iter(boxes)?, flags: None },
            queries,
        })
    }
}

/// Draws in one call from one leaf that is asked about to the next.
fn draw(
    commands: &Commands,
    leaves: &[BatchDraw],
    draws: BufferSlice,
    queries: &QueryPages,
    counting: Counting,
) {
    let part = |range: Range<usize>| {
        let bytes = |draws: usize| draws as u64 * DRAW_BYTES;
        draws.part(bytes(range.start), bytes(range.len()))
    };
    let mut drawn = 0;
    for (place, token) in
        leaves.iter().enumerate().filter_map(|(place, it)| Some((place, it.token?)))
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

/// Waits for the piece that answers a question.
fn wait(frame: &mut Frame<'_>, under_way: &VecDeque<Piece>, token: TestToken) -> Result<(), Error> {
    match under_way.iter().find(|piece| piece.queries.contains(&token.0)) {
        Some(piece) => Ok(frame.wait(piece.tick)?),
        None => Ok(()),
    }
}

/// Takes the answers of the pieces that are over, in their order.
fn collect(
    completed: Tick,
    under_way: &mut VecDeque<Piece>,
    queries: &QueryPages,
    home: &mut Vec<TestAnswer>,
) {
    home.clear();
    while let Some(piece) = under_way.pop_front_if(|piece| piece.tick <= completed) {
        home.extend(piece.queries.map(|query| TestAnswer {
            token: TestToken(query),
            samples: queries.samples(QueryIndex(query)),
        }));
    }
}
