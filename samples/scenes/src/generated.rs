//! Generated scenes, and the counting and placing of their objects.

use glam::{Affine3A, Mat3A, Vec3, Vec3A, vec3a};
use scene::{Object, Scene};

use super::error::{GeneratorError, MAX_OBJECTS};
use super::routes::Routes;

/// The distance of a thing from the surface that carries it, in metres.
pub(crate) const HOVER_M: f32 = 0.02;

/// A scene, and the facts about it that are known from its generation.
#[derive(Clone, Debug, PartialEq)]
pub struct GeneratedScene {
    /// The objects to draw.
    pub scene: Scene,
    /// The routes for walks and flights.
    pub routes: Routes,
}

/// The memory that the meshes of a scene and its plan take, at most, while they are made (bytes).
const SHAPES_BYTES: usize = 16 << 20;

/// Returns an empty list with room for so many objects, if there is memory for their shapes, too.
pub(crate) fn room_for_objects(asked: u32) -> Result<Vec<Object>, GeneratorError> {
    if !(1..=MAX_OBJECTS).contains(&asked) {
        return Err(GeneratorError::ObjectCount { asked });
    }
    let mut objects = Vec::new();
    let shapes = || Vec::<u8>::new().try_reserve_exact(SHAPES_BYTES);
    let reserved = objects.try_reserve_exact(asked as usize).and_then(|()| shapes());
    reserved.map(|()| objects).map_err(|_| GeneratorError::NoMemory { count: asked })
}

/// Returns a transform that turns +z to side `side` (0: +z, 1: +x, 2: -z, 3: -x), scales, and
/// moves. Exact: the matrix holds zeros and the scale only.
pub(crate) fn placement(side: usize, scale: f32, position: Vec3) -> Affine3A {
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
pub(crate) fn share(total: u32, index: u32, count: u32) -> u32 {
    let up_to = |index: u64| u64::from(total) * index / u64::from(count.max(1));
    (up_to(u64::from(index) + 1) - up_to(u64::from(index))) as u32
}
