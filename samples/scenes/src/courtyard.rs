//! The courtyard: a small scene for shadows. Columns and a fence cast thin ones, a figure walks, a
//! lantern flies, two spots stand on the walls, and the sun follows the hour.

use std::f32::consts::{FRAC_PI_2, TAU};

use cull::{Camera, ObjectId, Projection};
use glam::{Affine3A, Quat, Vec2, Vec3, vec2, vec3};
use scene::{
    FOV_Y_RAD, LightId, LightKind, LightMove, Mesh, MeshId, NEAR_M, Object, ObjectChange,
    PunctualLight, Scene, SceneUpdate,
};

use super::builder::{Faces, MeshBuilder, Paint};
use super::generated::HOVER_M;
use super::lights::{Daylight, Hour, LampHours, let_glow};

/// Half the side of the yard, in metres.
const HALF_M: f32 = 16.0;

/// The side of a tile of its ground, in metres.
const TILE_M: f32 = 2.0;

/// The distance from the lantern's middle down to its light, in metres: beyond its own glass, which
/// would cast a shadow.
const BELOW_M: f32 = 0.4;

/// The courtyard, its lights, and its motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Courtyard {
    /// The scene, at the beginning of its motion.
    pub scene: Scene,
    /// Its sun and its lamps.
    pub daylight: Daylight,
    /// The motion of the figure and of the lantern.
    pub motion: YardMotion,
    /// The camera that sees it.
    pub camera: Camera,
}

/// The motion in the courtyard: a figure that walks in a circle, and a lantern with its light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YardMotion {
    figure: ObjectId,
    lantern: ObjectId,
    light: LightId,
    lamp: PunctualLight,
}

impl YardMotion {
    /// Returns the changes that show the courtyard at a time, in seconds.
    #[must_use]
    pub fn at(&self, seconds: f64) -> SceneUpdate {
        // The circle takes 18 seconds, the lantern's way 40.
        let turn = (seconds / 18.0).rem_euclid(1.0) as f32 * TAU;
        let way = (seconds / 40.0).rem_euclid(1.0) as f32 * TAU;
        let (sin, cos) = turn.sin_cos();
        let walking = Affine3A::from_rotation_translation(
            Quat::from_rotation_y(-turn - FRAC_PI_2),
            vec3(6.0 * cos, HOVER_M, 6.0 * sin),
        );
        let place = vec3(7.5 * (3.0 * way).sin(), 3.0 + 0.4 * (5.0 * way).sin(), 5.0 * way.cos());
        let flying = Affine3A::from_translation(place);
        let change = |object, transform| ObjectChange::Move { object, transform };
        let position = place - Vec3::Y * BELOW_M;
        SceneUpdate {
            objects: vec![change(self.figure, walking), change(self.lantern, flying)],
            lights: vec![LightMove {
                light: self.light,
                to: PunctualLight { position, ..self.lamp },
            }],
            ..SceneUpdate::default()
        }
    }
}

/// Makes the courtyard at an hour of the day. Its lamps are always on.
pub fn courtyard(hour: Hour) -> Courtyard {
    let mut meshes = Vec::new();
    let mut objects = Vec::new();
    let mut add = |mesh: Mesh, places: &[Affine3A]| {
        let id = MeshId(meshes.len() as u32);
        meshes.push(mesh);
        objects.extend(places.iter().map(|place| Object {
            mesh: id,
            transform: *place,
            tint: u32::MAX,
        }));
        (id, ObjectId(objects.len() as u32 - 1))
    };
    let at = |x: f32, z: f32| Affine3A::from_translation(vec3(x, HOVER_M, z));
    add(ground(), &[Affine3A::IDENTITY]);
    let side = |number: u8| {
        Affine3A::from_rotation_y(f32::from(number) * FRAC_PI_2) * at(0.0, -HALF_M + 0.5)
    };
    add(wall(), &[side(0), side(1), side(3)]);
    let columns = (0..10_u8).map(|number| {
        let (row, place) = (number % 2, f32::from(number / 2));
        at(if row == 0 { -9.5 } else { 9.5 }, 5.0 * place - 11.0)
    });
    add(column(), &columns.collect::<Vec<_>>());
    add(fence(), &[at(-3.6, -8.0), at(3.6, -8.0)]);
    let turned = |x: f32, z: f32, turn: f32| at(x, z) * Affine3A::from_rotation_y(turn);
    add(crate_box(), &[turned(-2.4, 1.2, 0.4), turned(-0.9, 0.2, 1.1), turned(2.8, -2.0, 0.2)]);
    let (_, figure) = add(figure_mesh(), &[at(6.0, 0.0)]);
    let (lantern_mesh, lantern) = add(lantern_mesh(), &[at(0.0, 5.0)]);
    let light = Hour::NIGHT.light();
    let plain = Scene { name: "courtyard".to_owned(), meshes, objects, light, surfaces: None };
    let mut scene = plain.with_surfaces();
    let_glow(&mut scene, lantern_mesh);
    let lights = [spot(-1.0, [1.0, 0.72, 0.42]), spot(1.0, [0.55, 0.75, 1.0]), lantern_light()];
    if let Some(surfaces) = &mut scene.surfaces {
        surfaces.lights.extend(lights);
    }
    let lamps = (1..).map(LightId).zip(lights).collect::<Vec<_>>();
    let motion = YardMotion { figure, lantern, light: LightId(3), lamp: lantern_light() };
    let daylight = Daylight { hour, lamps, glow: None, lamp_hours: LampHours::Always };
    Courtyard { scene, daylight, motion, camera: camera() }
}

