//! A yard of boxes under lights of each kind, with shadows.

use cull::{Aabb, Camera, Projection};
use glam::{Affine3A, Quat, Vec3, vec3};
use scene::{
    Light, LightKind, Material, MaterialId, MeshId, Object, PunctualLight, Scene, Surfaces,
    pack_unorm,
};

use crate::shapes::{box_at, cube, surface_of};

/// The ground, as a box.
pub const GROUND: Aabb =
    Aabb { min: Vec3::new(-16.0, -0.5, -16.0), max: Vec3::new(16.0, 0.0, 16.0) };

/// Returns the boxes of the yard: the ground, a wall, columns, and a grid of small ones.
pub fn boxes() -> Vec<Aabb> {
    let mut boxes = vec![GROUND];
    boxes.push(Aabb::new(vec3(-8.0, 0.0, -6.0), vec3(-2.0, 2.5, -5.6)));
    for column in 0..6 {
        let centre = vec3(column as f32 * 2.4 - 6.0, 1.5, 2.0);
        boxes.push(box_at(centre, vec3(0.25, 1.5, 0.25)));
    }
    for small in 0..36 {
        let [x, z] = [small % 6, small / 6].map(|place| place as f32 * 1.7 - 2.0);
        let height = 0.2 + 0.15 * (small % 5) as f32;
        boxes.push(box_at(vec3(x, height, z - 6.0), vec3(0.3, height, 0.3)));
    }
    // A roof over a corner, and a bar in the air.
    boxes.push(Aabb::new(vec3(5.0, 2.6, -2.0), vec3(9.0, 2.8, 3.0)));
    boxes.push(Aabb::new(vec3(-6.0, 3.0, -1.0), vec3(4.0, 3.15, -0.85)));
    boxes
}

/// Returns a sun, a spot and a point light over the yard.
pub fn lights() -> [PunctualLight; 3] {
    let light = |kind, intensity, position, direction: Vec3, range_m| PunctualLight {
        kind,
        colour: [1.0, 0.95, 0.85],
        intensity,
        range_m,
        position,
        direction: direction.normalize(),
        cookie: None,
    };
    let spot = LightKind::Spot { inner_rad: 0.4, outer_rad: 0.6 };
    [
        light(LightKind::Directional, 1.6, Vec3::ZERO, vec3(-0.5, -0.8, -0.35), None),
        light(spot, 60.0, vec3(-5.0, 6.0, 5.0), vec3(0.25, -0.8, -0.5), Some(20.0)),
        light(LightKind::Point, 20.0, vec3(3.5, 2.2, 0.4), Vec3::NEG_Y, Some(12.0)),
    ]
}

/// Returns a scene of boxes under lights.
pub fn scene(boxes: &[Aabb], lights: &[PunctualLight]) -> Scene {
    let mesh = cube(pack_unorm([1.0; 4]), 1);
    let surfaces = Surfaces {
        meshes: vec![surface_of(&mesh, MaterialId(0))],
        materials: vec![Material { metallic: 0.0, ..Material::default() }],
        lights: lights.to_vec(),
        ..Surfaces::default()
    };
    let object =
        |bounds: &Aabb| Object { mesh: MeshId(0), transform: transform_of(bounds), tint: u32::MAX };
    let light = Light { ambient_above: [0.1; 3], ambient_below: [0.05; 3], ..Light::afternoon() };
    Scene {
        name: "yard".to_owned(),
        meshes: vec![mesh],
        objects: boxes.iter().map(object).collect(),
        light,
        surfaces: Some(surfaces),
    }
}

/// Returns the transform from the unit cube to a box.
pub fn transform_of(bounds: &Aabb) -> Affine3A {
    let size = bounds.max - bounds.min;
    Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, bounds.min)
}

/// Returns a camera that looks over the yard.
pub fn camera() -> Camera {
    let eye = vec3(1.0, 5.5, 11.0);
    Camera {
        eye,
        forward: (vec3(0.0, 0.0, -1.5) - eye).normalize(),
        up: Vec3::Y,
        projection: Projection::perspective(1.0),
        near: 0.1,
    }
}
