//! The courtyard: a small scene for light and shadows. Columns and a fence cast thin shadows, a
//! figure walks, a lantern flies, two spots are on masts, lamps hang on the walls, a spot projects
//! the picture of a window, and the sun follows the hour.

mod meshes;
mod rose;

use std::f32::consts::{FRAC_PI_2, TAU};

use cull::{Camera, ObjectId, Projection};
use glam::{Affine3A, Quat, Vec3, vec3};
use scene::{
    FOV_Y_RAD, LightCookie, LightId, LightKind, LightMove, Mesh, MeshId, NEAR_M, Object,
    ObjectChange, PunctualLight, Scene, SceneUpdate, TextureId,
};

use super::generated::HOVER_M;
use super::lights::{Daylight, Hour, LampHours, let_glow};

/// Half the side of the yard, in metres.
const HALF_M: f32 = 16.0;

/// The side of a tile of its ground, in metres.
const TILE_M: f32 = 2.0;

/// The depth in metres by which standing objects extend below the ground. Without it, light and
/// eyes could pass between an object and the ground.
const SUNK_M: f32 = 0.2;

/// The distance from the lantern's middle down to its light, in metres: outside of its own glass,
/// which would cast a shadow.
const BELOW_M: f32 = 0.4;

/// The size of a lamp on a wall, relative to the lantern.
const LAMP_SIZE: f32 = 0.75;

/// The courtyard, its lights, and its motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Courtyard {
    /// The scene, at the start of its motion.
    pub scene: Scene,
    /// The sun and the lamps.
    pub daylight: Daylight,
    /// The motion of the figure and of the lantern.
    pub motion: YardMotion,
    /// The camera that sees the courtyard.
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
        // The figure's circle takes 18 seconds, the lantern's path 40.
        let turn = (seconds / 18.0).rem_euclid(1.0) as f32 * TAU;
        let way = (seconds / 40.0).rem_euclid(1.0) as f32 * TAU;
        let (sin, cos) = turn.sin_cos();
        let walking = Affine3A::from_rotation_translation(
            Quat::from_rotation_y(-turn - FRAC_PI_2),
            vec3(6.0 * cos, HOVER_M, 6.0 * sin),
        );
        let place = vec3(7.5 * (3.0 * way).sin(), 3.0 + 0.4 * (5.0 * way).sin(), 5.0 * way.cos());
        let flying = Affine3A::from_translation(place);
        let change =
            |object, transform| ObjectChange::Move { object, transform: yard() * transform };
        let position = yard().transform_point3(place - Vec3::Y * BELOW_M);
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

/// Returns the transform of the yard to the world: its back wall is where the sun sets.
fn yard() -> Affine3A {
    Affine3A::from_rotation_y(-FRAC_PI_2)
}

/// Returns the transform of the wall with this number; in its space, the wall is along -z.
fn side(number: u8) -> Affine3A {
    Affine3A::from_rotation_y(f32::from(number) * FRAC_PI_2)
}

/// Creates the courtyard at an hour of the day. Its lamps are always on.
pub fn courtyard(hour: Hour) -> Courtyard {
    let mut yard = Yard::default();
    let at = |x: f32, z: f32| Affine3A::from_translation(vec3(x, 0.0, z));
    yard.add(meshes::ground(), &[Affine3A::IDENTITY]);
    let walls = [0, 1, 3].map(|number| side(number) * at(0.0, -HALF_M + 0.5));
    yard.add(meshes::wall(), &walls);
    let columns = (0..10_u8).map(|number| {
        let row = number % 2;
        let place = f32::from(number / 2);
        at(if row == 0 { -9.5 } else { 9.5 }, 5.0 * place - 11.0)
    });
    yard.add(meshes::column(), &columns.collect::<Vec<_>>());
    yard.add(meshes::fence(), &[at(-3.6, -8.0), at(3.6, -8.0)]);
    let turned = |x: f32, z: f32, turn: f32| at(x, z) * Affine3A::from_rotation_y(turn);
    let crates = [turned(-2.4, 1.2, 0.4), turned(-0.9, 0.2, 1.1), turned(2.8, -2.0, 0.2)];
    yard.add(meshes::crate_box(), &crates);
    let (_, figure) =
        yard.add(meshes::figure_mesh(), &[Affine3A::from_translation(vec3(6.0, HOVER_M, 0.0))]);
    yard.add(meshes::bracket(), &hung_lamps());
    let size = Affine3A::from_scale(Vec3::splat(LAMP_SIZE));
    let glasses = hung_lamps().map(|place| place * size);
    let places = [&glasses[..], &[at(0.0, 5.0)]].concat();
    let (glass, lantern) = yard.add(meshes::lantern_mesh(), &places);
    let spots = [spot(-1.0, [1.0, 0.72, 0.42]), spot(1.0, [0.55, 0.75, 1.0])];
    let heads = spots.map(|light| head_of(&light));
    yard.add(meshes::housing(), &heads);
    let (lens, _) = yard.add(meshes::lens(), &heads);
    yard.add(meshes::mast(), &spots.map(|light| mast_of(&light)));
    let mut scene = yard.scene();
    for mesh in [glass, lens] {
        let_glow(&mut scene, mesh);
    }
    let mut lights = [&spots[..], &[lantern_light()], &hung_lamps().map(lamp_light)].concat();
    if let Some(surfaces) = &mut scene.surfaces {
        lights.push(projector(rose::add(surfaces)));
        lights.iter_mut().for_each(turn_light);
        surfaces.lights.extend(&lights);
    }
    let lamps = (1..).map(LightId).zip(lights).collect::<Vec<_>>();
    let motion = YardMotion { figure, lantern, light: LightId(3), lamp: lantern_light() };
    let daylight = Daylight {
        hour,
        lamps,
        glow: None,
        lamp_hours: LampHours::Always,
        glass: Vec3::Y * BELOW_M,
        shows_pictures: true,
    };
    Courtyard { scene, daylight, motion, camera: camera() }
}

