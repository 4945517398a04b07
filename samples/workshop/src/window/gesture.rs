//! Gestures that are not over yet.

use antumbra::cull::FrameId;
use antumbra::glam::Vec2;
use winit::event::MouseButton;

use super::drag::Drag;
use crate::orbit::{CubeView, OrbitCamera};
use crate::script::Pixel;
use crate::viewport::PointedPixel;

/// The frames by which an answer may be older than the press or click that takes it: those that are
/// on their way to the screen, whose image is what was clicked.
const SHOWN_FRAMES: u64 = 3;

/// A button that is pressed over the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Held {
    pub(super) button: MouseButton,
    pub(super) pressed_at: Vec2,
    /// The place up to which the model followed.
    pub(super) followed_to: Vec2,
    pub(super) is_dragging: bool,
    /// `None` until it is known what is below the pointer.
    pub(super) drag: Option<Drag>,
    pub(super) on_cube: Option<CubeView>,
    /// The newest frame when it was pressed.
    pub(super) frame: FrameId,
    pub(super) waited_s: f32,
}

/// A click whose answer is awaited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Click {
    pub(super) pixel: Pixel,
    /// The newest frame when it was released.
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

/// Returns true if an answer is about an image that was on the screen, or on its way there, when
/// this frame was the newest.
pub(super) fn is_shown_at(pointed: &PointedPixel, newest: FrameId) -> bool {
    pointed.frame.0 + SHOWN_FRAMES > newest.0
}
