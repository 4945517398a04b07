//! Generated scenes, and the number and placement of their objects.

use glam::{Affine3A, Mat3A, Vec3, Vec3A, vec3a};
use scene::{Object, Scene};

use super::error::{GeneratorError, MAX_OBJECTS};
use super::routes::Routes;

/// The distance between an object and the surface below it, in metres.
pub(crate) const HOVER_M: f32 = 0.02;

/// A scene, and the facts that are known from its generation.
#[derive(Clone, Debug, PartialEq)]
pub struct GeneratedScene {
    /// The objects to draw.
    pub scene: Scene,
    /// The routes for walks and flights.
    pub routes: Routes,
}

/// The most memory that the meshes and the plan of a scene take during generation (bytes).
const SHAPES_BYTES: usize = 16 << 20;

/// Returns an empty list with a capacity of `asked` objects. Checks that there is memory for their
/// meshes, too.
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
/// translates. It is exact: the matrix contains only zeros and the scale.
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

/// Returns the part of `total` for index `index` if `total` is distributed evenly over `count`.
pub(crate) fn share(total: u32, index: u32, count: u32) -> u32 {
    let up_to = |index: u64| u64::from(total) * index / u64::from(count.max(1));
    (up_to(u64::from(index) + 1) - up_to(u64::from(index))) as u32
}
