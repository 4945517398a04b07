//! Frames with and without culling, drawn in pairs and compared bit for bit.

use std::time::Duration;

use antumbra::gpu::{Device, Readback, Tick};
use antumbra::pacing::Time;
use antumbra::render::{RenderView, Renderer};

use super::differences::{Differences, PixelArea};
use bench::run_error::RunError;
use bench::strategy::Strategy;

/// The time for which each side is shown.
const TURN_S: f64 = 0.5;
/// The most pending pairs; a frame without a free pair is not compared.
const PAIRS: usize = 3;
/// The time for which differing areas stay marked.
const MARKED_FOR: Duration = Duration::from_secs(2);

/// One frame of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The frame with culling, by the current strategy.
    Culled,
    /// The frame without culling: all objects in the frustum.
    Unculled,
}

/// The results of a comparison so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// The pairs that were compared.
    pub frames: u64,
    /// The number of these pairs that differed.
    pub differing: u64,
    /// The pixels that differed in the newest pair.
    pub newest_pixels: u64,
    /// The most pixels that differed in any pair.
    pub worst_pixels: u64,
}

impl Tally {
    fn add(&mut self, differences: &Differences) {
        self.frames += 1;
        self.differing += u64::from(differences.pixels > 0);
        self.newest_pixels = differences.pixels;
        self.worst_pixels = self.worst_pixels.max(differences.pixels);
    }

    /// Returns the results as a text.
    pub fn text(&self) -> String {
        match (self.frames, self.differing) {
            (0, _) => "nothing compared yet".to_owned(),
            (frames, 0) => format!("0 pixels differ in {frames} frames"),
            (frames, differing) => format!(
                "{} pixels differ now; {differing} of {frames} frames differ, at most by {} pixels",
                self.newest_pixels, self.worst_pixels
            ),
        }
    }
}

/// The two images of one moment.
struct Pair {
    images: [Readback; 2],
    /// The tick after which both can be read; `None` if nothing is pending.
    tick: Option<Tick>,
}

/// A running comparison.
pub struct Comparison {
    /// The history of the frames without culling, which keeps the history with culling unchanged.
    pub(super) unculled: RenderView,
    pairs: Vec<Pair>,
    strategy: Strategy,
    tally: Tally,
    marks: Vec<PixelArea>,
    marked_until: Time,
    seconds: f64,
}

impl Comparison {
    /// Forgets the images of a lost device; the results so far stay.
    pub fn forget_images(&mut self) {
        self.pairs.clear();
    }

    /// Begins to compare frames of `renderer`.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(renderer: &Renderer, strategy: Strategy) -> Result<Self, RunError> {
        Ok(Self {
            unculled: renderer.new_view()?,
            pairs: Vec::new(),
            strategy,
            tally: Tally::default(),
            marks: Vec::new(),
            marked_until: Time::ZERO,
            seconds: 0.0,
        })
    }

    /// Advances the time by `seconds`; returns true if the other side is shown from now on.
    pub fn advance(&mut self, seconds: f32) -> bool {
        let before = self.shown();
        if seconds.is_finite() {
            self.seconds += f64::from(seconds.max(0.0));
        }
        before != self.shown()
    }

    /// Returns the side that is shown.
    pub fn shown(&self) -> Side {
        match (self.seconds / TURN_S) as u64 % 2 {
            0 => Side::Culled,
            _ => Side::Unculled,
        }
    }

    /// Returns the results so far.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// Returns the areas in which images differ or recently did.
    pub fn marks(&self, now: Time) -> &[PixelArea] {
        if now < self.marked_until { &self.marks } else { &[] }
    }

    /// Resets the results if they are of another strategy.
    pub fn follow(&mut self, strategy: Strategy) {
        if self.strategy != strategy {
            self.strategy = strategy;
            self.tally = Tally::default();
            self.marks.clear();
            // The pending pairs are of the other strategy.
            self.pairs.clear();
        }
    }

    /// Returns the index of a free pair, for images of the renderer's size.
    ///
    /// # Errors
    /// Not enough memory.
    pub fn free_pair(&mut self, renderer: &Renderer) -> Result<Option<usize>, RunError> {
        let size = renderer.size();
        self.pairs.retain(|pair| pair.images[0].size() == size);
        let free = self.pairs.iter().position(|pair| pair.tick.is_none());
        if free.is_some() || self.pairs.len() >= PAIRS {
            return Ok(free);
        }
        let image = || Readback::new(renderer.device(), size);
        self.pairs.push(Pair { images: [image()?, image()?], tick: None });
        Ok(Some(self.pairs.len() - 1))
    }

    /// Returns the view of the frames without culling, and the buffer to which a side of a pair is
    /// copied.
    pub fn split(&mut self, pair: usize, side: Side) -> (&mut RenderView, Option<&Readback>) {
        let image = self.pairs.get(pair).map(|pair| &pair.images[side as usize]);
        (&mut self.unculled, image)
    }

    /// Notes that both images of a pair can be read once `tick` has completed.
    pub fn sent(&mut self, pair: usize, tick: Tick) {
        if let Some(pair) = self.pairs.get_mut(pair) {
            pair.tick = Some(tick);
        }
    }

    /// Compares the images that can be read; never waits. Returns true if a pair differed.
    ///
    /// # Errors
    /// A lost device.
    pub fn collect(&mut self, device: &Device, now: Time) -> Result<bool, RunError> {
        let completed = device.completed()?;
        let mut is_news = false;
        for pair in &mut self.pairs {
            if pair.tick.take_if(|tick| *tick <= completed).is_none() {
                continue;
            }
            let [culled, unculled] = &pair.images;
            let differences =
                Differences::between(&culled.rgba8()?, &unculled.rgba8()?, culled.size()[0]);
            self.tally.add(&differences);
            if differences.pixels > 0 {
                self.marks = differences.areas;
                self.marked_until = now.after(MARKED_FOR);
                is_news = true;
            }
        }
        Ok(is_news)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tally_says_what_differs() {
        let mut tally = Tally::default();
        assert_eq!(tally.text(), "nothing compared yet");
        tally.add(&Differences::default());
        tally.add(&Differences::default());
        assert_eq!(tally.text(), "0 pixels differ in 2 frames");
        tally.add(&Differences { pixels: 30, areas: Vec::new() });
        tally.add(&Differences { pixels: 4, areas: Vec::new() });
        let text = "4 pixels differ now; 2 of 4 frames differ, at most by 30 pixels";
        assert_eq!(tally.text(), text);
        tally.add(&Differences::default());
        assert!(tally.text().starts_with("0 pixels differ now; 2 of 5"), "{}", tally.text());
    }
}
