//! A camera that flies as it is steered: the path does not depend on the number of frames.

use antumbra::cull::{Camera, Projection};
use antumbra::glam::Vec3;

/// The factor of the speed when hurrying.
const HURRY: f32 = 6.0;
/// The factor of the speed per notch of the wheel, and the limit of the total factor.
const NOTCH: f32 = 1.25;
const MOST_TIMES: f32 = 1e3;
/// The angle in radians per pixel of mouse movement.
const TURN_RAD: f32 = 0.003;
/// The steepest view: straight up or down would leave no side to turn to.
const STEEPEST_RAD: f32 = 1.55;
/// The longest time step: after a pause the camera does not jump.
const LONGEST_STEP_S: f32 = 0.1;

/// The steering direction: each component from -1 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steering {
    /// Forward, or backward.
    pub ahead: f32,
    /// To the right, or left.
    pub right: f32,
    /// Up, or down.
    pub up: f32,
    /// True if the camera hurries.
    pub hurries: bool,
}

impl Steering {
    /// Returns the sum of both, limited so that two inputs are not faster than one.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let sum = |a: f32, b: f32| (a + b).clamp(-1.0, 1.0);
        Self {
            ahead: sum(self.ahead, other.ahead),
            right: sum(self.right, other.right),
            up: sum(self.up, other.up),
            hurries: self.hurries || other.hurries,
        }
    }
}

/// A camera in flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlyCamera {
    eye: Vec3,
    heading_rad: f32,
    rise_rad: f32,
    projection: Projection,
    near: f32,
    /// The initial speed in metres per second.
    speed_m: f32,
    /// The factor of the speed from the wheel.
    times: f32,
}

impl FlyCamera {
    /// Creates a camera at the place of another one, upright, with a speed in metres per second.
    pub fn new(camera: Camera, speed_m: f32) -> Self {
        let forward = camera.forward.try_normalize().unwrap_or(Vec3::X);
        Self {
            eye: camera.eye,
            heading_rad: forward.z.atan2(forward.x),
            rise_rad: forward.y.clamp(-1.0, 1.0).asin().clamp(-STEEPEST_RAD, STEEPEST_RAD),
            projection: camera.projection,
            near: camera.near,
            speed_m,
            times: 1.0,
        }
    }

    /// Moves to the place of another camera, and keeps the speed factor.
    pub fn go_to(&mut self, camera: Camera) {
        *self = Self { times: self.times, ..Self::new(camera, self.speed_m) };
    }

    /// Changes the speed by this number of notches of a wheel.
    pub fn hasten(&mut self, notches: f32) {
        if notches.is_finite() {
            let times = self.times * NOTCH.powf(notches.clamp(-9.0, 9.0));
            self.times = times.clamp(MOST_TIMES.recip(), MOST_TIMES);
        }
    }

    /// Returns the speed in metres per second, when not hurrying.
    pub fn speed_m(&self) -> f32 {
        self.speed_m * self.times
    }

    /// Returns the camera.
    pub fn camera(&self) -> Camera {
        Camera {
            eye: self.eye,
            forward: self.forward(),
            up: Vec3::Y,
            projection: self.projection,
            near: self.near,
        }
    }

    fn forward(&self) -> Vec3 {
        let (sin, cos) = self.heading_rad.sin_cos();
        let (rise, level) = self.rise_rad.sin_cos();
        Vec3::new(cos * level, rise, sin * level)
    }

    /// Flies for some seconds. Without steering the camera stays.
    pub fn fly(&mut self, steering: &Steering, seconds: f32) {
        let forward = self.forward();
        let right = forward.cross(Vec3::Y).normalize_or_zero();
        let way = forward * steering.ahead + right * steering.right + Vec3::Y * steering.up;
        // Two keys at once are not faster than one.
        let way = way.clamp_length_max(1.0);
        let hurry = if steering.hurries { HURRY } else { 1.0 };
        let seconds = if seconds.is_finite() { seconds.clamp(0.0, LONGEST_STEP_S) } else { 0.0 };
        let eye = self.eye + way * (self.speed_m * self.times * hurry * seconds);
        if eye.is_finite() {
            self.eye = eye;
        }
    }

