//! The motion of an object: its transform in a frame, and the space that it sweeps.

use std::f32::consts::TAU;

use cull::Aabb;
use glam::{Affine3A, Quat, Vec3};

use crate::random::Random;

/// A periodic motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Act {
    /// No motion: the object rests.
    Stay,
    /// A slide to a place and back.
    Slide {
        /// The farthest displacement (metres).
        reach: Vec3,
        /// The height by which it is lifted at all times (metres), so that it clears the kerbs.
        lift_m: f32,
        pace: Pace,
    },
    /// A swing from side to side about a vertical axis.
    Turn { centre: Vec3, angle_rad: f32, lift_m: f32, pace: Pace },
    /// A change to a smaller size and back, with a fixed foot.
    Shrink { foot: Vec3, least: f32, pace: Pace },
}

/// The period and the phase of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pace {
    period_frames: f32,
    phase: f32,
}

impl Pace {
    pub(super) fn new(random: &mut Random) -> Self {
        Self { period_frames: random.between(50.0, 300.0), phase: random.unit() }
    }

    /// Returns the phase of a frame in its cycle, as an angle.
    fn angle(self, frame: u32) -> f32 {
        let cycles = f64::from(frame) / f64::from(self.period_frames) + f64::from(self.phase);
        cycles.fract() as f32 * TAU
    }

    /// Returns a value that swings from 0 to 1 and back.
    fn swing(self, frame: u32) -> f32 {
        0.5 - 0.5 * self.angle(frame).cos()
    }
}

impl Act {
    /// Returns the transform in a frame, for an object with the transform `base` in the scene.
    pub(super) fn transform(&self, base: &Affine3A, frame: u32) -> Affine3A {
        match *self {
            Self::Stay => *base,
            Self::Slide { reach, lift_m, pace } => {
                Affine3A::from_translation(reach * pace.swing(frame) + Vec3::Y * lift_m) * *base
            }
            Self::Turn { centre, angle_rad, lift_m, pace } => {
                let turn = Quat::from_rotation_y(angle_rad * pace.angle(frame).sin());
                Affine3A::from_translation(centre + Vec3::Y * lift_m)
                    * Affine3A::from_quat(turn)
                    * Affine3A::from_translation(-centre)
                    * *base
            }
            Self::Shrink { foot, least, pace } => {
                let scale = 1.0 - (1.0 - least) * pace.swing(frame);
                Affine3A::from_translation(foot)
                    * Affine3A::from_scale(Vec3::splat(scale))
                    * Affine3A::from_translation(-foot)
                    * *base
            }
        }
    }

    /// Returns a box that an object with the box `bounds` never leaves.
    pub(super) fn sweep(&self, bounds: &Aabb) -> Aabb {
        let moved = |by: Vec3| Aabb::new(bounds.min + by, bounds.max + by);
        match *self {
            Self::Stay | Self::Shrink { .. } => *bounds,
            Self::Slide { reach, lift_m, .. } => {
                let lift = Vec3::Y * lift_m;
                moved(lift).union(&moved(lift + reach))
            }
            Self::Turn { lift_m, .. } => {
                let half = bounds.half_extent();
                let radius = half.x.hypot(half.z);
                let grown = Vec3::new(radius - half.x, 0.0, radius - half.z);
                let lifted = moved(Vec3::Y * lift_m);
                Aabb::new(lifted.min - grown, lifted.max + grown)
            }
        }
    }
}
