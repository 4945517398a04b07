//! Small scenes from public reports, in which other engines leave out objects that show
//! (`docs/lab/other_engines.md`), each with the cameras that provoke it.

use cull::{Camera, Projection};
use glam::{Affine3A, Quat, Vec2, Vec3, vec3};
use scene::{Light, Mesh, MeshId, Object, Scene, Vertex, bounds_of_vertices, pack_normal};
use scene::{pack_unorm, unpack_normal};

use crate::shapes::{coloured_cubes, cube};
use crate::window_fixture::Random;

/// A scene from a public report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reported {
    /// Two walls with a narrow gap, and what shows through it (Godot 53288).
    Gap,
    /// A wall with an opening at the edge of the image, and a large block behind it (Godot 94210).
    Opening,
    /// A large box, almost off screen, behind another box that covers nearly all of it (Godot
    /// 70516).
    Edge,
    /// Touching tiles of a floor, seen in parallel (Godot 113329).
    Tiles,
    /// The eye in a hollow and in a solid occluder, and on its way into them (Godot 106184).
    Inside,
    /// A box of sky around the camera and a few spheres (Bevy 19544).
    Sky,
}

/// A reported scene with its cameras.
pub struct Provocation {
    /// The scene.
    pub scene: Scene,
    /// The index of the object that other engines leave out.
    pub subject: usize,
    /// A slow walk, in which the subject becomes hidden and visible. A sky always shows.
    pub walk: Vec<Camera>,
    /// 64 eyes in no order, so that the camera jumps.
    pub jumps: Vec<Camera>,
    /// The index of the walk's camera that shows the subject of the report.
    pub portrait: usize,
}

impl Reported {
    /// All reported scenes.
    pub const ALL: [Reported; 6] = [
        Reported::Gap,
        Reported::Opening,
        Reported::Edge,
        Reported::Tiles,
        Reported::Inside,
        Reported::Sky,
    ];

    /// Returns the name of the report in file names.
    pub fn name(self) -> &'static str {
        match self {
            Reported::Gap => "gap",
            Reported::Opening => "opening",
            Reported::Edge => "edge",
            Reported::Tiles => "tiles",
            Reported::Inside => "inside",
            Reported::Sky => "sky",
        }
    }

    /// Builds the scene and its cameras.
    pub fn build(self) -> Provocation {
        match self {
            Reported::Gap => gap(),
            Reported::Opening => opening(),
            Reported::Edge => edge(),
            Reported::Tiles => tiles(),
            Reported::Inside => inside(),
            Reported::Sky => sky(),
        }
    }
}

impl Provocation {
    /// Returns the scene for a reference without any culling. Each mesh gets a triangle without
    /// area whose corners are so far away that its objects are in every frustum.
    pub fn drawn_whole(&self) -> Scene {
        let mut scene = self.scene.clone();
        for mesh in &mut scene.meshes {
            let first = mesh.vertices.len() as u32;
            let far = [[-FAR; 3], [FAR; 3]].map(|position| Vertex { position, ..mesh.vertices[0] });
            mesh.vertices.extend(far);
            mesh.indices.extend([first, first + 1, first + 1]);
            mesh.bounds = bounds_of_vertices(&mesh.vertices);
        }
        for mesh in scene.surfaces.iter_mut().flat_map(|surfaces| &mut surfaces.meshes) {
            mesh.vertices.extend([mesh.vertices[0]; 2]);
        }
        scene
    }
}

/// A distance beyond every camera, in units of the smallest mesh.
const FAR: f32 = 1.0e5;

/// The meshes of [`Blocks`].
const BLOCK: u32 = 0;
const BALL: u32 = 1;
const SHELL: u32 = 2;
const FIRST_OTHER: u32 = 3;

const GREY: [f32; 3] = [0.45, 0.45, 0.5];
const RED: [f32; 3] = [0.8, 0.12, 0.08];
const BLUE: [f32; 3] = [0.2, 0.4, 0.8];

/// The objects of a scene: blocks, balls, and shells, which are boxes with faces towards the inside
/// only.
struct Blocks {
    meshes: Vec<Mesh>,
    objects: Vec<Object>,
}