fn camera() -> Camera {
    Camera {
        eye: vec3(4.5, 4.6, 15.0),
        forward: vec3(-0.26, -0.2, -1.0).normalize_or(Vec3::NEG_Z),
        up: Vec3::Y,
        projection: Projection::perspective(FOV_Y_RAD),
        near: NEAR_M,
    }
}

/// Returns a spot light in a corner, which shines on the middle.
fn spot(side: f32, colour: [f32; 3]) -> PunctualLight {
    let position = vec3(side * (HALF_M - 2.5), 6.5, -HALF_M + 3.0);
    PunctualLight {
        kind: LightKind::Spot { inner_rad: 0.3, outer_rad: 0.5 },
        colour,
        intensity: 620.0,
        range_m: Some(36.0),
        position,
        direction: (vec3(side, 0.0, 1.0) - position).normalize_or(Vec3::NEG_Y),
        picture: None,
    }
}

fn lantern_light() -> PunctualLight {
    PunctualLight {
        kind: LightKind::Point,
        colour: [1.0, 0.82, 0.55],
        intensity: 26.0,
        range_m: Some(16.0),
        position: vec3(0.0, 3.0 - BELOW_M, 5.0),
        direction: Vec3::NEG_Y,
        picture: None,
    }
}

/// Returns the ground: a chequered floor.
fn ground() -> Mesh {
    let mut builder = MeshBuilder::default();
    let paints = [0xB9_AE98, 0xA6_9A84].map(Paint::srgb);
    let tiles = (2.0 * HALF_M / TILE_M) as u8;
    for column in 0..tiles {
        for row in 0..tiles {
            let [x, z] = [column, row].map(|tile| f32::from(tile) * TILE_M - HALF_M);
            let corners = [
                vec3(x, 0.0, z + TILE_M),
                vec3(x + TILE_M, 0.0, z + TILE_M),
                vec3(x + TILE_M, 0.0, z),
                vec3(x, 0.0, z),
            ];
            builder.polygon(&corners, paints[usize::from((column + row) % 2)]);
        }
    }
    builder.finish("courtyard ground")
}

fn wall() -> Mesh {
    let mut builder = MeshBuilder::default();
    // Walls end right before each other.
    let (half, high) = (HALF_M - 0.82, 4.2);
    let stone = Paint::srgb(0xC9_B79A);
    builder.cuboid(vec3(-half, 0.0, -0.3), vec3(half, high, 0.3), Faces::Standing, stone);
    let coping = Paint::srgb(0x9A_6A4E);
    let end = half - 0.15;
    let (low, top) = (vec3(-end, high - 0.1, -0.45), vec3(end, high + 0.3, 0.45));
    builder.tapered(low, top, vec2(0.0, 0.3), Faces::All, coping);
    builder.finish("courtyard wall")
}

fn column() -> Mesh {
    let mut builder = MeshBuilder::default();
    let profile = [
        (0.55, 0.0),
        (0.55, 0.25),
        (0.4, 0.4),
        (0.34, 0.5),
        (0.3, 4.6),
        (0.36, 4.7),
        (0.55, 4.95),
        (0.55, 5.2),
        (0.0, 5.2),
    ];
    builder.turned(&Affine3A::IDENTITY, &profile, 24, Paint::srgb(0xE4_DBC8));
    builder.finish("column")
}

