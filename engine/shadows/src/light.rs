//! Lights with shadows, reduced to the values on which their maps depend.

use std::f32::consts::FRAC_PI_2;

use cull::{Aabb, MAX_COORDINATE, trigonometry};
use glam::{Vec3, Vec4, vec3};

/// The number of a light, chosen by the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ShadowLightId(pub u32);

/// A light that casts shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowLight {
    /// The light's number.
    pub id: ShadowLightId,
    /// The place and directions of its rays.
    pub shape: LightShape,
    /// The width of its penumbras in metres, at least 0: filters reach as far.
    pub penumbra_m: f32,
}

/// The place and directions of a light's rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// Parallel rays.
    Sun {
        /// Unit vector towards the sun.
        towards: Vec3,
    },
    /// Rays from a point in a cone.
    Spot {
        /// The point.
        position: Vec3,
        /// Unit vector along the middle of the cone.
        direction: Vec3,
        /// Half the angle of the cone in radians.
        outer_rad: f32,
        /// The distance beyond which its shadows do not matter, in metres.
        reach_m: f32,
    },
    /// Rays from a point in all directions.
    Point {
        /// The point.
        position: Vec3,
        /// The distance beyond which its shadows do not matter, in metres.
        reach_m: f32,
    },
}

/// The half angle of a cone, in radians, above which a spot light has six maps like a point light:
/// a single flat map would consist mostly of border.
pub const WIDEST_CONE_RAD: f32 = 1.1;

/// The margin around a spot's cone per distance, against rounding on the CPU and in shaders.
pub(crate) const CONE_MARGIN: f32 = 1.0e-3;

/// The number of steps in which the box around a spot's lit region is made smaller.
const CONE_STEPS: usize = 4;

impl LightShape {
    /// Returns the sphere in which a local light's shadows matter: centre and radius in metres.
    #[must_use]
    pub fn reach(&self) -> Option<(Vec3, f32)> {
        match *self {
            Self::Sun { .. } => None,
            Self::Spot { position, reach_m, .. } | Self::Point { position, reach_m } => {
                Some((position, reach_m))
            }
        }
    }

    /// Returns a box around the part of `receivers` that the light reaches; it is empty if there is
    /// none.
    #[must_use]
    pub fn reached(&self, receivers: &Aabb) -> Aabb {
        let Some((position, reach_m)) = self.reach() else { return *receivers };
        let both = |reached: Aabb, others: &Aabb| {
            let reached = reached.enlarged(CONE_MARGIN * reach_m);
            Aabb::new(reached.min.max(others.min), reached.max.min(others.max))
        };
        let mut lit = both(Aabb::new(position, position).enlarged(reach_m), receivers);
        // Rays of a wider cone may never reach the plane at which the cone ends.
        if let Self::Spot { direction, outer_rad, .. } = *self
            && outer_rad < FRAC_PI_2
        {
            let along_m = |corner: Vec3| direction.dot(corner - position);
            // Rays end at the box, so a smaller box shortens them, which makes the box smaller
            // again.
            for _ in 0..CONE_STEPS {
                let last_m = lit.corners().map(along_m).into_iter().fold(0.0, f32::max);
                let slant_m = last_m / trigonometry::cos(outer_rad).max(f32::MIN_POSITIVE);
                let cone = cone_box(position, direction, outer_rad, reach_m.min(slant_m));
                lit = both(cone, &lit);
            }
        }
        lit
    }

    /// Returns the light in homogeneous coordinates: a point with w = 1, or the direction towards
    /// it with w = 0.
    #[must_use]
    pub fn homogeneous(&self) -> Vec4 {
        match *self {
            Self::Sun { towards } => towards.extend(0.0),
            Self::Spot { position, .. } | Self::Point { position, .. } => position.extend(1.0),
        }
    }

    /// Returns true if all its numbers are finite and the light reaches anything.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        match *self {
            Self::Sun { towards } => towards.is_normalized(),
            Self::Spot { position, direction, outer_rad, reach_m } => {
                is_reach(position, reach_m) && direction.is_normalized() && outer_rad > 0.0
            }
            Self::Point { position, reach_m } => is_reach(position, reach_m),
        }
    }
}

/// Returns the box around the rays of a cone up to their reach.
fn cone_box(position: Vec3, direction: Vec3, outer_rad: f32, reach_m: f32) -> Aabb {
    // The cosine of the least angle of a ray to an axis.
    let farthest = |axis: Vec3| {
        let off_rad = trigonometry::acos(direction.dot(axis).clamp(-1.0, 1.0)) - outer_rad;
        trigonometry::cos(off_rad.max(0.0)).max(0.0)
    };
    let high = vec3(farthest(Vec3::X), farthest(Vec3::Y), farthest(Vec3::Z));
    let low = vec3(farthest(Vec3::NEG_X), farthest(Vec3::NEG_Y), farthest(Vec3::NEG_Z));
    Aabb::new(position - reach_m * low, position + reach_m * high)
}

fn is_reach(position: Vec3, reach_m: f32) -> bool {
    position.abs().max_element() <= MAX_COORDINATE && reach_m > 0.0 && reach_m < 1.0e7
}