impl Blocks {
    fn new() -> Self {
        let white = pack_unorm([1.0; 4]);
        let mut shell = cube(white, 1);
        turn_inside_out(&mut shell);
        Self { meshes: vec![cube(white, 3), ball(white), shell], objects: Vec::new() }
    }

    /// Places a mesh so that its unit cube fills a box. Returns the object's index.
    fn place(&mut self, mesh: u32, low: Vec3, high: Vec3, colour: [f32; 3]) -> usize {
        let [r, g, b] = colour;
        let transform = Affine3A::from_scale_rotation_translation(high - low, Quat::IDENTITY, low);
        let tint = pack_unorm([r, g, b, 1.0]);
        self.objects.push(Object { mesh: MeshId(mesh), transform, tint });
        self.objects.len() - 1
    }

    fn ball(&mut self, centre: Vec3, radius: f32, colour: [f32; 3]) -> usize {
        self.place(BALL, centre - radius, centre + radius, colour)
    }

    /// Places balls and blocks in a lattice between two corners, as groups that are tested
    /// together.
    fn crowd(&mut self, low: Vec3, high: Vec3, counts: [u32; 3]) {
        let [columns, rows, layers] = counts;
        let step = (high - low) / vec3(columns as f32, rows as f32, layers as f32);
        for number in 0..columns * rows * layers {
            let place = [number % columns, number / columns % rows, number / columns / rows];
            let centre = low + step * (Vec3::from(place.map(|place| place as f32)) + 0.5);
            let half = Vec3::splat(step.min_element() * 0.25);
            let mesh = if number % 2 == 0 { BALL } else { BLOCK };
            self.place(mesh, centre - half, centre + half, BLUE);
        }
    }

    fn scene(self, name: &str) -> Scene {
        Scene {
            name: name.to_owned(),
            meshes: self.meshes,
            objects: self.objects,
            light: Light::afternoon(),
            surfaces: None,
        }
    }
}

fn turn_inside_out(mesh: &mut Mesh) {
    mesh.indices.chunks_exact_mut(3).for_each(|triangle| triangle.swap(1, 2));
    for vertex in &mut mesh.vertices {
        vertex.normal = pack_normal(-Vec3::from_array(unpack_normal(vertex.normal).to_array()));
    }
}

/// Returns a ball that fills the unit cube.
fn ball(colour: u32) -> Mesh {
    const AROUND: u32 = 16;
    const RINGS: u32 = 8;
    let vertex = |(ring, side): (u32, u32)| {
        let across = std::f32::consts::PI * ring as f32 / RINGS as f32;
        let along = std::f32::consts::TAU * side as f32 / AROUND as f32;
        let normal = vec3(across.sin() * along.cos(), across.cos(), across.sin() * along.sin());
        let position = (normal * 0.5 + 0.5).to_array();
        Vertex { position, normal: pack_normal(normal), colour }
    };
    let places = (0..=RINGS).flat_map(|ring| (0..=AROUND).map(move |side| (ring, side)));
    let vertices: Vec<Vertex> = places.map(vertex).collect();
    let quads = (0..RINGS).flat_map(|ring| (0..AROUND).map(move |side| (ring, side)));
    let indices = quads.flat_map(|(ring, side)| {
        let [a, b] = [0, AROUND + 1].map(|below| ring * (AROUND + 1) + below + side);
        [a, a + 1, b, b, a + 1, b + 1]
    });
    Mesh {
        name: "ball".to_owned(),
        indices: indices.collect(),
        bounds: bounds_of_vertices(&vertices),
        vertices,
        has_backs: false,
    }
}

/// Combines several meshes into one. Each is placed so that its unit cube fills a box.
fn joined(name: &str, parts: &[(&Mesh, Vec3, Vec3)]) -> Mesh {
    let mut vertices = Vec::new();
    let mut indices = Vec::new();
    for (part, low, high) in parts {
        let first = vertices.len() as u32;
        indices.extend(part.indices.iter().map(|index| first + index));
        vertices.extend(part.vertices.iter().map(|vertex| {
            let position = low + Vec3::from_array(vertex.position) * (*high - *low);
            Vertex { position: position.to_array(), ..*vertex }
        }));
    }
    let bounds = bounds_of_vertices(&vertices);
    Mesh { name: name.to_owned(), vertices, indices, bounds, has_backs: false }
}