/// The meshes and objects of a yard that is being created.
#[derive(Default)]
struct Yard {
    meshes: Vec<Mesh>,
    objects: Vec<Object>,
}

impl Yard {
    /// Adds a mesh at some places. Returns the mesh, and the object at the last place.
    fn add(&mut self, mesh: Mesh, places: &[Affine3A]) -> (MeshId, ObjectId) {
        let id = MeshId(self.meshes.len() as u32);
        self.meshes.push(mesh);
        self.objects.extend(places.iter().map(|place| Object {
            mesh: id,
            transform: yard() * *place,
            tint: u32::MAX,
        }));
        (id, ObjectId(self.objects.len() as u32 - 1))
    }

    /// Returns the scene in moonlight.
    fn scene(self) -> Scene {
        let Self { meshes, objects } = self;
        let light = Hour::NIGHT.light();
        let name = "courtyard".to_owned();
        Scene { name, meshes, objects, light, surfaces: None }.with_surfaces()
    }
}

fn camera() -> Camera {
    let forward = vec3(-0.24, -0.17, -1.0);
    Camera {
        eye: yard().transform_point3(vec3(4.2, 3.6, 14.2)),
        forward: yard().transform_vector3(forward).normalize_or(Vec3::X),
        up: Vec3::Y,
        projection: Projection::perspective(FOV_Y_RAD),
        near: NEAR_M,
    }
}

fn turn_light(light: &mut PunctualLight) {
    light.position = yard().transform_point3(light.position);
    light.direction = yard().transform_vector3(light.direction).normalize_or(Vec3::NEG_Y);
    if let Some(picture) = &mut light.cookie {
        picture.up = yard().transform_vector3(picture.up);
    }
}

/// Returns a spot light in a corner that shines on the middle.
fn spot(side: f32, colour: [f32; 3]) -> PunctualLight {
    let position = vec3(side * (HALF_M - 2.5), 6.5, -HALF_M + 3.0);
    PunctualLight {
        kind: LightKind::Spot { inner_rad: 0.3, outer_rad: 0.5 },
        colour,
        intensity: 620.0,
        range_m: Some(36.0),
        position,
        direction: (vec3(side, 0.0, 1.0) - position).normalize_or(Vec3::NEG_Y),
        cookie: None,
    }
}

/// Returns the transform of a spot's housing and lens.
fn head_of(spot: &PunctualLight) -> Affine3A {
    let turn = Quat::from_rotation_arc(Vec3::NEG_Y, spot.direction);
    Affine3A::from_rotation_translation(turn, spot.position)
}

/// Returns the transform of the mast that holds a spot, behind its housing.
fn mast_of(spot: &PunctualLight) -> Affine3A {
    let behind = (spot.direction * vec3(1.0, 0.0, 1.0)).normalize_or(Vec3::Z) * -0.75;
    let Vec3 { x, z, .. } = spot.position + behind;
    Affine3A::from_translation(vec3(x, 0.0, z))
}

/// Returns the spot that projects a picture on the middle, from behind the camera.
fn projector(texture: TextureId) -> PunctualLight {
    let position = vec3(1.0, 10.5, 19.0);
    PunctualLight {
        kind: LightKind::Spot { inner_rad: 0.27, outer_rad: 0.275 },
        colour: [1.0, 0.96, 0.9],
        intensity: 1900.0,
        range_m: Some(40.0),
        position,
        direction: (vec3(0.4, 0.0, 4.6) - position).normalize_or(Vec3::NEG_Y),
        cookie: Some(LightCookie { texture, up: Vec3::Y }),
    }
}

/// Returns the transforms of the glasses of the lamps on the walls.
fn hung_lamps() -> [Affine3A; 4] {
    [(0, -5.0), (0, 5.0), (1, 0.0), (3, 0.0)]
        .map(|(wall, x)| side(wall) * Affine3A::from_translation(vec3(x, 2.9, -HALF_M + 1.45)))
}

/// Returns the light of a lamp on a wall.
fn lamp_light(place: Affine3A) -> PunctualLight {
    PunctualLight {
        colour: [1.0, 0.62, 0.3],
        intensity: 17.0,
        range_m: Some(9.0),
        position: place.transform_point3(Vec3::NEG_Y * BELOW_M),
        ..lantern_light()
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
        cookie: None,
    }
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
        assert_eq!(lights.len(), 9, "a sun, two spots, a lantern, four lamps, a projector");
        assert_eq!(lights.iter().filter(|light| light.cookie.is_some()).count(), 1);
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
        for standing in ["courtyard wall", "column", "fence", "crate", "mast"] {
            let objects = (0..yard.scene.objects.len() as u32).map(ObjectId);
            let low = |object: ObjectId| {
                yard.scene.bounds_of(&yard.scene.objects[object.0 as usize]).unwrap().min.y
            };
            let mut lows =
                objects.filter(|object| mesh_of(*object) == standing).map(low).peekable();
            assert!(lows.peek().is_some() && lows.all(|low| low < 0.0), "{standing}");
        }
        // The figure stays between the walls, and the lantern above the ground, at any time.
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
