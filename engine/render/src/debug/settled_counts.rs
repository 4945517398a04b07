//! Counts that may decide about images: of frames as old as frames are in flight, however early
//! their results arrived.

use cull::{FrameId, ObjectId};

use crate::debug::sample_counts::VisibleSamples;

/// The counts of watched objects by which a view decides. Those of younger frames wait: when
/// results arrive depends on the GPU's time, and images must not.
#[derive(Default)]
pub(crate) struct SettledCounts {
    waiting: Vec<VisibleSamples>,
    /// The newest count of each object among those that are old enough, ascending by object.
    settled: Vec<VisibleSamples>,
    /// Counts up to this frame are forgotten.
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

    /// Forgets the counts of all objects but those to keep.
    pub(super) fn retain(&mut self, keep: impl Fn(&VisibleSamples) -> bool) {
        self.waiting.retain(&keep);
        self.settled.retain(&keep);
    }

    /// Forgets all counts up to those of frame `now`, those on their way too.
    pub(super) fn forget(&mut self, now: FrameId) {
        self.retain(|_| false);
        self.forgotten = Some(now);
    }

    /// Returns the visible samples of an object's proxy. They do not depend on the level of detail
    /// of the object itself, so that a coarser one does not change what it is chosen by. `None`
    /// where they are not known, also for an object out of sight.
    pub(crate) fn visible_of(&self, object: ObjectId) -> Option<u32> {
        let place = self.settled.binary_search_by_key(&object, |known| known.object).ok()?;
        self.settled.get(place)?.proxy.map(|proxy| proxy.visible)
    }
}

/// Keeps a count unless a newer one of its object is known. The counts are ascending by object.
pub(super) fn keep_newest(newest: &mut Vec<VisibleSamples>, known: VisibleSamples) {
    match newest.binary_search_by_key(&known.object, |newest| newest.object) {
        Ok(place) if newest[place].frame < known.frame => newest[place] = known,
        Ok(_) => {}
        Err(place) => newest.insert(place, known),
    }
}
