//! The scenes of the self-test: small boxes that do not overlap in the image, and a street to walk
//! through.

use cull::{Camera, Projection};
use glam::{Affine3A, Quat, Vec3, vec3};
use scene::{Light, Mesh, MeshId, Object, Scene, pack_unorm};

/// The size of the image of the boxes.
pub(super) const SIZE: [u32; 2] = [320, 240];

/// The side of an object's cell in the image, in pixels.
pub(super) const CELL: u32 = 20;

/// The numbers of columns and rows of cells.
pub(super) const CELLS: [u32; 2] = [SIZE[0] / CELL, SIZE[1] / CELL];

/// The number of objects, each in a cell of its own.
pub(super) const PROBES: usize = (CELLS[0] * CELLS[1]) as usize;

/// The number of twins, which follow the objects. Twin `n` is at the place of object `n`, in
/// another colour.
pub(super) const TWINS: usize = 24;

const FOV_Y_RAD: f32 = 1.0;

/// A sequence of pseudorandom numbers that is the same on every machine.
struct Numbers(u64);

impl Numbers {
    /// Returns the next number in `low..high`.
    fn next(&mut self, low: f32, high: f32) -> f32 {
        // Knuth's constants for linear congruences.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        let share = (self.0 >> 40) as f32 / (1 << 24) as f32;
        low + (high - low) * share
    }

    /// Returns a random rotation.
    fn turn(&mut self) -> Quat {
        let axis = vec3(self.next(-1.0, 1.0), self.next(-1.0, 1.0), self.next(-1.0, 1.0));
        Quat::from_axis_angle(axis.normalize_or(Vec3::Y), self.next(0.0, 6.0))
    }
}

/// Returns the camera that sees each box in its cell.
pub(super) fn camera() -> Camera {
    let projection = Projection::perspective(FOV_Y_RAD);
    Camera { eye: Vec3::ZERO, forward: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.1 }
}

/// Returns boxes and slivers of up to a few pixels, at any sub-pixel position, near and far.
pub(super) fn probes() -> Scene {
    let mut numbers = Numbers(7);
    let mut transforms: Vec<Affine3A> =
        (0..PROBES as u32).map(|cell| transform_in(cell, &mut numbers)).collect();
    transforms.extend_from_within(..TWINS);
    let tint =
        |place: usize| if place < PROBES { [1.0, 0.5, 0.1, 1.0] } else { [0.2, 1.0, 0.3, 1.0] };
    let object =
        |(place, transform)| Object { mesh: MeshId(0), transform, tint: pack_unorm(tint(place)) };
    scene_of(transforms.into_iter().enumerate().map(object).collect())
}

/// Returns the place of a box in its cell.
fn transform_in(cell: u32, numbers: &mut Numbers) -> Affine3A {
    let centre = [cell % CELLS[0], cell / CELLS[0]].map(|at| (at * CELL + CELL / 2) as f32);
    let [x, y] = centre.map(|centre| centre + numbers.next(-1.0, 1.0));
    let distance = numbers.next(0.0, 2.5).exp() * 3.0;
    let pixel_m = 2.0 * (FOV_Y_RAD * 0.5).tan() * distance / SIZE[1] as f32;
    let middle = [SIZE[0] as f32 * 0.5, SIZE[1] as f32 * 0.5];
    let place = vec3((x - middle[0]) * pixel_m, (middle[1] - y) * pixel_m, -distance);
    let side = numbers.next(0.5, 7.0) * pixel_m;
    let (scale, turn) = match cell % 4 {
        0 => (Vec3::splat(side), Quat::IDENTITY),
        1 => (Vec3::splat(side), numbers.turn()),
        // Seen edge-on, and rotated at random.
        2 => (vec3(side, side * 0.01, side), Quat::IDENTITY),
        _ => (vec3(side, side * 0.01, side), numbers.turn()),
    };
    Affine3A::from_scale_rotation_translation(scale, turn, place)
}

/// The number of frames of the walk.
pub(super) const WALK_FRAMES: u32 = 8;