/// Returns a typical camera of games: 75 degrees, the near plane at 5 cm.
fn camera(eye: Vec3, forward: Vec3) -> Camera {
    Camera { eye, forward, up: Vec3::Y, projection: Projection::perspective(1.309), near: 0.05 }
}

/// Returns the direction that is turned to the left of -z and up by angles in degrees.
fn turned(left_deg: f32, up_deg: f32) -> Vec3 {
    let left = left_deg.to_radians();
    let up = up_deg.to_radians();
    vec3(-left.sin() * up.cos(), up.sin(), -left.cos() * up.cos())
}

/// Returns 64 slightly rolled eyes between two corners, which look roughly towards `target`.
fn jumps(seed: u64, low: Vec3, high: Vec3, target: Vec3) -> Vec<Camera> {
    let mut random = Random::new(seed);
    let mut part = || random.below(1 << 20) as f32 / (1 << 20) as f32;
    let mut eye = || {
        let eye = low + (high - low) * vec3(part(), part(), part());
        let aside = vec3(part(), part(), part()) - 0.5;
        let up = vec3(part() * 0.6 - 0.3, 1.0, 0.0);
        let forward = (target - eye).normalize_or(Vec3::NEG_Z) + aside * 1.6;
        Camera { up, ..camera(eye, forward) }
    };
    (0..64).map(|_| eye()).collect()
}

/// Returns `count` cameras for evenly spaced parameters from 0 to 1.
fn steps(count: usize, at: impl Fn(f32) -> Camera) -> Vec<Camera> {
    (0..count).map(|step| at(step as f32 / (count - 1) as f32)).collect()
}

/// Builds two walls with a gap of 5 cm, seen from so far that it is 1.2, 0.6 and 0.3 pixels wide in
/// an image of 109 rows.
fn gap() -> Provocation {
    let mut blocks = Blocks::new();
    blocks.place(BLOCK, vec3(-14.0, 0.0, -0.2), vec3(-0.025, 5.0, 0.0), GREY);
    blocks.place(BLOCK, vec3(0.025, 0.0, -0.2), vec3(14.0, 5.0, 0.0), GREY);
    let subject = blocks.place(BLOCK, vec3(-1.0, 0.2, -8.0), vec3(1.0, 3.2, -6.0), RED);
    blocks.crowd(vec3(-12.0, 0.0, -20.0), vec3(12.0, 4.0, -9.0), [8, 2, 4]);
    let mut walk = Vec::new();
    for metres in [3.0, 6.0, 12.0] {
        walk.extend(steps(16, |part| {
            let eye = vec3((part - 0.45) * 0.7 * metres, 1.6, metres);
            camera(eye, vec3(0.0, 1.6, 0.0) - eye)
        }));
    }
    let low = vec3(-3.0, 0.3, 0.5);
    let high = vec3(3.0, 4.0, 15.0);
    let jumps = jumps(53_288, low, high, vec3(0.0, 1.7, 0.0));
    Provocation { scene: blocks.scene("gap"), subject, walk, jumps, portrait: 6 }
}

