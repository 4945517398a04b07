//! A stopwatch: the time since the last lap.

use std::time::Instant;

/// A stopwatch of laps in milliseconds.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch {
    last: Instant,
}

impl Stopwatch {
    /// Starts a stopwatch.
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
