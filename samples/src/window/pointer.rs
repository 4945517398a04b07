//! The mouse: looks around while a button is held or the mouse is captured; a click identifies an
//! object.

/// The least movement of a drag, in pixels: with less movement, a press and release is a click.
const DRAG_PIXELS: f64 = 4.0;

/// A button with an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// The left button: a click identifies the object below it.
    Left,
    /// The right button: a click captures or frees the mouse.
    Right,
}

/// The effect of an event of the mouse on the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointerAction {
    /// Keep the mouse in the window and hide it.
    Grab,
    /// Free the mouse and show it.
    Release,
    /// Identify the object below the mouse, or in the middle of the image if the mouse is captured.
    Identify,
}

/// The state of the mouse.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pointer {
    is_captured: bool,
    /// The held button, and the distance that the mouse has moved since, in pixels.
    held: Option<(Button, f64)>,
}

impl Pointer {
    /// Returns true while movements turn the camera.
    pub fn is_looking(&self) -> bool {
        self.is_captured || self.is_dragging()
    }

    /// Returns true while the mouse is kept in the window.
    pub fn is_captured(&self) -> bool {
        self.is_captured
    }

    fn is_dragging(&self) -> bool {
        self.held.is_some_and(|(_, moved_pixels)| moved_pixels >= DRAG_PIXELS)
    }

    /// Handles a press. While a button is held, others are ignored.
    pub fn press(&mut self, button: Button) {
        self.held.get_or_insert((button, 0.0));
    }

    /// Handles a movement, in pixels to the right and down.
    pub fn move_by(&mut self, right: f64, down: f64) -> Option<PointerAction> {
        let was_looking = self.is_looking();
        if let Some((_, moved_pixels)) = &mut self.held {
            *moved_pixels += right.hypot(down);
        }
        (self.is_looking() && !was_looking).then_some(PointerAction::Grab)
    }

    /// Handles a release.
    pub fn release(&mut self, button: Button) -> Option<PointerAction> {
        let (held, moved_pixels) = self.held.take_if(|(held, _)| *held == button)?;
        match held {
            _ if moved_pixels >= DRAG_PIXELS => {
                (!self.is_captured).then_some(PointerAction::Release)
            }
            Button::Left => Some(PointerAction::Identify),
            Button::Right => Some(self.toggle_capture()),
        }
    }

    /// Captures or frees the mouse.
    pub fn toggle_capture(&mut self) -> PointerAction {
        self.is_captured = !self.is_captured;
        if self.is_captured { PointerAction::Grab } else { PointerAction::Release }
    }

    /// Frees the mouse from any mode; `None` if it was free already.
    pub fn free(&mut self) -> Option<PointerAction> {
        let was_looking = self.is_looking();
        *self = Self::default();
        was_looking.then_some(PointerAction::Release)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_button_looks_around_until_it_is_released() {
        for button in [Button::Left, Button::Right] {
            let mut pointer = Pointer::default();
            assert_eq!(pointer.move_by(100.0, 0.0), None, "nothing is held");
            pointer.press(button);
            assert_eq!((pointer.move_by(1.0, 1.0), pointer.is_looking()), (None, false));
            assert_eq!(pointer.move_by(0.0, -3.0), Some(PointerAction::Grab));
            assert_eq!((pointer.move_by(9.0, 0.0), pointer.is_looking()), (None, true));
            assert_eq!(pointer.release(button), Some(PointerAction::Release));
            assert!(!pointer.is_looking() && !pointer.is_captured());
        }
    }

    #[test]
    fn a_left_click_identifies_and_a_right_one_captures() {
        let mut pointer = Pointer::default();
        pointer.press(Button::Left);
        assert_eq!(pointer.release(Button::Left), Some(PointerAction::Identify));
        pointer.press(Button::Right);
        assert_eq!(pointer.release(Button::Right), Some(PointerAction::Grab));
        assert!(pointer.is_captured() && pointer.is_looking());
        // While captured, a click still identifies, and a drag does not free the mouse.
        pointer.press(Button::Left);
        assert_eq!(pointer.release(Button::Left), Some(PointerAction::Identify));
        pointer.press(Button::Left);
        assert_eq!(pointer.move_by(50.0, 0.0), None);
        assert_eq!((pointer.release(Button::Left), pointer.is_captured()), (None, true));
        assert_eq!(pointer.free(), Some(PointerAction::Release));
        assert_eq!((pointer.free(), pointer.is_looking()), (None, false));
    }

    #[test]
    fn a_second_button_changes_nothing() {
        let mut pointer = Pointer::default();
        pointer.press(Button::Left);
        pointer.press(Button::Right);
        assert_eq!(pointer.release(Button::Right), None);
        assert_eq!(pointer.release(Button::Left), Some(PointerAction::Identify));
        assert_eq!(pointer.release(Button::Left), None);
    }
}
