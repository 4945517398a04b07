//! What moves in a walk: brings the renderer's scene to a frame before that is drawn.

use std::time::Duration;

use render::Renderer;
use render::scene::{Cast, Motion, Scene};

use crate::run::RunError;

/// The movers of a walk, as the renderer shows them now. Any frame can follow any other.
pub struct Moving {
    motion: Motion,
    cast: Cast,
}

impl Moving {
    /// Lets `percent` of the objects of `scene` move.
    ///
    /// # Errors
    /// More than 100 percent.
    pub fn new(scene: &Scene, percent: u32, seed: u64) -> Result<Self, RunError> {
        let motion = Motion::new(scene, percent, seed)?;
        let cast = Cast::new(&motion);
        Ok(Self { motion, cast })
    }

    /// How many objects move.
    pub fn movers(&self) -> usize {
        self.motion.movers()
    }

    /// Shows `frame`; answers the CPU's time in the engine. Takes none where nothing moves.
    ///
    /// # Errors
    /// When the renderer refuses a change.
    pub fn show(&mut self, renderer: &mut Renderer, frame: u32) -> Result<Duration, RunError> {
        if self.movers() == 0 {
            return Ok(Duration::ZERO);
        }
        Ok(renderer.show(&self.motion, &mut self.cast, frame)?.cpu)
    }
}
