//! Input events of the window, and the keys.

use antumbra::glam::Vec2;
use winit::event::MouseButton;
use winit::keyboard::{KeyCode, ModifiersState};

/// An input event. Places are in pixels from the upper left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InputEvent {
    /// The pointer moved over the model.
    Moved(Vec2),
    /// The pointer left the model, for a panel or another window.
    Left,
    /// A button was pressed over the model.
    Pressed(MouseButton),
    /// A button was released.
    Released(MouseButton),
    /// The wheel turned away from the user, in notches.
    Wheel(f32),
    /// A key was pressed.
    Key(KeyCode),
    /// The held modifier keys have changed.
    Modifiers(ModifiersState),
}

/// A row of the page of keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeyLine {
    /// The name of the key.
    pub key: &'static str,
    /// The effect.
    pub what: &'static str,
}

/// The keys and buttons, as the page of keys shows them.
pub const KEY_LINES: [KeyLine; 21] = [
    line("left drag", "turn the model; the lid, if it is held there"),
    line("right drag, wheel", "move the model; nearer and farther"),
    line("click, Ctrl+click", "select a part; add it or take it away"),
    line("Esc", "end measuring, the path, the selection"),
    line("F, O", "fit all; perspective or orthographic"),
    line("1 2 3 4 5 6", "front, back, left, right, top, bottom"),
    line("7", "from the corner"),
    line("arrows, + -", "turn by 15 degrees; zoom"),
    line("H, G", "hide, show transparent"),
    line("I, S", "isolate, show all"),
    line("X, Y, Z", "section plane across an axis"),
    line("E", "next way to draw edges"),
    line("D, L", "measure distances, lengths of edges"),
    line("B", "open or close the lid"),
    line("R", "record the camera's path, or end"),
    line("P", "play the path, or end"),
    line("K", "save the image as workshop.png"),
    line("J", "export the model as workshop.glb"),
    line("T", "tools and parts, or the image alone"),
    line("F1", "these keys"),
    line("F11", "full screen"),
];

const fn line(key: &'static str, what: &'static str) -> KeyLine {
    KeyLine { key, what }
}
