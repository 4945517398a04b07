//! The inputs of the execution of a plan, in the memory of its frame.

use cull::CullView;
use gpu::{BufferSlice, Frame, LeafDrawBuffers, ResultSource};

use crate::error::Error;
use crate::leaf_table::LeafTable;
use crate::occlusion_state::OcclusionState;
use crate::passes::{ComputeTestIo, EyeConstants, ListDrawsIo, ProxyBox, ProxyEyes, ProxyIo};

/// The buffers that one frame reads from its slot's memory.
pub(super) struct FrameIo {
    /// The visible draws, by bucket.
    pub(super) visible: BufferSlice,
    pub(super) proxies: ProxyIo,
    pub(super) computed: Option<ComputeTestIo>,
    pub(super) leaf_draws: Option<LeafDrawBuffers>,
    /// The lists of revealed draws, where draws are compacted.
    pub(super) lists: Option<ListDrawsIo>,
    /// The constants of the views, where several are drawn at once.
    eyes: Option<BufferSlice>,
}

impl FrameIo {
    /// Writes the newest plan of `state` into the memory of `frame`, and begins its tests. Its
    /// predicates begin with its [recording](FrameIo::begin_predicates).
    pub(super) fn write(
        frame: &mut Frame<'_>,
        state: &mut OcclusionState,
        leaves: &LeafTable,
        views: &[CullView],
    ) -> Result<Self, Error> {
        let several = Some(views).filter(|views| views.len() > 1);
        state.begin(frame, leaves, views.len() as u32)?;
        let rings = state.rings();
        let visible = state.layout.visible.cells().iter();
        let plan = state.plan();
        let uploads = frame.uploads();
        let boxes = uploads.push_iter(plan.tests.iter().map(|t| ProxyBox::from(t.bounds)))?;
        let results = rings.computed.results();
        let eyes = several.map(|views| uploads.push_iter(views.iter().map(EyeConstants::of)));
        Ok(Self {
            eyes: eyes.transpose()?,
            visible: uploads.push_iter(visible.map(|cell| leaves.layout.command(*cell)))?,
            proxies: ProxyIo { boxes, flags: rings.flags.results() },
            computed: results.map(|results| ComputeTestIo { boxes, results, first: 0, count: 0 }),
            leaf_draws: rings.leaf_draws.buffers(),
            lists: None,
        })
    }

    /// Begins the predicates of the plan, which the views of a scene share: right before the plan
    /// is recorded, since another view may be recorded after this one was written.
    pub(super) fn begin_predicates(
        frame: &mut Frame<'_>,
        state: &OcclusionState,
        leaves: &mut LeafTable,
    ) -> Result<(), Error> {
        let rings = state.rings();
        let results = [
            (ResultSource::Queries, rings.queries.results()),
            (ResultSource::Fragments, rings.flags.results()),
            (ResultSource::Compute, rings.computed.results()),
        ];
        for (source, results) in results {
            let decided = state.layout.decided(source).iter().copied();
            leaves.predicates.begin(frame, source, results, decided)?;
        }
        Ok(())
    }

    /// Returns the views that proxies are drawn in: `view`, or several views drawn at once.
    pub(super) fn eyes<'a>(&self, view: &'a CullView) -> ProxyEyes<'a> {
        self.eyes.map_or(ProxyEyes::One(view), ProxyEyes::Several)
    }
}
