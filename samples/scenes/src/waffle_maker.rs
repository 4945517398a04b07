//! The waffle maker: a kitchen appliance of some thirty closed parts, accurate to the millimetre,
//! whose lid opens about a hinge.

mod logo;
mod shapes;

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use cull::{Camera, ObjectId, Projection};
use glam::{Affine3A, Quat, Vec2, Vec3, vec2, vec3};
use scene::{
    FOV_Y_RAD, Light, Material, MaterialId, Mesh, MeshId, Object, ObjectChange, PatchSurface,
    Scene, SceneUpdate,
};

use super::parts::{PartId, PartNode, PartTree};
use super::routes::{Flight, Routes, Streets};

/// The height of the parting plane of lid and body, and of the hinge's axis, in metres.
const PARTING_M: f32 = 0.060;

/// The z of the hinge's axis, in metres.
const HINGE_Z_M: f32 = -0.142;

/// The least angle of the lid, in radians. It touches the body before it reaches this angle.
const SHUT_RAD: f32 = -0.05;

/// The end of the hinge's range, in radians. The cable stops the lid some degrees before.
const OPEN_RAD: f32 = 170.0 / 180.0 * PI;

/// The number of cameras of its path.
const CAMERAS: u8 = 8;

/// The distance of the near plane, in metres.
const NEAR_M: f32 = 0.02;

/// A joint that turns about an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hinge {
    /// A point of the axis in the world, in metres.
    pub point: Vec3,
    /// The direction of the axis, a unit vector; positive angles turn counter-clockwise about it.
    pub axis: Vec3,
    /// The least angle, in radians: slightly below the angle at rest, for parts that are pressed
    /// shut.
    pub shut_rad: f32,
    /// The angle at rest, in radians.
    pub closed_rad: f32,
    /// The largest angle, in radians.
    pub open_rad: f32,
}

impl Hinge {
    /// Returns the transform from the place at rest to the place at an angle, which is clamped to
    /// the hinge's range.
    pub fn turn(&self, angle_rad: f32) -> Affine3A {
        let angle_rad = angle_rad.clamp(self.shut_rad, self.open_rad);
        let turn = Quat::from_axis_angle(self.axis, angle_rad);
        let about = Affine3A::from_rotation_translation(turn, self.point);
        about * Affine3A::from_translation(-self.point)
    }
}

/// A mesh of a curved surface, which can be tessellated again at other levels.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvedMesh {
    /// The mesh.
    pub mesh: MeshId,
    /// The surface.
    pub surface: PatchSurface,
}

/// The waffle maker, closed.
#[derive(Clone, Debug, PartialEq)]
pub struct WaffleMaker {
    /// The objects, one per part, with surfaces.
    pub scene: Scene,
    /// The parts. Each is a closed solid, except the logo.
    pub parts: PartTree,
    /// The group of all parts that open with the lid.
    pub lid: PartId,
    /// The logo, a picture 0.3 mm above the lid.
    pub logo: ObjectId,
    /// The knob on the lid, made of Bezier patches; `None` if it had no surface.
    pub knob: Option<CurvedMesh>,
    /// The hinge of the lid.
    pub hinge: Hinge,
    /// The cameras of a closed path around it.
    pub cameras: Vec<Camera>,
    /// The circular flight around it.
    pub routes: Routes,
}

impl WaffleMaker {
    /// Returns the changes that open the lid to an angle, in radians, clamped to its range.
    #[must_use]
    pub fn opened(&self, angle_rad: f32) -> SceneUpdate {
        let turn = self.hinge.turn(angle_rad);
        let objects = self.parts.objects_of(self.lid).into_iter().filter_map(|object| {
            let rest = self.scene.objects.get(object.0 as usize)?.transform;
            Some(ObjectChange::Move { object, transform: turn * rest })
        });
        SceneUpdate { objects: objects.collect(), ..SceneUpdate::default() }
    }
}

/// The material of a part's surface.
#[derive(Clone, Copy)]
enum Finish {
    Plastic,
    Metal,
    Glow,
}

/// The parts created so far.
struct Maker {
    meshes: Vec<Mesh>,
    finishes: Vec<Finish>,
    objects: Vec<Object>,
    parts: PartTree,
}

