//! The conditions under which frames are measured: measurements under different ones are never
//! mixed.

use antumbra::gpu::PresentMode;

use bench::strategy::Strategy;

/// The properties that frames must share to be measured together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conditions {
    /// The strategy that decides about draws.
    pub strategy: Strategy,
    /// The size of the image, in pixels.
    pub size: [u32; 2],
    /// Frames in flight.
    pub frames_in_flight: usize,
    /// The present mode of the window, if there is one.
    pub present_mode: Option<PresentMode>,
    /// The number of the scene, different for each that is shown.
    pub scene: u32,
    /// True if each frame is drawn twice, to be compared.
    pub is_comparing: bool,
}
