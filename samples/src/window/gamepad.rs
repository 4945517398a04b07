//! Gamepads: sticks and triggers steer, buttons trigger actions.
//!
//! [`PadState`] turns positions into steering, and [`action_of`] maps buttons to actions; both are
//! pure. The crate `gilrs` reads the devices of the system, and knows where their buttons are.
//! Without a gamepad, or permission to read it, nothing happens.

use gilrs::{Axis, Button, EventType, Gilrs, GilrsBuilder};

use super::actions::Action;
use super::fly_camera::Steering;

/// The share of a stick's range within which it counts as released.
const DEAD_ZONE: f32 = 0.15;
/// The rate at which a fully deflected stick turns the camera, in mouse pixels per second.
const TURN_PIXELS_A_SECOND: f64 = 700.0;

/// The positions of sticks and triggers: sticks from -1 to 1, to the right and away from the user;
/// triggers from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PadState {
    left: [f32; 2],
    right: [f32; 2],
    triggers: [f32; 2],
}

impl PadState {
    /// Moves a stick. Other axes have no effect.
    pub fn move_axis(&mut self, axis: Axis, value: f32) {
        let value = in_range(value);
        match axis {
            Axis::LeftStickX => self.left[0] = value,
            Axis::LeftStickY => self.left[1] = value,
            Axis::RightStickX => self.right[0] = value,
            Axis::RightStickY => self.right[1] = value,
            _ => {}
        }
    }

    /// Pulls a trigger. Other buttons have no effect.
    pub fn pull(&mut self, button: Button, value: f32) {
        let value = in_range(value).max(0.0);
        match button {
            Button::LeftTrigger2 => self.triggers[0] = value,
            Button::RightTrigger2 => self.triggers[1] = value,
            _ => {}
        }
    }

    /// Returns the steering: the left stick moves, the triggers move down and up.
    pub fn steering(&self) -> Steering {
        let [right, ahead] = shaped(self.left);
        let [down, up] = self.triggers.map(|trigger| shaped([trigger, 0.0])[0]);
        Steering { ahead, right, up: up - down, hurries: false }
    }

    /// Returns the camera turn of the right stick in `seconds`, in mouse pixels to the right and
    /// down.
    pub fn turn(&self, seconds: f32) -> [f64; 2] {
        let [right, up] = shaped(self.right);
        [right, -up].map(|part| f64::from(part) * TURN_PIXELS_A_SECOND * f64::from(seconds))
    }
}

/// Returns a position from -1 to 1, whatever a device reports.
fn in_range(value: f32) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(-1.0, 1.0) }
}

/// Returns a stick's position without the dead zone, with fine control near the middle. The
/// direction is preserved.
fn shaped(place: [f32; 2]) -> [f32; 2] {
    let [x, y] = place;
    let distance = x.hypot(y);
    if distance <= DEAD_ZONE {
        return [0.0, 0.0];
    }
    let beyond = ((distance - DEAD_ZONE) / (1.0 - DEAD_ZONE)).min(1.0);
    [x, y].map(|part| part / distance * beyond * beyond)
}

/// Returns the action of a button.
pub fn action_of(button: Button) -> Option<Action> {
    match button {
        Button::South => Some(Action::NextStrategy),
        Button::West => Some(Action::Freeze),
        Button::North => Some(Action::Compare),
        Button::East => Some(Action::TopDown),
        Button::RightThumb => Some(Action::Identify(None)),
        Button::Start => Some(Action::Help),
        _ => None,
    }
}

/// The gamepads of the system. All of them steer.
pub struct Gamepads {
    devices: Gilrs,
    state: PadState,
}

impl Gamepads {
    /// Opens the gamepads, and those that come later; `None` if the system has no way to.
    pub fn open() -> Option<Self> {
        // The dead zone is ours.
        let devices = GilrsBuilder::new().with_default_filters(false).build();
        let devices = devices.inspect_err(|error| tracing::info!("no gamepads: {error}")).ok()?;
        Some(Self { devices, state: PadState::default() })
    }

    /// Returns the positions of sticks and triggers.
    pub fn state(&self) -> PadState {
        self.state
    }