/// Builds a wall with an opening of 1 m by 2 m that crosses an edge and a corner of the image.
fn opening() -> Provocation {
    let mut blocks = Blocks::new();
    let part = |low: Vec2, high: Vec2| (low.extend(-0.3), high.extend(0.0));
    let sides = [
        part(Vec2::new(-15.0, 0.0), Vec2::new(-0.5, 10.0)),
        part(Vec2::new(0.5, 0.0), Vec2::new(15.0, 10.0)),
        part(Vec2::new(-0.5, 0.0), Vec2::new(0.5, 1.0)),
        part(Vec2::new(-0.5, 3.0), Vec2::new(0.5, 10.0)),
    ];
    let wall = joined("wall", &sides.map(|(low, high)| (&blocks.meshes[0], low, high)));
    blocks.meshes.push(wall);
    blocks.place(FIRST_OTHER, Vec3::ZERO, Vec3::ONE, GREY);
    let subject = blocks.place(BLOCK, vec3(-10.0, 0.0, -26.0), vec3(10.0, 8.0, -6.0), RED);
    blocks.crowd(vec3(-12.0, 0.0, -5.0), vec3(12.0, 6.0, -1.0), [10, 2, 2]);
    let eye = vec3(0.3, 1.8, 3.0);
    // So narrow that the wall fills the image.
    let look = |left_deg, up_deg| Camera {
        projection: Projection::perspective(0.6),
        ..camera(eye, turned(left_deg, up_deg))
    };
    let mut walk = steps(32, |part| look(39.8 - 2.0 * part, 0.0));
    walk.extend(steps(8, |part| look(37.0 - 15.0 * part, 0.0)));
    walk.extend(steps(24, |part| look(34.0 - 4.0 * part, 39.0 - 10.0 * part)));
    let low = vec3(-4.0, 0.5, 0.4);
    let high = vec3(4.0, 5.0, 7.0);
    let jumps = jumps(94_210, low, high, vec3(0.0, 2.0, 0.0));
    Provocation { scene: blocks.scene("opening"), subject, walk, jumps, portrait: 16 }
}

/// Builds two large boxes, one behind the other and 7 m aside; the eye is at a corner of one.
fn edge() -> Provocation {
    let mut blocks = Blocks::new();
    blocks.place(BLOCK, vec3(-40.0, 0.0, -10.0), vec3(0.0, 10.0, 0.0), GREY);
    let subject = blocks.place(BLOCK, vec3(-3.0, 0.0, -21.0), vec3(7.0, 10.0, -11.0), RED);
    blocks.crowd(vec3(-4.0, 0.0, -40.0), vec3(8.0, 8.0, -23.0), [4, 2, 4]);
    let eye = vec3(0.6, 1.7, 0.35);
    let mut walk = steps(40, |part| camera(eye, turned(54.0 - 10.0 * part, 0.0)));
    walk.extend(steps(16, |part| {
        let eye = eye + vec3(-0.7 * part, 0.0, 0.3 * part);
        camera(eye, turned(50.0, 0.0))
    }));
    let low = vec3(-1.5, 0.5, 0.1);
    let high = vec3(1.5, 4.0, 3.0);
    let jumps = jumps(70_516, low, high, vec3(-3.0, 2.0, -4.0));
    Provocation { scene: blocks.scene("edge"), subject, walk, jumps, portrait: 30 }
}

/// Builds two floors of 7 by 7 touching tiles of 3 m, blocks on the upper and below it.
fn tiles() -> Provocation {
    const COLOURS: u32 = 7;
    let mut objects = Vec::new();
    let mut place = |number: u32, low: Vec3, size: Vec3| {
        let transform = Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, low);
        objects.push(Object { mesh: MeshId(number % COLOURS), transform, tint: u32::MAX });
    };
    for y in [0.0, -6.0] {
        for tile in 0..49 {
            let [x, z] = [tile % 7, tile / 7].map(|place| place as f32 * 3.0 - 10.5);
            place(tile + 3 * (tile / 7), vec3(x, y - 0.2, z), vec3(3.0, 0.2, 3.0));
        }
        for number in 0..9 {
            let [x, z] = [number % 3, number / 3].map(|place| place as f32 * 6.0 - 6.5);
            place(number, vec3(x, y, z), vec3(1.0, 1.5, 1.0));
        }
    }
    let subject = 24;
    let parallel = |middle: Vec3, forward: Vec3, height: f32| {
        let projection = Projection::Orthographic { height, far: 200.0 };
        let eye = middle - forward.normalize() * 100.0;
        Camera { eye, forward, up: Vec3::Y, projection, near: 1.0 }
    };
    let mut walk = steps(24, |part| {
        let middle = vec3(24.0 * part - 12.0, 0.0, 8.0 - 8.0 * part);
        parallel(middle, vec3(-0.5, -0.6, -0.6), 4.0 + 20.0 * part)
    });
    walk.extend(steps(24, |part| {
        let turn = part * std::f32::consts::TAU;
        let down = 0.9 - 0.88 * part;
        parallel(Vec3::ZERO, vec3(turn.cos(), -down, turn.sin()), 24.0 - 14.0 * part)
    }));
    let mut random = Random::new(113_329);
    let mut part = || random.below(1 << 20) as f32 / (1 << 20) as f32;
    let mut eye = || {
        let middle = (vec3(part(), part(), part()) - 0.5) * vec3(20.0, 2.0, 20.0);
        let forward = vec3(part() - 0.5, part() - 0.9, part() - 0.5);
        parallel(middle, forward, 3.0 + 30.0 * part())
    };
    let jumps = (0..64).map(|_| eye()).collect();
    Provocation { scene: coloured_cubes(COLOURS, objects), subject, walk, jumps, portrait: 27 }
}

