//! Scenes made from a number of objects and a seed, and the camera's routes through them.
//!
//! [`city`] and [`field`] make them. Objects of a generated scene neither touch nor have coplanar
//! faces, and objects on the ground hover 2 cm over it. So each pixel's colour does not depend on
//! the order in which objects are drawn. Only the ground's tiles share edges, with bit-identical
//! vertices. Transforms are quarter turns about y (exact: each column one of the axes) and uniform
//! scales only.
//!
//! ```
//! use scenes::{CameraPath, PathKind};
//!
//! let city = scenes::city(1_000, 7)?;
//! let path = CameraPath::new(PathKind::Street, &city.routes)?;
//! assert_eq!(city.scene.objects.len(), 1_000);
//! assert!(path.camera(30).eye.y > 1.0);
//! # Ok::<(), scenes::GeneratorError>(())
//! ```
#![forbid(unsafe_code)]

mod builder;
mod city;
mod field;
mod motion;
mod path;
mod random;
#[cfg(test)]
mod tests;

use glam::{Affine3A, Mat3A, Vec3, Vec3A, vec3a};
use scene::{Object, Scene, SceneError};

pub use city::city;
pub use field::field;
pub use motion::{Cast, Motion, MotionError};
pub use path::{CameraPath, EYE_HEIGHT_M, PathKind};

/// The most objects that a generated scene can have.
pub const MAX_OBJECTS: u32 = 2_000_000;

/// The distance that a thing hovers over the surface that carries it, in metres.
const HOVER_M: f32 = 0.02;

/// The reasons why a scene, a path or a motion cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeneratorError {
    /// Zero objects, or more than a generated scene can hold.
    #[error("a scene has 1 to {MAX_OBJECTS} objects, not {asked}: choose a number in that range")]
    ObjectCount {
        /// The number that was asked for.
        asked: u32,
    },
    /// Too little memory for the objects.
    #[error("there is no memory for a scene of {count} objects: use fewer, or end other programs")]
    NoMemory {
        /// The number of objects.
        count: u32,
    },
    /// A motion that cannot be made.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// A name that no camera path has.
    #[error("there is no camera path named \"{name}\": choose street, fly or cut")]
    UnknownPath {
        /// The name that was asked for.
        name: String,
    },
    /// A walk in a scene that has no streets.
    #[error("the scene has no streets to walk along: choose the path fly")]
    NoStreets,
    /// A scene that cannot be drawn, which has no motion.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// A scene, and the facts about it that are known from its generation.
#[derive(Clone, Debug, PartialEq)]
pub struct GeneratedScene {
    /// The objects to draw.
    pub scene: Scene,
    /// The routes for walks and flights.
    pub routes: Routes,
}

/// The routes for walks and flights.
#[derive(Clone, Debug, PartialEq)]
pub struct Routes {
    /// The seed of the scene and of its walks; the same seed and number of objects give the same
    /// bytes.
    pub seed: u64,
    /// The lines to walk on; empty where one cannot walk.
    pub streets: Streets,
    /// The round trip to fly.
    pub flight: Flight,
}

/// Lines to walk on: straight, parallel to x and z, all of them crossing. At least 0.3 m around
/// every line, and around every turn with the given radius, there is no object's box at eye level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Streets {
    /// The x of the lines that run along z, in metres, ascending.
    pub xs: Vec<f32>,
    /// The z of the lines that run along x, in metres, ascending.
    pub zs: Vec<f32>,
    /// The radius of turns from line to line, in metres.
    pub turn_radius_m: f32,
}

/// A round trip over the roofs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// The middle of the circle, at the height of the eye, in metres.
    pub centre: Vec3,
    /// Its radius in metres.
    pub radius_m: f32,
    /// The angle by which the view looks down, in radians.
    pub down_rad: f32,
}

/// Returns an empty list with room for so many objects.
fn room_for_objects(asked: u32) -> Result<Vec<Object>, GeneratorError> {
    if !(1..=MAX_OBJECTS).contains(&asked) {
        return Err(GeneratorError::ObjectCount { asked });
    }
    let mut objects = Vec::new();
    let reserved = objects.try_reserve_exact(asked as usize);
    reserved.map(|()| objects).map_err(|_| GeneratorError::NoMemory { count: asked })
}

/// Returns a transform that turns +z to side `side` (0: +z, 1: +x, 2: -z, 3: -x), scales, and
/// moves. Exact: the matrix holds zeros and the scale only.
fn placement(side: usize, scale: f32, position: Vec3) -> Affine3A {
    let (x, z) = match side % 4 {
        0 => (Vec3A::X, Vec3A::Z),
        1 => (Vec3A::NEG_Z, Vec3A::X),
        2 => (Vec3A::NEG_X, Vec3A::NEG_Z),
        _ => (Vec3A::Z, Vec3A::NEG_X),
    };
    Affine3A {
        matrix3: Mat3A::from_cols(x * scale, vec3a(0.0, scale, 0.0), z * scale),
        translation: position.into(),
    }
}

/// Returns the part of `total` that the `index`-th of `count` gets when it is dealt out evenly.
fn share(total: u32, index: u32, count: u32) -> u32 {
    let up_to = |index: u64| u64::from(total) * index / u64::from(count.max(1));
    (up_to(u64::from(index) + 1) - up_to(u64::from(index))) as u32
}
