//! The counts of a view's flares: laid out for a frame, and read back some frames later without a
//! wait.

use cull::{CullView, FrameId};
use gpu::{QueryIndex, QueryRing, Tick};
use scene::LensFlare;

use crate::flares::block::FlareBlock;
use crate::flares::history::{FlareHistory, FlareSamples, FlareState};
use crate::passes::{FlareBlockRow, FlareSprite, TRANSMITTANCE_LEVELS};

/// The subject of a count. The queries of a flare are consecutive, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FlareCount {
    Total,
    Visible,
    /// The light that transparent objects let through, in levels; counted if there may be any.
    Transmitted,
}

/// A count in flight.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FlareTag {
    count: FlareCount,
    flare: u32,
    frame: FrameId,
    /// The number of samples in the whole block.
    block: u32,
    /// The number of the history that the count belongs to.
    epoch: u32,
}

/// The counts of a frame, kept to allocate nothing in the steady state.
#[derive(Default)]
pub(super) struct FlareRequests {
    pub(super) tags: Vec<FlareTag>,
    /// The blocks, and the first query of each.
    pub(super) rows: Vec<FlareBlockRow>,
    pub(super) queries: Vec<QueryIndex>,
    /// The number of pixels in all blocks.
    pub(super) cells: u32,
    /// The upper left and the lower right corner of the rectangle around all blocks, in the image
    /// of the view.
    pub(super) covering: [[u32; 2]; 2],
}

/// The flares of one view.
#[derive(Default)]
pub(crate) struct FlareCounts {
    histories: Vec<FlareHistory>,
    states: Vec<FlareState>,
    pub(super) queries: Option<QueryRing<FlareTag>>,
    /// True if the frame being recorded counts.
    pub(super) is_asking: bool,
    pub(super) asked: FlareRequests,
    collected: Vec<(u32, FlareSamples)>,
    /// The sprites of the frame being recorded, kept to allocate nothing in the steady state.
    pub(super) sprites: Vec<FlareSprite>,
    epoch: u32,
}

impl FlareCounts {
    /// Returns the states of all flares in the newest frame.
    pub(crate) fn states(&self) -> &[FlareState] {
        &self.states
    }

    /// Drops the ring. The next frame that counts creates a new one for the number of frames in
    /// flight at that time.
    pub(crate) fn forget_ring(&mut self) {
        self.queries = None;
    }

    /// Goes on with the brightness of each flare, for a view whose frames are counted anew.
    pub(crate) fn follow_device(&mut self) {
        self.forget_ring();
        self.histories.iter_mut().for_each(FlareHistory::forget_arrived);
    }

    /// Forgets all counts, including counts in flight.
    pub(crate) fn reset(&mut self) {
        self.histories.clear();
        self.epoch = self.epoch.wrapping_add(1);
    }

    /// Reads the available results. Never waits.
    pub(crate) fn collect(&mut self, completed: Tick) {
        let Some(queries) = &mut self.queries else { return };
        let collected = &mut self.collected;
        let epoch = self.epoch;
        collected.clear();
        queries.collect(completed, |tag, samples| {
            if tag.epoch != epoch {
                return;
            }
            let FlareTag { flare, frame, block, .. } = tag;
            match (tag.count, collected.last_mut()) {
                (FlareCount::Total, _) => {
                    collected.push((flare, FlareSamples::of(frame, samples, block)));
                }
                (FlareCount::Visible, Some((_, counts))) => counts.visible = samples,
                (FlareCount::Transmitted, Some((_, counts))) if counts.visible > 0 => {
                    let all = counts.visible as f32 * TRANSMITTANCE_LEVELS as f32;
                    counts.let_through = samples as f32 / all;
                }
                _ => {}
            }
        });
        for (flare, counts) in self.collected.drain(..) {
            if let Some(history) = self.histories.get_mut(flare as usize) {
                history.take(counts);
            }
        }
    }

    /// Lays out the counts of `frame` in `view`. Counts of blocks outside of the image are known at
    /// once. With `has_transmittance`, the light that transparent objects let through is counted as
    /// well.
    pub(super) fn lay_out(
        &mut self,
        flares: &[LensFlare],
        view: &CullView,
        frame: FrameId,
        has_transmittance: bool,
        samples_per_pixel: u32,
    ) {
        self.histories.resize_with(flares.len(), FlareHistory::default);
        let asked = &mut self.asked;
        asked.tags.clear();
        asked.rows.clear();
        asked.queries.clear();
        asked.cells = 0;
        asked.covering = [[u32::MAX; 2], [0; 2]];
        for ((number, flare), history) in (0..).zip(flares).zip(&mut self.histories) {
            let block = FlareBlock::of(flare, view);
            let seen = block.and_then(|block| Some((block, block.area(view.size)?)));
            let Some((block, area)) = seen else {
                history.take(FlareSamples::of(frame, 0, 0));
                continue;
            };
            let pixels = block.pixels();
            let samples = pixels * samples_per_pixel;
            let tag =
                |count| FlareTag { count, flare: number, frame, block: samples, epoch: self.epoch };
            asked.queries.push(QueryIndex(asked.tags.len() as u32));
            asked.rows.push(block.row(view.origin, asked.cells));
            asked.tags.extend([FlareCount::Total, FlareCount::Visible].map(tag));
            asked.tags.extend(has_transmittance.then(|| tag(FlareCount::Transmitted)));
            asked.cells += pixels;
            for axis in 0..2 {
                let [low, high] = &mut asked.covering;
                low[axis] = low[axis].min(area.origin[axis]);
                high[axis] = high[axis].max(area.origin[axis] + area.size[axis]);
            }
        }
    }

    /// Sets the brightness of the flares in frame `now`, by counts that are at least
    /// `frames_in_flight` frames old.
    pub(super) fn advance(&mut self, now: FrameId, frames_in_flight: usize) {
        self.states.clear();
        let delay_frames = frames_in_flight as u64;
        let histories = self.histories.iter_mut();
        self.states.extend(histories.map(|history| history.advance(now, delay_frames)));
    }

    /// Notes that the frame was submitted.
    pub(crate) fn submitted(&mut self, tick: Tick) {
        if let Some(queries) = self.queries.as_mut().filter(|_| self.is_asking) {
            queries.submitted(tick);
        }
        self.is_asking = false;
        self.histories.iter_mut().for_each(FlareHistory::submitted);
    }
}