/// Builds a hollow box with two-sided walls, and a solid one; the eye goes through both.
fn inside() -> Provocation {
    let mut blocks = Blocks::new();
    let unit = (Vec3::ZERO, Vec3::ONE);
    let parts = [BLOCK, SHELL].map(|mesh| (&blocks.meshes[mesh as usize], unit.0, unit.1));
    let hollow = Mesh { has_backs: true, ..joined("hollow", &parts) };
    blocks.meshes.push(hollow);
    blocks.place(FIRST_OTHER, vec3(-4.0, 0.0, -4.0), vec3(4.0, 3.0, 4.0), GREY);
    let subject = blocks.ball(vec3(0.0, 0.8, -2.9), 0.5, RED);
    blocks.crowd(vec3(-3.5, 0.1, -3.0), vec3(3.5, 2.8, 3.0), [4, 1, 2]);
    blocks.place(BLOCK, vec3(10.0, 0.0, -2.0), vec3(14.0, 3.0, 2.0), GREY);
    blocks.crowd(vec3(10.5, 0.5, -1.5), vec3(13.5, 2.5, 1.5), [2, 1, 2]);
    blocks.crowd(vec3(-10.0, 0.0, -14.0), vec3(18.0, 4.0, -6.0), [7, 2, 2]);
    blocks.crowd(vec3(-10.0, 0.0, 6.0), vec3(18.0, 4.0, 14.0), [7, 2, 2]);
    let walk = steps(72, |part| {
        camera(vec3(25.0 * part - 8.0, 1.5, 0.4), turned(part * 1080.0 - 90.0, 0.0))
    });
    let low = vec3(-5.0, 0.02, -3.0);
    let high = vec3(15.0, 3.2, 3.0);
    let jumps = jumps(106_184, low, high, vec3(1.0, 1.5, 0.0));
    Provocation { scene: blocks.scene("inside"), subject, walk, jumps, portrait: 32 }
}

/// Builds a box of sky of 500 m, spheres before and behind a large one, and nothing else.
fn sky() -> Provocation {
    let mut blocks = Blocks::new();
    let subject = blocks.place(SHELL, Vec3::splat(-250.0), Vec3::splat(250.0), [0.35, 0.6, 0.9]);
    blocks.ball(vec3(0.0, 2.0, -10.0), 4.0, GREY);
    for number in 0..9 {
        let x = number as f32 * 1.5 - 6.0;
        let z = -17.0 - (number % 3) as f32 * 2.0;
        blocks.ball(vec3(x, 1.0 + (number % 4) as f32, z), 0.5, RED);
    }
    blocks.ball(vec3(3.0, 1.0, 2.0), 0.5, RED);
    let walk = steps(60, |part| {
        let eye = vec3(4.0 * part - 2.0, 2.0, 6.0 - part);
        camera(eye, turned(part * 540.0 - 40.0, 20.0 * (part * 9.0).sin()))
    });
    let low = vec3(-200.0, -50.0, -200.0);
    let high = vec3(200.0, 200.0, 200.0);
    let mut jumps = jumps(19_544, low, high, vec3(0.0, 2.0, -12.0));
    for camera in jumps.iter_mut().step_by(2) {
        camera.eye *= 0.05;
    }
    Provocation { scene: blocks.scene("sky"), subject, walk, jumps, portrait: 4 }
}
