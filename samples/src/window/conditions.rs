//! The conditions under which frames are measured: measurements under different conditions are
//! never mixed.

use antumbra::gpu::PresentMode;

use bench::strategy::Strategy;

/// The properties that frames must share to be measured together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conditions {
    /// The strategy that decides about draws.
    pub strategy: Strategy,
    /// The size of the image, in pixels.
    pub size: [u32; 2],
    /// The number of frames in flight.
    pub frames_in_flight: usize,
    /// The present mode of the window, if there is one.
    pub present_mode: Option<PresentMode>,
    /// The number of the scene, different for each shown scene.
    pub scene: u32,
    /// True if each frame is drawn twice for a comparison.
    pub is_comparing: bool,
}
