//! Counts that may decide about images. With N frames in flight they are at least N frames old,
//! even if their results arrived earlier.

use cull::{FrameId, ObjectId};

use crate::debug::sample_counts::VisibleSamples;

/// The counts of watched objects by which a view decides. Younger counts wait: the arrival of
/// results depends on the time that the GPU takes, and images must not depend on it.
#[derive(Default)]
pub(crate) struct SettledCounts {
    waiting: Vec<VisibleSamples>,
    /// The newest count of each object among those that are old enough, ascending by object.
    settled: Vec<VisibleSamples>,
    /// The frame up to which counts are forgotten.
    forgotten: Option<FrameId>,
}

impl SettledCounts {
    /// Takes a count, in any order.
    pub(super) fn take(&mut self, known: VisibleSamples) {
        if self.forgotten.is_none_or(|frame| known.frame > frame) {
            self.waiting.push(known);
        }
    }

    /// Settles the counts that are at least `delay_frames` old in frame `now`.
    pub(super) fn settle(&mut self, now: FrameId, delay_frames: u64) {
        let Self { waiting, settled, .. } = self;
        waiting.retain(|known| {
            let is_young = known.frame.0 + delay_frames > now.0;
            if !is_young {
                keep_newest(settled, *known);
            }
            is_young
        });
    }

    /// Forgets all counts for which `keep` returns false.
    pub(super) fn retain(&mut self, keep: impl Fn(&VisibleSamples) -> bool) {
        self.waiting.retain(&keep);
        self.settled.retain(&keep);
    }

    /// Forgets all counts up to frame `now`, including counts in flight.
    pub(super) fn forget(&mut self, now: FrameId) {
        self.retain(|_| false);
        self.forgotten = Some(now);
    }

    /// Returns the visible samples of an object's proxy. They do not depend on the object's level
    /// of detail, so a coarser level does not change its own reason. `None` if they are not known,
    /// or for an object outside of the frustum.
    pub(crate) fn visible_of(&self, object: ObjectId) -> Option<u32> {
        let place = self.settled.binary_search_by_key(&object, |known| known.object).ok()?;
        self.settled.get(place)?.proxy.map(|proxy| proxy.visible)
    }
}

/// Keeps a count, unless a newer count of its object is known. The counts are ascending by object.
pub(super) fn keep_newest(newest: &mut Vec<VisibleSamples>, known: VisibleSamples) {
    match newest.binary_search_by_key(&known.object, |newest| newest.object) {
        Ok(place) if newest[place].frame < known.frame => newest[place] = known,
        Ok(_) => {}
        Err(place) => newest.insert(place, known),
    }
}