/// Returns a fence of pickets between two rails.
fn fence() -> Mesh {
    let mut builder = MeshBuilder::default();
    let wood = Paint::srgb(0x6E_4B33);
    for picket in 0..16_u8 {
        let x = f32::from(picket) * 0.4 - 3.0;
        let (low, high) = (vec3(x - 0.06, 0.0, -0.03), vec3(x + 0.06, 1.5, 0.03));
        builder.tapered(low, high, Vec2::ZERO, Faces::Standing, wood);
    }
    for y in [0.35, 1.1] {
        let (low, high) = (vec3(-3.2, y, 0.032), vec3(3.2, y + 0.12, 0.09));
        builder.cuboid(low, high, Faces::All, wood.shade(0.8));
    }
    builder.finish("fence")
}

fn crate_box() -> Mesh {
    let mut builder = MeshBuilder::default();
    let wood = Paint::srgb(0xA8_7B4A);
    builder.cuboid(vec3(-0.55, 0.0, -0.55), vec3(0.55, 1.1, 0.55), Faces::Standing, wood);
    builder.finish("crate")
}

/// Returns a figure in a long coat, with a hat, that looks along +z.
fn figure_mesh() -> Mesh {
    let mut builder = MeshBuilder::default();
    let coat = Paint::srgb(0x8C_3B36);
    let body = [(0.0, 0.05), (0.38, 0.05), (0.26, 0.9), (0.3, 1.25), (0.12, 1.45), (0.0, 1.5)];
    builder.turned(&Affine3A::IDENTITY, &body, 16, coat);
    let skin = Paint::srgb(0xD9_A27C);
    builder.ellipsoid(vec3(0.0, 1.66, 0.0), vec2(0.14, 0.17), [12, 8], [skin, skin]);
    let hat = [(0.0, 1.76), (0.3, 1.77), (0.3, 1.79), (0.16, 1.81), (0.13, 2.0), (0.0, 2.02)];
    builder.turned(&Affine3A::IDENTITY, &hat, 16, Paint::srgb(0x2B_2A2E));
    for side in [-1.0_f32, 1.0] {
        let x = side * 0.38;
        let (low, high) = (vec3(x - 0.07, 0.75, -0.07), vec3(x + 0.07, 1.32, 0.1));
        builder.cuboid(low, high, Faces::All, coat.shade(0.85));
    }
    builder.finish("figure")
}

fn lantern_mesh() -> Mesh {
    let mut builder = MeshBuilder::default();
    let glass = Paint::srgb(0xFF_F3D6);
    builder.ellipsoid(Vec3::ZERO, vec2(0.2, 0.24), [14, 10], [glass, glass]);
    builder.finish("lantern")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_courtyard_can_be_drawn_and_moves() {
        let yard = courtyard(Hour::AFTERNOON);
        assert_eq!(yard.scene.validate(), Ok(()));
        assert_eq!(yard, courtyard(Hour::AFTERNOON), "the same each time");
        let lights = &yard.scene.surfaces.as_ref().unwrap().lights;
        assert_eq!(lights.len(), 4, "a sun, two spots, a lantern");
        for change in yard.daylight.lights().iter().chain(&yard.motion.at(0.0).lights) {
            let kinds = [change.to.kind, lights[change.light.0 as usize].kind];
            let [to, there] = kinds.map(|kind| std::mem::discriminant(&kind));
            assert_eq!(to, there);
        }
        let mesh_of = |object: ObjectId| {
            let object = &yard.scene.objects[object.0 as usize];
            yard.scene.mesh_of(object).unwrap().name.clone()
        };
        assert_eq!(mesh_of(yard.motion.figure), "figure");
        assert_eq!(mesh_of(yard.motion.lantern), "lantern");
        assert_ne!(yard.motion.at(0.0), yard.motion.at(0.5));
        // It stays between the walls, the lantern over the ground, whenever.
        for second in 0..400_u32 {
            let update = yard.motion.at(f64::from(second) * 0.37);
            for change in &update.objects {
                let ObjectChange::Move { transform, .. } = change else { panic!("a move") };
                let place = transform.translation;
                assert!(place.x.abs().max(place.z.abs()) < HALF_M - 2.0 && place.y >= HOVER_M);
            }
            assert!(update.lights[0].to.position.y > 2.0);
        }
    }
}
