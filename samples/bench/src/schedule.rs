//! The order in which strategies take turns: rounds of consecutive frames, so that ratios of their
//! times mean something on a noisy machine.
//!
//! Turns frame by frame would be fairer to the noise but not to the caches: a strategy that touches
//! the whole scene leaves them cold for the next one. Hence rounds, each begun by warm-up frames
//! that do not count, and a rotating order, so that no strategy always follows the same one.

/// The fewest consecutive timed frames of a round, if the walk has that many.
pub const ROUND_FRAMES: u32 = 12;
/// The frames walked again before each round's first timed one.
pub const WARM_UP_FRAMES: u32 = 4;

/// The strategy and the frame that are drawn next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WalkStep {
    /// The index of the strategy among those compared.
    pub strategy: usize,
    /// The frame of the walk.
    pub frame: u32,
    /// True if it counts; a warm-up frame does not.
    pub timed: bool,
}

/// A plan for a whole walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    frames: u32,
    strategies: usize,
    round_frames: u32,
    warm_up_frames: u32,
}

impl Schedule {
    /// Creates a schedule in rounds of [`ROUND_FRAMES`] or somewhat more, warmed up by
    /// [`WARM_UP_FRAMES`].
    pub fn new(frames: u32, strategies: usize) -> Self {
        Self::with_rounds(frames, strategies, ROUND_FRAMES, WARM_UP_FRAMES)
    }

    /// Creates a schedule whose rounds have at least `round_frames` timed frames each (at least 10,
    /// or all frames if there are fewer), after `warm_up_frames` others.
    pub fn with_rounds(
        frames: u32,
        strategies: usize,
        round_frames: u32,
        warm_up_frames: u32,
    ) -> Self {
        Self { frames, strategies, round_frames: round_frames.max(10), warm_up_frames }
    }

    /// Returns the number of rounds that each strategy walks.
    pub fn rounds(&self) -> u32 {
        (self.frames / self.round_frames).max(1)
    }

    /// Returns the number of frames that are drawn in all, warm-up included.
    pub fn len(&self) -> u64 {
        let warm_up = u64::from(self.rounds()) * u64::from(self.warm_up_frames);
        let strategies = u64::try_from(self.strategies).unwrap_or(u64::MAX);
        if self.is_empty() { 0 } else { strategies * (u64::from(self.frames) + warm_up) }
    }

    /// Returns true if there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.frames == 0 || self.strategies == 0
    }

    /// Returns the frames in the order in which they are to be drawn.
    ///
    /// Every strategy walks every frame exactly once as a timed frame, in ascending order. A
    /// round's warm-up walks the frames before its first timed one; before the start of the walk
    /// the camera stands still.
    pub fn steps(&self) -> impl Iterator<Item = WalkStep> + use<> {
        let schedule = *self;
        let rounds = if schedule.is_empty() { 0 } else { schedule.rounds() };
        (0..rounds).flat_map(move |round| {
            (0..schedule.strategies).flat_map(move |turn| {
                let rotation = usize::try_from(round).unwrap_or(0) % schedule.strategies;
                schedule.turn(round, (turn + rotation) % schedule.strategies)
            })
        })
    }

    fn turn(self, round: u32, strategy: usize) -> impl Iterator<Item = WalkStep> {
        let first = self.boundary(round);
        let end = self.boundary(round + 1);
        let warm_up = (1..=self.warm_up_frames).rev().map(move |back| WalkStep {
            strategy,
            frame: first.saturating_sub(back),
            timed: false,
        });
        warm_up.chain((first..end).map(move |frame| WalkStep { strategy, frame, timed: true }))
    }

    /// Returns the first frame of a round: the rounds' lengths differ by one at most.
    fn boundary(self, round: u32) -> u32 {
        let frame = u64::from(self.frames) * u64::from(round) / u64::from(self.rounds());
        u32::try_from(frame).unwrap_or(self.frames)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_short_walk_is_one_round() {
        let steps: Vec<_> = Schedule::with_rounds(2, 2, 10, 1).steps().collect();
        let step = |strategy, frame, timed| WalkStep { strategy, frame, timed };
        assert_eq!(
            steps,
            [
                step(0, 0, false),
                step(0, 0, true),
                step(0, 1, true),
                step(1, 0, false),
                step(1, 0, true),
                step(1, 1, true),
            ]
        );
    }

    #[test]
    fn warm_up_walks_the_frames_before_the_round() {
        let steps = Schedule::with_rounds(24, 1, 12, 4).steps();
        let warm_up: Vec<u32> = steps.filter(|step| !step.timed).map(|step| step.frame).collect();
        assert_eq!(warm_up, [0, 0, 0, 0, 8, 9, 10, 11]);
    }

    #[test]
    fn nothing_to_draw_gives_no_steps() {
        for schedule in [Schedule::new(0, 2), Schedule::new(5, 0)] {
            assert_eq!((schedule.steps().count(), schedule.len()), (0, 0));
        }
    }

    /// Returns the turns of a schedule that has a warm-up: strategy, warm-up frames, timed frames.
    fn turns(schedule: &Schedule) -> Vec<(usize, Vec<u32>, Vec<u32>)> {
        let mut turns: Vec<(usize, Vec<u32>, Vec<u32>)> = Vec::new();
        let mut last_was_timed = true;
        for step in schedule.steps() {
            if last_was_timed && !step.timed {
                turns.push((step.strategy, vec![], vec![]));
            }
            last_was_timed = step.timed;
            let (strategy, warm_up, timed) = turns.last_mut().unwrap();
            assert_eq!(*strategy, step.strategy, "a turn belongs to one strategy");
            if step.timed { timed.push(step.frame) } else { warm_up.push(step.frame) }
        }
        turns
    }

    proptest! {
        #[test]
        fn every_strategy_walks_every_frame_once_in_order(
            frames in 1u32..200, strategies in 1usize..6, round in 0u32..40, warm_up in 0u32..8
        ) {
            let schedule = Schedule::with_rounds(frames, strategies, round, warm_up);
            for strategy in 0..strategies {
                let timed = schedule.steps().filter(|step| step.timed && step.strategy == strategy);
                prop_assert!(timed.map(|step| step.frame).eq(0..frames));
            }
            prop_assert_eq!(schedule.steps().count() as u64, schedule.len());
        }

        #[test]
        fn rounds_are_long_warmed_up_and_rotate(
            frames in 1u32..200, strategies in 2usize..6, round in 10u32..40, warm_up in 1u32..8
        ) {
            let schedule = Schedule::with_rounds(frames, strategies, round, warm_up);
            let turns = turns(&schedule);
            prop_assert_eq!(turns.len(), schedule.rounds() as usize * strategies);
            for (number, (strategy, warmed_up, timed)) in turns.iter().enumerate() {
                let round_number = number / strategies;
                prop_assert_eq!(*strategy, (number % strategies + round_number) % strategies);
                prop_assert!(timed.len() as u32 >= round.min(frames));
                prop_assert_eq!(warmed_up.len() as u32, warm_up);
                prop_assert!(timed.windows(2).all(|pair| pair[1] == pair[0] + 1));
                for (back, frame) in warmed_up.iter().rev().enumerate() {
                    prop_assert_eq!(*frame, timed[0].saturating_sub(back as u32 + 1));
                }
            }
        }
    }
}