impl Maker {
    /// Adds a part at each of these places.
    fn add(&mut self, parent: PartId, finish: Finish, mesh: Mesh, places: &[Affine3A]) {
        let id = MeshId(self.meshes.len() as u32);
        for (number, transform) in (1..).zip(places) {
            let object = ObjectId(self.objects.len() as u32);
            let name = match places {
                [_] => mesh.name.clone(),
                _ => format!("{} {number}", mesh.name),
            };
            self.parts.add(PartNode { name, parent: Some(parent), object: Some(object) });
            self.objects.push(Object { mesh: id, transform: *transform, tint: u32::MAX });
        }
        self.meshes.push(mesh);
        self.finishes.push(finish);
    }

    /// Adds a part at the place of its mesh.
    fn fixed(&mut self, parent: PartId, finish: Finish, mesh: Mesh) {
        self.add(parent, finish, mesh, &[Affine3A::IDENTITY]);
    }
}

/// Creates the waffle maker. It stands on y = 0, is 30 cm wide, and its front faces +z.
pub fn waffle_maker() -> WaffleMaker {
    let mut maker = Maker {
        meshes: Vec::new(),
        finishes: Vec::new(),
        objects: Vec::new(),
        parts: PartTree::of_root("waffle maker"),
    };
    let root = PartId(0);
    let base = maker.parts.group("base", root);
    add_base(&mut maker, base);
    let lid = maker.parts.group("lid", root);
    let logo = add_lid(&mut maker, lid);
    let knob = add_knob(&mut maker, lid);
    let Maker { meshes, finishes, objects, parts } = maker;
    let name = "waffle maker".to_owned();
    let light = Light::afternoon();
    let scene = Scene { name, meshes, objects, light, surfaces: None };
    let mut scene = scene.with_surfaces();
    finish_surfaces(&mut scene, &finishes);
    if let Some(surfaces) = &mut scene.surfaces {
        logo::print(surfaces, MeshId(scene.objects[logo.0 as usize].mesh.0));
    }
    let hinge = Hinge {
        point: vec3(0.0, PARTING_M, HINGE_Z_M),
        axis: Vec3::NEG_X,
        shut_rad: SHUT_RAD,
        closed_rad: 0.0,
        open_rad: OPEN_RAD,
    };
    let flight = Flight {
        centre: vec3(0.0, 0.36, 0.0),
        radius_m: 0.42,
        down_rad: 0.65,
        inwards_rad: FRAC_PI_2,
    };
    let routes = Routes { seed: 0, streets: Streets::default(), flight };
    WaffleMaker { scene, parts, lid, logo, knob, hinge, cameras: cameras(), routes }
}

/// Returns cameras around it that look at its middle, the first one in front of it.
fn cameras() -> Vec<Camera> {
    let middle = vec3(0.0, 0.05, 0.0);
    let camera = |number: u8| {
        let turn = TAU * f32::from(number) / f32::from(CAMERAS);
        let height = if number.is_multiple_of(2) { 0.30 } else { 0.22 };
        let eye = vec3(0.45 * turn.sin(), height, 0.45 * turn.cos());
        let forward = (middle - eye).normalize_or(Vec3::NEG_Z);
        let projection = Projection::perspective(FOV_Y_RAD);
        Camera { eye, forward, up: Vec3::Y, projection, near: NEAR_M }
    };
    (0..CAMERAS).map(camera).collect()
}

fn at(x: f32, y: f32, z: f32) -> Affine3A {
    Affine3A::from_translation(vec3(x, y, z))
}

/// Returns a transform that points the y axis to the front, with this origin.
fn facing_front(x: f32, y: f32, z: f32) -> Affine3A {
    at(x, y, z) * Affine3A::from_rotation_x(FRAC_PI_2)
}

/// Returns a transform that points the y axis to the right, with this origin.
fn along_x(x: f32, y: f32, z: f32) -> Affine3A {
    at(x, y, z) * Affine3A::from_rotation_z(-FRAC_PI_2)
}

