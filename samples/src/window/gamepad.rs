//! A gamepad: sticks and triggers steer, buttons trigger actions.
//!
//! [`PadState`] turns the device's numbers into steering, and [`action_of`] maps buttons to
//! actions; both are pure. A thread reads the devices below `/dev/input` on Linux. If there is no
//! gamepad, or no permission to read it, the thread tries again periodically.

use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::thread;
use std::time::Duration;

use evdev::{AbsoluteAxisCode, Device, EventSummary, KeyCode};

use super::actions::Action;
use super::fly_camera::Steering;

/// The share of a stick's range within which it counts as released.
const DEAD_ZONE: f32 = 0.15;
/// The rate at which a fully deflected stick turns the camera, in mouse pixels per second.
const TURN_PIXELS_A_SECOND: f64 = 700.0;
/// The interval at which a missing gamepad is searched.
const LOOK_INTERVAL: Duration = Duration::from_secs(3);

/// An axis of a gamepad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StickAxis {
    /// The left stick to the right.
    LeftX,
    /// The left stick towards the user.
    LeftY,
    /// The right stick to the right.
    RightX,
    /// The right stick towards the user.
    RightY,
    /// The left trigger.
    LeftTrigger,
    /// The right trigger.
    RightTrigger,
}

/// The positions of sticks and triggers: sticks from -1 to 1, triggers from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PadState {
    left: [f32; 2],
    right: [f32; 2],
    triggers: [f32; 2],
}

impl PadState {
    /// Sets an axis with the range from `least` to `most` to a value of the device.
    pub fn set(&mut self, axis: StickAxis, value: i32, least: i32, most: i32) {
        let span = (f64::from(most) - f64::from(least)).max(1.0);
        let share = ((f64::from(value) - f64::from(least)) / span).clamp(0.0, 1.0) as f32;
        let both_ways = share * 2.0 - 1.0;
        match axis {
            StickAxis::LeftX => self.left[0] = both_ways,
            StickAxis::LeftY => self.left[1] = both_ways,
            StickAxis::RightX => self.right[0] = both_ways,
            StickAxis::RightY => self.right[1] = both_ways,
            StickAxis::LeftTrigger => self.triggers[0] = share,
            StickAxis::RightTrigger => self.triggers[1] = share,
        }
    }

    /// Returns the steering: the left stick moves, the triggers move down and up.
    pub fn steering(&self) -> Steering {
        let [right, back] = shaped(self.left);
        let [down, up] = self.triggers.map(|trigger| shaped([trigger, 0.0])[0]);
        Steering { ahead: -back, right, up: up - down, hurries: false }
    }

    /// Returns the camera turn of the right stick in `seconds`, in mouse pixels to the right and
    /// down.
    pub fn turn(&self, seconds: f32) -> [f64; 2] {
        shaped(self.right).map(|part| f64::from(part) * TURN_PIXELS_A_SECOND * f64::from(seconds))
    }
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
pub fn action_of(button: KeyCode) -> Option<Action> {
    match button {
        KeyCode::BTN_SOUTH => Some(Action::NextStrategy),
        KeyCode::BTN_WEST => Some(Action::Freeze),
        KeyCode::BTN_NORTH => Some(Action::Compare),
        KeyCode::BTN_EAST => Some(Action::TopDown),
        KeyCode::BTN_THUMBR => Some(Action::Identify(None)),
        KeyCode::BTN_START => Some(Action::Help),
        _ => None,
    }
}

/// A thread that reads the first gamepad.
pub struct Gamepad {
    state: Arc<Mutex<PadState>>,
    actions: mpsc::Receiver<Action>,
}

impl Gamepad {
    /// Starts to search a gamepad; `None` if the system cannot start a thread.
    pub fn watch() -> Option<Self> {
        let state = Arc::new(Mutex::new(PadState::default()));
        let (sender, actions) = mpsc::channel();
        let theirs = Arc::clone(&state);
        // The thread ends with the program, or when the receiver of its actions is dropped.
        let thread = thread::Builder::new().name("gamepad".to_owned());
        thread.spawn(move || look_and_read(&theirs, &sender)).ok()?;
        Some(Self { state, actions })
    }