    /// Reads what the devices report, until a button has an action. Never waits.
    pub fn next_action(&mut self) -> Option<Action> {
        while let Some(event) = self.devices.next_event() {
            match event.event {
                EventType::AxisChanged(axis, value, _) => self.state.move_axis(axis, value),
                EventType::ButtonChanged(button, value, _) => self.state.pull(button, value),
                EventType::Disconnected => self.state = PadState::default(),
                EventType::Connected => {
                    tracing::info!("gamepad {}", self.devices.gamepad(event.id).name());
                }
                EventType::ButtonPressed(button, _) => {
                    if let Some(action) = action_of(button) {
                        return Some(action);
                    }
                }
                _ => {}
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn moved(axes: &[(Axis, f32)]) -> PadState {
        let mut state = PadState::default();
        axes.iter().for_each(|(axis, value)| state.move_axis(*axis, *value));
        state
    }

    fn pulled(triggers: &[(Button, f32)]) -> PadState {
        let mut state = PadState::default();
        triggers.iter().for_each(|(trigger, value)| state.pull(*trigger, *value));
        state
    }

    #[test]
    fn sticks_and_triggers_steer() {
        let Steering { ahead, right, up, hurries } = moved(&[(Axis::LeftStickY, 1.0)]).steering();
        assert!((ahead - 1.0).abs() < 1e-4 && right.abs() < 1e-4 && up == 0.0 && !hurries);
        assert_eq!(pulled(&[(Button::RightTrigger2, 1.0)]).steering().up, 1.0);
        let both = pulled(&[(Button::LeftTrigger2, 1.0), (Button::RightTrigger2, 1.0)]);
        assert_eq!(both.steering().up, 0.0);
        let [right, down] = moved(&[(Axis::RightStickX, 1.0)]).turn(0.5);
        assert!((right - TURN_PIXELS_A_SECOND / 2.0).abs() < 1.0 && down.abs() < 1.0);
        let [_, down] = moved(&[(Axis::RightStickY, 1.0)]).turn(0.5);
        assert!((down + TURN_PIXELS_A_SECOND / 2.0).abs() < 1.0, "a stick goes up, a mouse down");
    }

    #[test]
    fn what_rests_near_the_middle_does_nothing() {
        let resting = moved(&[(Axis::LeftStickX, 0.1), (Axis::LeftStickY, -0.08)]);
        assert_eq!(resting.steering(), Steering::default());
        assert_eq!(moved(&[(Axis::RightStickX, -0.12)]).turn(1.0), [0.0, 0.0]);
        assert_eq!(pulled(&[(Button::LeftTrigger2, 0.08)]).steering().up, 0.0);
    }

    #[test]
    fn the_way_out_is_slow_at_first_and_whole_at_the_end() {
        let speed = |share: f32| moved(&[(Axis::LeftStickX, share)]).steering().right;
        let [slow, middle, whole] = [0.3, 0.6, 1.0].map(speed);
        assert!(0.0 < slow && slow < 0.1 && slow < middle && middle < 0.5, "{slow} {middle}");
        assert!((whole - 1.0).abs() < 1e-3);
    }

    #[test]
    fn buttons_do_actions() {
        assert_eq!(action_of(Button::South), Some(Action::NextStrategy));
        assert_eq!(action_of(Button::West), Some(Action::Freeze));
        assert_eq!(action_of(Button::North), Some(Action::Compare));
        assert_eq!(action_of(Button::Unknown), None);
    }

    proptest! {
        #[test]
        fn whatever_a_device_says_stays_in_range(values in prop::array::uniform4(any::<f32>())) {
            let [x, y, turn, trigger] = values;
            let mut state = moved(&[
                (Axis::LeftStickX, x),
                (Axis::LeftStickY, y),
                (Axis::RightStickX, turn),
            ]);
            state.pull(Button::LeftTrigger2, trigger);
            let steering = state.steering();
            let way = [steering.ahead, steering.right, steering.up];
            prop_assert!(way.iter().all(|part| (-1.0..=1.0).contains(part)), "{steering:?}");
            let most = TURN_PIXELS_A_SECOND * 1.001;
            prop_assert!(state.turn(1.0).iter().all(|part| part.abs() <= most));
        }
    }
}
