//! Lights with shadows, as far as their maps depend on them.

use glam::{Vec3, Vec4};

/// The number of a light, which its owner chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ShadowLightId(pub u32);

/// A light that casts shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowLight {
    /// Its number.
    pub id: ShadowLightId,
    /// The place and directions of its rays.
    pub shape: LightShape,
    /// The width of its penumbras in metres, at least 0: how far filters reach.
    pub penumbra_m: f32,
}

/// The place and directions of a light's rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// Parallel rays.
    Sun {
        /// Unit vector towards it.
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

/// The half angle of a cone, in radians, from which on a spot light has six maps like a point
/// light: one flat map would be mostly border.
pub const WIDEST_CONE_RAD: f32 = 1.1;

impl LightShape {
    /// Returns the sphere that a local light's shadows matter in: centre and radius in metres.
    #[must_use]
    pub fn reach(&self) -> Option<(Vec3, f32)> {
        match *self {
            Self::Sun { .. } => None,
            Self::Spot { position, reach_m, .. } | Self::Point { position, reach_m } => {
                Some((position, reach_m))
            }
        }
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

    /// Returns true if all its numbers are finite and it reaches anything.
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

fn is_reach(position: Vec3, reach_m: f32) -> bool {
    position.abs().max_element() < 1.0e7 && reach_m > 0.0 && reach_m < 1.0e7
}
