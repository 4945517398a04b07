//! The motion in a walk: moves the renderer's scene to a frame before that is drawn.

use std::time::{Duration, Instant};

use antumbra::import::SceneAnimator;
use antumbra::render::Renderer;
use antumbra::scene::Scene;
use scenes::{Cast, Motion};

use crate::playback::FrameClock;
use crate::run_error::RunError;

/// The movers of a walk, as the renderer shows them now. Any frame can follow any other.
pub struct Moving(Movers);

/// The kinds of movers.
enum Movers {
    /// Objects of a scene that was generated.
    Made { motion: Motion, cast: Cast },
    /// Objects that the clips of a file move.
    Played { animator: Box<SceneAnimator>, clock: FrameClock },
}

impl Moving {
    /// Creates movers for `percent` of the objects of `scene`.
    ///
    /// # Errors
    /// More than 100 percent.
    pub fn new(scene: &Scene, percent: u32, seed: u64) -> Result<Self, RunError> {
        let motion = Motion::new(scene, percent, seed)?;
        let cast = Cast::new(&motion);
        Ok(Self(Movers::Made { motion, cast }))
    }

    /// Returns the motion of the clips that `animator` plays, by `clock`.
    pub fn played(animator: SceneAnimator, clock: FrameClock) -> Self {
        Self(Movers::Played { animator: Box::new(animator), clock })
    }

    /// Returns the number of objects that move.
    pub fn movers(&self) -> usize {
        match &self.0 {
            Movers::Made { motion, .. } => motion.movers(),
            Movers::Played { animator, .. } => animator.moving_objects(),
        }
    }

    /// Shows `frame` and returns the CPU time in the engine, which is 0 if nothing moves.
    ///
    /// # Errors
    /// When the renderer refuses a change.
    pub fn show(&mut self, renderer: &mut Renderer, frame: u32) -> Result<Duration, RunError> {
        match &mut self.0 {
            Movers::Made { motion, .. } if motion.movers() == 0 => Ok(Duration::ZERO),
            Movers::Made { motion, cast } => {
                let report = renderer.update(cast.changes(motion, frame))?;
                cast.came(&report.added);
                Ok(report.cpu)
            }
            Movers::Played { animator, clock } => {
                let began = Instant::now();
                renderer.apply(animator.changes(clock.seconds(frame)))?;
                Ok(began.elapsed())
            }
        }
    }
}
