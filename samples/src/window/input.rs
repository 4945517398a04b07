//! The held keys, and the actions of pressed keys.

use winit::event::{ElementState, KeyEvent};
use winit::keyboard::{KeyCode, ModifiersState, PhysicalKey};

use super::actions::Action;
use super::fly_camera::Steering;
use super::menu::MenuKey;

/// The steering keys, by their place on the keyboard, independent of the layout.
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

/// The keys with actions, by their place on a US keyboard, and their names in the key table.
/// Characters would not work: Cyrillic and Greek layouts have no Latin letters.
const NAMED: [(KeyCode, &str); 47] = [
    (KeyCode::Tab, "Tab"),
    (KeyCode::Escape, "Esc"),
    (KeyCode::Space, "Space"),
    (KeyCode::Period, "."),
    (KeyCode::F1, "F1"),
    (KeyCode::F2, "F2"),
    (KeyCode::F3, "F3"),
    (KeyCode::F4, "F4"),
    (KeyCode::F5, "F5"),
    (KeyCode::F11, "F11"),
    (KeyCode::Enter, "Enter"),
    (KeyCode::NumpadEnter, "Enter"),
    (KeyCode::KeyA, "A"),
    (KeyCode::KeyB, "B"),
    (KeyCode::KeyC, "C"),
    (KeyCode::KeyD, "D"),
    (KeyCode::KeyE, "E"),
    (KeyCode::KeyF, "F"),
    (KeyCode::KeyG, "G"),
    (KeyCode::KeyH, "H"),
    (KeyCode::KeyI, "I"),
    (KeyCode::KeyJ, "J"),
    (KeyCode::KeyK, "K"),
    (KeyCode::KeyL, "L"),
    (KeyCode::KeyM, "M"),
    (KeyCode::KeyN, "N"),
    (KeyCode::KeyO, "O"),
    (KeyCode::KeyP, "P"),
    (KeyCode::KeyQ, "Q"),
    (KeyCode::KeyR, "R"),
    (KeyCode::KeyS, "S"),
    (KeyCode::KeyT, "T"),
    (KeyCode::KeyU, "U"),
    (KeyCode::KeyV, "V"),
    (KeyCode::KeyW, "W"),
    (KeyCode::KeyX, "X"),
    (KeyCode::KeyY, "Y"),
    (KeyCode::KeyZ, "Z"),
    (KeyCode::Digit1, "1"),
    (KeyCode::Digit2, "2"),
    (KeyCode::Digit3, "3"),
    (KeyCode::Digit4, "4"),
    (KeyCode::Digit5, "5"),
    (KeyCode::Digit6, "6"),
    (KeyCode::Digit7, "7"),
    (KeyCode::Digit8, "8"),
    (KeyCode::Digit9, "9"),
];

/// The held keys.
#[derive(Clone, Copy, Debug, Default)]
pub struct Input {
    held: [bool; HELD.len()],
    modifiers: ModifiersState,
}

impl Input {
    /// Handles a key press or release; returns the key's action.
    pub fn key(&mut self, event: &KeyEvent) -> Option<Action> {
        let PhysicalKey::Code(code) = event.physical_key else { return None };
        let is_down = event.state == ElementState::Pressed;
        // A key that was held before Ctrl was pressed must not stay held forever.
        if !is_down || !self.has_command_modifier() {
            self.hold(code, is_down);
        }
        if is_down && !event.repeat { self.action_of(code) } else { None }
    }

    /// Returns the effect of a key while a list or field is open.
    pub fn menu_key(&self, event: &KeyEvent) -> Option<MenuKey> {
        if event.state != ElementState::Pressed {
            return None;
        }
        let PhysicalKey::Code(code) = event.physical_key else { return None };
        if self.modifiers.control_key() {
            return (code == KeyCode::KeyV).then_some(MenuKey::Paste);
        }
        match code {
            KeyCode::ArrowUp => Some(MenuKey::Up),
            KeyCode::ArrowDown => Some(MenuKey::Down),
            KeyCode::PageUp => Some(MenuKey::PageUp),
            KeyCode::PageDown => Some(MenuKey::PageDown),
            KeyCode::Home => Some(MenuKey::First),
            KeyCode::End => Some(MenuKey::Last),
            KeyCode::Enter | KeyCode::NumpadEnter => Some(MenuKey::Enter),
            KeyCode::Backspace => Some(MenuKey::Backspace),
            // Only here the characters of the layout matter.
            _ => event.text.as_ref().map(|text| MenuKey::Text(text.to_string())),
        }
    }

    /// Sets the modifiers that are currently held.
    pub fn set_modifiers(&mut self, modifiers: ModifiersState) {
        self.modifiers = modifiers;
    }

    /// Returns true while a modifier is held that makes keys commands of the desktop.
    fn has_command_modifier(&self) -> bool {
        self.modifiers
            .intersects(ModifiersState::CONTROL | ModifiersState::ALT | ModifiersState::SUPER)
    }

    fn action_of(&self, code: KeyCode) -> Option<Action> {
        let (_, name) = NAMED.iter().find(|(named, _)| *named == code)?;
        if !self.has_command_modifier() {
            return Action::of_key(name);
        }
        let is_control =
            self.modifiers.difference(ModifiersState::SHIFT) == ModifiersState::CONTROL;
        if is_control { Action::of_key(&format!("Ctrl+{name}")) } else { None }
    }

    fn hold(&mut self, code: KeyCode, is_down: bool) {
        if let Some(place) = HELD.iter().position(|held| *held == code) {
            self.held[place] = is_down;
        }
    }

    /// Releases all keys: releases outside of the window are not reported.
    pub fn release(&mut self) {
        *self = Self::default();
    }

    /// Returns the steering by keys.
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
    use crate::window::actions::{FILE_KEYS, KEYS};

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
    /// Checks that every key of the tables has a place on the keyboard, which no layout changes.
    #[test]
    fn every_key_of_the_tables_has_a_place_on_the_keyboard() {
        let input = Input::default();
        for (name, _, action) in KEYS.iter().chain(&FILE_KEYS) {
            let (modifiers, plain) = match name.strip_prefix("Ctrl+") {
                Some(plain) => (ModifiersState::CONTROL, plain),
                None => (ModifiersState::empty(), *name),
            };
            let input = Input { modifiers, ..input };
            let place = NAMED.iter().find(|(_, named)| *named == plain);
            let (code, _) = place.unwrap_or_else(|| panic!("{name} is on no keyboard"));
            assert_eq!(input.action_of(*code), Some(*action), "{name}");
        }
        assert_eq!(input.action_of(KeyCode::Digit3), Some(Action::Camera(3)));
        assert_eq!(input.action_of(KeyCode::F24), None);
    }

    #[test]
    fn commands_of_the_desktop_are_left_to_it() {
        for modifiers in [ModifiersState::ALT, ModifiersState::SUPER, ModifiersState::CONTROL] {
            let input = Input { modifiers, ..Input::default() };
            assert_eq!(input.action_of(KeyCode::Tab), None, "{modifiers:?}");
        }
        let input = Input { modifiers: ModifiersState::SHIFT, ..Input::default() };
        assert_eq!(input.action_of(KeyCode::Tab), Some(Action::NextStrategy));
    }
}