fn add_base(maker: &mut Maker, base: PartId) {
    maker.fixed(base, Finish::Plastic, shapes::body());
    maker.add(base, Finish::Metal, shapes::plate("lower plate"), &[at(0.0, 0.041, 0.0)]);
    let feet = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    let under = feet.map(|(x, z)| at(0.108 * x, 0.0, 0.083 * z));
    maker.add(base, Finish::Plastic, shapes::foot(), &under);
    let hinge = maker.parts.group("hinge, fixed half", base);
    let knuckles = [-0.0675, 0.0675].map(|x| at(x, PARTING_M, HINGE_Z_M));
    maker.add(hinge, Finish::Metal, shapes::knuckle("body knuckle", -0.8), &knuckles);
    maker.add(hinge, Finish::Metal, shapes::pin(), &[along_x(0.0, PARTING_M, HINGE_Z_M)]);
    let panel = maker.parts.group("panel", base);
    maker.add(panel, Finish::Plastic, shapes::dial(), &[facing_front(0.09, 0.037, 0.1256)]);
    for (name, hex, x) in [("lamp, power", 0xE2_2B1B, -0.105), ("lamp, ready", 0x37_C24A, -0.08)] {
        let place = [facing_front(x, 0.037, 0.1256)];
        maker.add(panel, Finish::Glow, shapes::lamp(name, hex), &place);
        let bezel = shapes::bezel(&format!("{name}, bezel"));
        maker.add(panel, Finish::Metal, bezel, &place);
    }
    let cord = maker.parts.group("cord", base);
    maker.fixed(cord, Finish::Plastic, shapes::cable());
    maker.fixed(cord, Finish::Plastic, shapes::plug());
    let prongs = [-0.0095, 0.0095].map(|z| along_x(-0.151, 0.012, -0.19 + z));
    maker.add(cord, Finish::Metal, shapes::prong(), &prongs);
    let screws = [-0.06, 0.06].map(|x| at(x, 0.0095, 0.0) * Affine3A::from_rotation_x(PI));
    maker.add(base, Finish::Metal, shapes::screw("bottom screw"), &screws);
}

/// Adds the lid. Returns the logo.
fn add_lid(maker: &mut Maker, lid: PartId) -> ObjectId {
    maker.fixed(lid, Finish::Plastic, shapes::lid());
    let turned = at(0.0, 0.079, 0.0) * Affine3A::from_rotation_x(PI);
    maker.add(lid, Finish::Metal, shapes::plate("upper plate"), &[turned]);
    let handle = maker.parts.group("handle", lid);
    let posts = [-0.055, 0.055].map(|x| facing_front(x, 0.077, 0.1262));
    maker.add(handle, Finish::Metal, shapes::post(), &posts);
    maker.add(handle, Finish::Plastic, shapes::grip(), &[along_x(0.0, 0.077, 0.160)]);
    let hinge = maker.parts.group("hinge, turning half", lid);
    let knuckles = [-0.0415, 0.0415].map(|x| at(x, PARTING_M, HINGE_Z_M));
    maker.add(hinge, Finish::Metal, shapes::knuckle("lid knuckle", 0.8), &knuckles);
    let corners: [Vec2; 4] = [vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(-1.0, 1.0), vec2(1.0, 1.0)];
    let screws = corners.map(|corner| at(0.082 * corner.x, 0.1112, 0.055 * corner.y));
    maker.add(lid, Finish::Metal, shapes::screw("lid screw"), &screws);
    let logo = ObjectId(maker.objects.len() as u32);
    maker.fixed(lid, Finish::Plastic, logo::decal(0.1108));
    logo
}

/// Adds the knob on the lid, at a level for a view of the whole model.
fn add_knob(maker: &mut Maker, lid: PartId) -> Option<CurvedMesh> {
    let surface = shapes::knob()?;
    let mesh = MeshId(maker.meshes.len() as u32);
    let place = [at(0.0, 0.1187, 0.055)];
    maker.add(lid, Finish::Metal, shapes::tessellated_knob(&surface), &place);
    Some(CurvedMesh { mesh, surface })
}

/// Gives each mesh the material of its finish.
fn finish_surfaces(scene: &mut Scene, finishes: &[Finish]) {
    let Some(surfaces) = &mut scene.surfaces else { return };
    let material = |name: &str, metallic: f32, roughness: f32, glow: f32| Material {
        name: name.to_owned(),
        metallic,
        roughness,
        emission: [glow, glow * 0.5, glow * 0.4],
        ..Material::default()
    };
    surfaces.materials = vec![
        material("plastic", 0.0, 0.45, 0.0),
        material("metal", 0.35, 0.4, 0.0),
        material("glass", 0.0, 0.2, 0.15),
    ];
    for (mesh, finish) in surfaces.meshes.iter_mut().zip(finishes) {
        mesh.material = MaterialId(match finish {
            Finish::Plastic => 0,
            Finish::Metal => 1,
            Finish::Glow => 2,
        });
    }
}
