//! A stopwatch: the time since it was last looked at.

use std::time::Instant;

/// Measures laps in milliseconds.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch {
    last: Instant,
}

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Self {
        Self { last: Instant::now() }
    }

    /// Returns the time since the start or the last lap, in milliseconds.
    pub fn lap_ms(&mut self) -> f64 {
        let now = Instant::now();
        let lap = now - self.last;
        self.last = now;
        lap.as_secs_f64() * 1e3
    }
}
