//! The keys that are held, and what those that are struck do.

use winit::event::{ElementState, KeyEvent};
use winit::keyboard::{Key, KeyCode, NamedKey, PhysicalKey};

use super::deeds::Deed;
use super::fly_camera::Steering;

/// Keys that steer, by their place on the keyboard: what they mean in a layout does not matter.
const HELD: [KeyCode; 8] = [
    KeyCode::KeyW,
    KeyCode::KeyS,
    KeyCode::KeyD,
    KeyCode::KeyA,
    KeyCode::KeyE,
    KeyCode::KeyQ,
    KeyCode::ShiftLeft,
    KeyCode::ShiftRight,
];

/// What hands do.
#[derive(Clone, Copy, Debug, Default)]
pub struct Input {
    held: [bool; HELD.len()],
    /// Whether the mouse looks around.
    pub is_looking: bool,
}

impl Input {
    /// A key went down or up; answers what is to be done.
    pub fn key(&mut self, event: &KeyEvent) -> Option<Deed> {
        let is_down = event.state == ElementState::Pressed;
        if let PhysicalKey::Code(code) = event.physical_key {
            self.hold(code, is_down);
        }
        if !is_down || event.repeat {
            return None;
        }
        match &event.logical_key {
            Key::Named(NamedKey::Tab) => Deed::of_key("Tab"),
            Key::Named(NamedKey::Escape) => Deed::of_key("Esc"),
            Key::Named(NamedKey::Space) => Deed::of_key("Space"),
            Key::Character(letter) => Deed::of_key(letter),
            _ => None,
        }
    }

    fn hold(&mut self, code: KeyCode, is_down: bool) {
        if let Some(place) = HELD.iter().position(|held| *held == code) {
            self.held[place] = is_down;
        }
    }

    /// Nothing is held any more: what happens elsewhere is not told.
    pub fn release(&mut self) {
        *self = Self::default();
    }

    /// Where the keys steer.
    pub fn steering(&self) -> Steering {
        let between = |forth: usize, back: usize| {
            f32::from(u8::from(self.held[forth])) - f32::from(u8::from(self.held[back]))
        };
        Steering {
            ahead: between(0, 1),
            right: between(2, 3),
            up: between(4, 5),
            hurries: self.held[6] || self.held[7],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_held_steers() {
        let mut input = Input::default();
        input.hold(KeyCode::KeyW, true);
        input.hold(KeyCode::KeyA, true);
        input.hold(KeyCode::ShiftRight, true);
        let steering = Steering { ahead: 1.0, right: -1.0, up: 0.0, hurries: true };
        assert_eq!(input.steering(), steering);
        input.hold(KeyCode::KeyS, true);
        input.hold(KeyCode::KeyK, true);
        assert_eq!(input.steering(), Steering { ahead: 0.0, ..steering });
        input.release();
        assert_eq!(input.steering(), Steering::default());
    }
}