/// Returns houses on both sides of a street, with objects between them.
pub(super) fn street() -> Scene {
    let mut numbers = Numbers(11);
    let mut transforms = Vec::new();
    for house in 0..240 {
        let row = house / 12;
        let place = house % 12;
        let across = if place < 6 { place as f32 - 7.0 } else { place as f32 - 4.0 };
        let size = vec3(numbers.next(3.0, 5.5), numbers.next(2.0, 9.0), numbers.next(3.0, 5.5));
        let at = vec3(across * 6.0, size.y * 0.5, row as f32 * -6.0);
        let turn = Quat::from_rotation_y(numbers.next(-0.1, 0.1));
        transforms.push(Affine3A::from_scale_rotation_translation(size, turn, at));
    }
    for _ in 0..160 {
        let at = vec3(numbers.next(-50.0, 50.0), numbers.next(0.2, 2.0), numbers.next(-120.0, 0.0));
        let size = Vec3::splat(numbers.next(0.1, 0.8));
        let turn = numbers.turn();
        transforms.push(Affine3A::from_scale_rotation_translation(size, turn, at));
    }
    let mut tint = || pack_unorm([numbers.next(0.1, 1.0), numbers.next(0.1, 1.0), 0.4, 1.0]);
    let object = |transform| Object { mesh: MeshId(0), transform, tint: tint() };
    scene_of(transforms.into_iter().map(object).collect())
}

/// Returns the camera of a frame of the walk: along the street, with a cut in the middle.
pub(super) fn walk_camera(frame: u32) -> Camera {
    let cut = if frame < WALK_FRAMES / 2 { 0.0 } else { 40.0 };
    let eye = vec3(0.5, 1.7, 8.0 - frame as f32 * 1.1 - cut);
    let forward = vec3(0.3 - frame as f32 * 0.08, -0.02, -1.0).normalize_or(Vec3::NEG_Z);
    Camera { eye, forward, ..camera() }
}

fn scene_of(objects: Vec<Object>) -> Scene {
    Scene {
        name: "self-test".to_owned(),
        meshes: vec![cube()],
        objects,
        light: Light::afternoon(),
        surfaces: None,
    }
}

/// Returns a cube of side 1 around the origin, with the colour of its object.
fn cube() -> Mesh {
    let mut corners = Vec::new();
    for axis in 0..3 {
        for sign in [-0.5_f32, 0.5] {
            let corner = |across: f32, up: f32| {
                let mut at = [0.0; 3];
                at[axis] = sign;
                at[(axis + 1) % 3] = across * sign.signum();
                at[(axis + 2) % 3] = up;
                (at, [1.0; 3])
            };
            let a = corner(-0.5, -0.5);
            let b = corner(0.5, -0.5);
            let c = corner(0.5, 0.5);
            let d = corner(-0.5, 0.5);
            corners.extend([a, b, c, a, c, d]);
        }
    }
    let mut mesh = Mesh::of_triangles("cube", &corners);
    for vertex in &mut mesh.vertices {
        vertex.colour = pack_unorm([1.0; 4]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::signed_volume;

    #[test]
    fn the_scenes_are_sound_and_their_cube_is_closed() {
        for scene in [probes(), street()] {
            scene.validate().unwrap();
        }
        let cube = cube();
        let at = |index: &u32| Vec3::from_array(cube.vertices[*index as usize].position);
        let triangles =
            cube.indices.chunks(3).map(|index| [at(&index[0]), at(&index[1]), at(&index[2])]);
        assert!(signed_volume(&cube.bounds, triangles) > 0.9);
    }

    #[test]
    fn boxes_stay_in_their_cells() {
        let scene = probes();
        let pixel = 2.0 * (FOV_Y_RAD * 0.5).tan() / SIZE[1] as f32;
        for (cell, object) in (0..PROBES as u32).zip(&scene.objects) {
            for corner in scene.bounds_of(object).unwrap().corners() {
                let x = corner.x / (-corner.z * pixel) + SIZE[0] as f32 * 0.5;
                let y = SIZE[1] as f32 * 0.5 - corner.y / (-corner.z * pixel);
                let [left, top] = [cell % CELLS[0], cell / CELLS[0]].map(|at| (at * CELL) as f32);
                let is_in = |at: f32, low: f32| (low..low + CELL as f32).contains(&at);
                assert!(is_in(x, left) && is_in(y, top), "{cell}: {x} {y}");
            }
        }
    }
}
