//! The common base of all rings: the tags and memory of each frame, kept per slot until the results
//! arrive.
//!
//! A slot belongs to one frame until its tick is over: only then may the data be read that the
//! frame wrote to the slot's memory. The ring does not depend on the kind of test.

use crate::core::deletion::RecordingId;
use crate::core::tick::Tick;
use crate::record::frames::SlotIndex;

/// The tags `T` and memory `M` of each frame in flight.
pub(crate) struct Ring<T, M> {
    slots: Vec<Slot<T, M>>,
    /// The slot of the frame being recorded.
    current: usize,
}

/// The tags and memory of one frame.
pub(crate) struct Slot<T, M> {
    pub(crate) number: usize,
    /// The memory for the results, kept for later frames of the slot.
    pub(crate) memory: M,
    /// The caller's tags, returned with the results.
    pub(crate) tags: Vec<T>,
    /// The recording that the slot was begun for.
    recording: RecordingId,
    is_recording: bool,
    /// The frame whose results this slot holds; `None` while recording and after they are
    /// collected.
    in_flight: Option<Tick>,
    /// True if the last frame of the slot never ran.
    is_undefined: bool,
}

impl<T, M: Default> Ring<T, M> {
    pub(crate) fn new(frames_in_flight: usize) -> Self {
        let slot = |number| Slot {
            number,
            memory: M::default(),
            tags: Vec::new(),
            recording: RecordingId::default(),
            is_recording: false,
            in_flight: None,
            is_undefined: false,
        };
        Self { slots: (0..frames_in_flight.max(1)).map(slot).collect(), current: 0 }
    }

    pub(crate) fn slots_mut(&mut self) -> impl Iterator<Item = &mut Slot<T, M>> {
        self.slots.iter_mut()
    }

    /// Passes every slot whose frame is over to `answer`, once, oldest first: a history should get
    /// answers in the order of their frames. Frames that are lost by `is_lost` never ran, and have
    /// no results.
    pub(crate) fn collect(
        &mut self,
        completed: Tick,
        is_lost: impl Fn(Tick) -> bool,
        mut answer: impl FnMut(&Slot<T, M>),
    ) {
        loop {
            let is_over =
                |slot: &&mut Slot<T, M>| slot.in_flight.is_some_and(|tick| tick <= completed);
            let over = self.slots.iter_mut().filter(is_over);
            let Some(slot) = over.min_by_key(|slot| slot.in_flight) else {
                return;
            };
            match slot.in_flight.take() {
                Some(tick) if is_lost(tick) => slot.is_undefined = true,
                _ => answer(slot),
            }
        }
    }

    /// Switches to the slot of the frame that is recorded next. Also returns true if the last frame
    /// begun in it was never submitted or is lost by `is_lost`, so that its memory is undefined.
    pub(crate) fn turn_to(
        &mut self,
        slot: SlotIndex,
        is_lost: impl Fn(Tick) -> bool,
    ) -> (&mut Slot<T, M>, bool) {
        self.current = slot.0 % self.slots.len();
        let slot = &mut self.slots[self.current];
        let was_given_up = std::mem::take(&mut slot.is_recording);
        let was_lost =
            std::mem::take(&mut slot.is_undefined) || slot.in_flight.is_some_and(is_lost);
        (slot, was_given_up || was_lost)
    }

    pub(crate) fn current(&self) -> &Slot<T, M> {
        &self.slots[self.current]
    }

    pub(crate) fn current_mut(&mut self) -> &mut Slot<T, M> {
        &mut self.slots[self.current]
    }

    /// Notes the tick of the frame that was begun last, unless it was noted before.
    pub(crate) fn submitted(&mut self, tick: Tick) {
        let slot = &mut self.slots[self.current];
        if std::mem::take(&mut slot.is_recording) {
            slot.in_flight = Some(tick);
        }
    }
}

impl<T, M> Slot<T, M> {
    /// Begins to record a frame with its tags. Results that were not collected are dropped.
    pub(crate) fn begin(&mut self, recording: RecordingId, tags: impl Iterator<Item = T>) {
        (self.recording, self.is_recording, self.in_flight) = (recording, true, None);
        self.tags.clear();
        self.tags.extend(tags);
    }

    /// Returns true if the slot was begun for `recording`.
    pub(crate) fn is_begun_for(&self, recording: RecordingId) -> bool {
        self.recording == recording
    }

    /// Returns true between the beginning of a frame and its submit.
    pub(crate) fn is_recording(&self) -> bool {
        self.is_recording
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Records a frame in a slot and submits it as the tick.
    fn frame(ring: &mut Ring<char, ()>, slot: usize, tag: char, tick: u64) {
        let (slot, _) = ring.turn_to(SlotIndex(slot), |_| false);
        slot.begin(RecordingId::default(), [tag].into_iter());
        ring.submitted(Tick(tick));
    }

    fn collected(ring: &mut Ring<char, ()>, completed: u64) -> String {
        let mut tags = String::new();
        ring.collect(Tick(completed), |_| false, |slot| tags.extend(&slot.tags));
        tags
    }

    #[test]
    fn answers_come_once_and_in_the_order_of_their_frames() {
        let mut ring = Ring::new(3);
        frame(&mut ring, 2, 'a', 1);
        frame(&mut ring, 0, 'b', 2);
        frame(&mut ring, 1, 'c', 4);
        assert_eq!(collected(&mut ring, 0), "");
        assert_eq!(collected(&mut ring, 3), "ab");
        assert_eq!(collected(&mut ring, 3), "");
        assert_eq!(collected(&mut ring, 4), "c");
    }

    #[test]
    fn a_slot_that_is_used_again_forgets_what_nobody_collected() {
        let mut ring = Ring::new(1);
        frame(&mut ring, 0, 'a', 1);
        let (slot, was_given_up) = ring.turn_to(SlotIndex(0), |_| false);
        assert!(!was_given_up);
        slot.begin(RecordingId::default(), ['b'].into_iter());
        assert!(ring.current().is_recording());
        assert_eq!(collected(&mut ring, 9), "", "it is being recorded");
    }

    #[test]
    fn a_frame_that_is_given_up_is_known_and_never_answers() {
        let mut ring = Ring::new(2);
        let (slot, _) = ring.turn_to(SlotIndex(0), |_| false);
        slot.begin(RecordingId::default(), ['a'].into_iter());
        frame(&mut ring, 1, 'b', 1);
        assert!(ring.turn_to(SlotIndex(0), |_| false).1);
        assert_eq!(collected(&mut ring, 9), "b");
        // A frame without tags is submitted as well.
        assert!(!ring.turn_to(SlotIndex(1), |_| false).1);
        ring.submitted(Tick(2));
        assert_eq!(collected(&mut ring, 9), "");
    }

    #[test]
    fn a_frame_that_never_ran_does_not_answer_and_leaves_undefined_memory() {
        for is_collected in [true, false] {
            let mut ring = Ring::new(2);
            frame(&mut ring, 0, 'a', 1);
            frame(&mut ring, 1, 'b', 2);
            let is_lost = |tick| tick == Tick(1);
            let mut tags = String::new();
            if is_collected {
                ring.collect(Tick(2), is_lost, |slot| tags.extend(&slot.tags));
                assert_eq!(tags, "b");
            }
            assert!(ring.turn_to(SlotIndex(0), is_lost).1);
            assert!(!ring.turn_to(SlotIndex(1), is_lost).1);
        }
    }
}
