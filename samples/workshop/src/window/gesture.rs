//! Gestures that have not ended.

use antumbra::cull::FrameId;
use antumbra::glam::Vec2;
use winit::event::MouseButton;

use super::drag::Drag;
use crate::orbit::{CubeView, OrbitCamera};
use crate::script::Pixel;
use crate::viewport::PointedPixel;

/// The number of frames by which an answer may be older than the press or click. The image that was
/// clicked is of such a frame, since frames take some time to reach the screen.
const SHOWN_FRAMES: u64 = 3;

/// A button that is held over the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Held {
    pub(super) button: MouseButton,
    pub(super) pressed_at: Vec2,
    /// The place of the pointer that the model has followed so far.
    pub(super) followed_to: Vec2,
    pub(super) is_dragging: bool,
    /// `None` until the object below the pointer is known.
    pub(super) drag: Option<Drag>,
    pub(super) on_cube: Option<CubeView>,
    /// The newest frame at the time of the press.
    pub(super) frame: FrameId,
    pub(super) waited_s: f32,
}

/// A click that waits for its answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Click {
    pub(super) pixel: Pixel,
    /// The newest frame at the time of the release.
    pub(super) frame: FrameId,
    pub(super) waited_s: f32,
}

/// A turn to a view of the cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CubeTurn {
    pub(super) view: CubeView,
    pub(super) from: OrbitCamera,
    pub(super) seconds: f32,
}

/// Returns true if an answer is about an image that was on the screen or about to be shown when
/// `newest` was the newest frame.
pub(super) fn is_shown_at(pointed: &PointedPixel, newest: FrameId) -> bool {
    pointed.frame.0 + SHOWN_FRAMES > newest.0
}
