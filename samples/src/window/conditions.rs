//! The conditions under which frames are measured: numbers of different ones are never mixed.

use gpu::PresentMode;

use bench::strategy::Strategy;

/// What frames must have in common to be measured together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conditions {
    /// What decides what is drawn.
    pub strategy: Strategy,
    /// Size of the picture, in pixels.
    pub size: [u32; 2],
    /// Frames in flight.
    pub frames_in_flight: usize,
    /// How pictures follow each other in the window, if there is one.
    pub present_mode: Option<PresentMode>,
    /// The number of the scene: each that is shown has another one.
    pub scene: u32,
    /// Whether each frame is drawn twice, to be compared.
    pub is_comparing: bool,
}