    /// Returns the positions of sticks and triggers.
    pub fn state(&self) -> PadState {
        *self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the next action of a pressed button.
    pub fn next_action(&self) -> Option<Action> {
        self.actions.try_recv().ok()
    }
}

fn look_and_read(state: &Mutex<PadState>, actions: &mpsc::Sender<Action>) {
    loop {
        let is_pad = |device: &Device| {
            device.supported_keys().is_some_and(|keys| keys.contains(KeyCode::BTN_SOUTH))
        };
        if let Some((_, mut device)) = evdev::enumerate().find(|(_, device)| is_pad(device)) {
            tracing::info!("gamepad {}", device.name().unwrap_or("without a name"));
            let is_wanted = read(&mut device, state, actions);
            *state.lock().unwrap_or_else(PoisonError::into_inner) = PadState::default();
            if !is_wanted {
                return;
            }
        }
        thread::sleep(LOOK_INTERVAL);
    }
}

/// Reads a device until it disappears; returns false if the receiver was dropped.
fn read(device: &mut Device, state: &Mutex<PadState>, actions: &mpsc::Sender<Action>) -> bool {
    let Ok(ranges) = device.get_absinfo() else { return true };
    let ranges: Vec<_> =
        ranges.map(|(axis, range)| (axis, [range.minimum(), range.maximum()])).collect();
    while let Ok(events) = device.fetch_events() {
        for event in events {
            match event.destructure() {
                EventSummary::Key(_, button, 1) => {
                    if let Some(action) = action_of(button)
                        && actions.send(action).is_err()
                    {
                        return false;
                    }
                }
                EventSummary::AbsoluteAxis(_, code, value) => {
                    let range = ranges.iter().find(|(axis, _)| *axis == code);
                    if let (Some(axis), Some((_, range))) = (axis_of(code), range) {
                        let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
                        state.set(axis, value, range[0], range[1]);
                    }
                }
                _ => {}
            }
        }
    }
    true
}

/// Returns the axis of a kernel code (Documentation/input/gamepad.rst).
fn axis_of(code: AbsoluteAxisCode) -> Option<StickAxis> {
    match code {
        AbsoluteAxisCode::ABS_X => Some(StickAxis::LeftX),
        AbsoluteAxisCode::ABS_Y => Some(StickAxis::LeftY),
        AbsoluteAxisCode::ABS_RX => Some(StickAxis::RightX),
        AbsoluteAxisCode::ABS_RY => Some(StickAxis::RightY),
        AbsoluteAxisCode::ABS_Z => Some(StickAxis::LeftTrigger),
        AbsoluteAxisCode::ABS_RZ => Some(StickAxis::RightTrigger),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const STICK: [i32; 2] = [-32768, 32767];

    fn pad(axes: &[(StickAxis, i32, [i32; 2])]) -> PadState {
        let mut state = PadState::default();
        for (axis, value, [least, most]) in axes {
            state.set(*axis, *value, *least, *most);
        }
        state
    }

    #[test]
    fn sticks_and_triggers_steer() {
        let ahead =
            pad(&[(StickAxis::LeftY, -32768, STICK), (StickAxis::RightTrigger, 255, [0, 255])]);
        let Steering { ahead, right, up, hurries } = ahead.steering();
        assert!((ahead - 1.0).abs() < 1e-4 && right.abs() < 1e-4 && up == 1.0 && !hurries);
        // Both triggers affect each other; 0 to 1023 is a valid range, too.
        let both =
            [(StickAxis::LeftTrigger, 1023, [0, 1023]), (StickAxis::RightTrigger, 255, [0, 255])];
        assert_eq!(pad(&both).steering().up, 0.0);
        let [right, down] = pad(&[(StickAxis::RightX, 32767, STICK)]).turn(0.5);
        assert!((right - TURN_PIXELS_A_SECOND / 2.0).abs() < 1.0 && down.abs() < 1.0);
    }

    #[test]
    fn what_rests_near_the_middle_does_nothing() {
        let resting = [(StickAxis::LeftX, 3000, STICK), (StickAxis::LeftY, -2500, STICK)];
        assert_eq!(pad(&resting).steering(), Steering::default());
        assert_eq!(pad(&[(StickAxis::RightX, -4000, STICK)]).turn(1.0), [0.0, 0.0]);
        assert_eq!(pad(&[(StickAxis::LeftTrigger, 20, [0, 255])]).steering().up, 0.0);
    }

    #[test]
    fn the_way_out_is_slow_at_first_and_whole_at_the_end() {
        let speed = |share: f32| {
            pad(&[(StickAxis::LeftX, (share * 32767.0) as i32, STICK)]).steering().right
        };
        let [slow, middle, whole] = [0.3, 0.6, 1.0].map(speed);
        assert!(0.0 < slow && slow < 0.1 && slow < middle && middle < 0.5, "{slow} {middle}");
        assert!((whole - 1.0).abs() < 1e-3);
    }

    #[test]
    fn buttons_do_actions() {
        assert_eq!(action_of(KeyCode::BTN_SOUTH), Some(Action::NextStrategy));
        assert_eq!(action_of(KeyCode::BTN_WEST), Some(Action::Freeze));
        assert_eq!(action_of(KeyCode::BTN_NORTH), Some(Action::Compare));
        assert_eq!(action_of(KeyCode::KEY_A), None);
    }

    proptest! {
        #[test]
        fn whatever_a_device_says_stays_in_range(
            values in prop::array::uniform4(any::<i32>()), ends in prop::array::uniform2(any::<i32>())
        ) {
            let axes = [StickAxis::LeftX, StickAxis::LeftY, StickAxis::RightX, StickAxis::LeftTrigger];
            let axes: Vec<_> = axes.into_iter().zip(values).map(|(a, v)| (a, v, ends)).collect();
            let state = pad(&axes);
            let steering = state.steering();
            let way = [steering.ahead, steering.right, steering.up];
            prop_assert!(way.iter().all(|part| (-1.0..=1.0).contains(part)), "{steering:?}");
            let most = TURN_PIXELS_A_SECOND * 1.001;
            prop_assert!(state.turn(1.0).iter().all(|part| part.abs() <= most));
        }
    }
}