    /// Turns the view by a movement of the mouse: pixels to the right and down.
    pub fn turn(&mut self, right: f64, down: f64) {
        if !(right.is_finite() && down.is_finite()) {
            return;
        }
        let around = std::f32::consts::TAU;
        // With a narrow field of view, the image moves by the same number of pixels.
        let narrow = match self.projection {
            Projection::Perspective { fov_y } => fov_y.min(1.0),
            Projection::Orthographic { .. } => 1.0,
        };
        let turn_rad = TURN_RAD * narrow;
        self.heading_rad = (self.heading_rad + right as f32 * turn_rad) % around;
        self.rise_rad = (self.rise_rad - down as f32 * turn_rad).clamp(-STEEPEST_RAD, STEEPEST_RAD);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SPEED_M: f32 = 4.0;

    fn level() -> FlyCamera {
        let eye = Vec3::new(1.0, 2.0, 3.0);
        let camera = Camera {
            eye,
            forward: Vec3::X,
            up: Vec3::Y,
            projection: Projection::perspective(1.0),
            near: 0.1,
        };
        FlyCamera::new(camera, SPEED_M)
    }

    #[test]
    fn it_goes_as_far_in_many_frames_as_in_few() {
        let steering = Steering { ahead: 1.0, up: 0.5, ..Steering::default() };
        let fly = |frames: u16| {
            let mut camera = level();
            for _ in 0..frames {
                camera.fly(&steering, 1.0 / f32::from(frames));
            }
            camera.camera().eye
        };
        assert!((fly(10) - fly(240)).length() < 1e-3);
        assert!((fly(60).x - 1.0 - SPEED_M / 1.25_f32.sqrt()).abs() < 1e-3);
    }

    #[test]
    fn it_steers_and_turns_to_the_right_side() {
        let mut camera = level();
        camera.fly(&Steering { right: 1.0, ..Steering::default() }, 0.1);
        assert!(camera.camera().eye.z > 3.0, "looking along x, the right hand is along z");
        camera.turn(100.0, 0.0);
        assert!(camera.camera().forward.z > 0.0);
        camera.turn(0.0, 100.0);
        assert!(camera.camera().forward.y < 0.0);
        let mut hurried = level();
        hurried.fly(&Steering { ahead: -1.0, hurries: true, ..Steering::default() }, 0.1);
        assert!((hurried.camera().eye.x - 1.0 + SPEED_M * HURRY * 0.1).abs() < 1e-4);
    }

    #[test]
    fn it_begins_where_the_other_looks() {
        let camera = level().camera();
        assert_eq!(FlyCamera::new(camera, SPEED_M).camera(), camera);
        let down = Camera { forward: -Vec3::Y, ..camera };
        assert!(FlyCamera::new(down, SPEED_M).camera().forward.y < -0.99);
    }

    #[test]
    fn the_wheel_makes_it_faster_up_to_a_bound() {
        let flown = |notches: &[f32]| {
            let mut camera = level();
            notches.iter().for_each(|notches| camera.hasten(*notches));
            camera.fly(&Steering { ahead: 1.0, ..Steering::default() }, 0.1);
            camera.camera().eye.x - 1.0
        };
        assert!((flown(&[2.0, 1.0]) / flown(&[]) - NOTCH.powi(3)).abs() < 1e-3);
        assert!((flown(&[3.0, -3.0]) - flown(&[f32::NAN])).abs() < 1e-4);
        assert!(flown(&[1e9; 100]) <= SPEED_M * MOST_TIMES * 0.1 + 1.0);
        let mut camera = level();
        camera.hasten(4.0);
        camera.go_to(level().camera());
        assert_eq!(camera.camera(), level().camera());
    }

    proptest! {
        #[test]
        fn whatever_comes_it_looks_somewhere(
            steps in prop::collection::vec((-2.0_f32..2.0, -1e9_f64..1e9, prop::num::f32::ANY), 0..40)
        ) {
            let mut camera = level();
            for (ahead, pixels, seconds) in steps {
                camera.turn(pixels, -pixels);
                camera.fly(&Steering { ahead, right: -ahead, up: ahead, hurries: true }, seconds);
            }
            let camera = camera.camera();
            prop_assert!(camera.eye.is_finite() && (camera.forward.length() - 1.0).abs() < 1e-3);
            prop_assert!(camera.forward.cross(camera.up).length() > 1e-3);
        }
    }
}
