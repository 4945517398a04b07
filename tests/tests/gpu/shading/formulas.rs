//! Shading: the images of the surface pass equal the specification's formulas, pixel by pixel.
//!
//! Positions in the comparison are exact. Flat patches have the normals of a sphere. Their corners
//! lie on corners of pixels, so that no vertex is snapped and no pixel is partly covered. Every
//! pixel that a patch covers is compared.

use glam::{Affine3A, DMat3, DVec3, Mat3A, Vec3, Vec3A, vec3};
use gpu::Device;
use render::surfaces::SurfaceOptions;
use scene::{
    LightKind, Material, Mesh, PunctualLight, Scene, SurfaceMesh, SurfaceVertex, Surfaces,
};
use tests::reference::{self, Ambient, ReferenceLight, ReferencePoint};
use tests::run_on_all;
use tests::shapes::square_camera;
use tests::surface_fixture::{image, mesh, scene, snorm16};

/// The side of the image in pixels. The camera at the origin has a field of view of 90 degrees.
const SIDE: u32 = 256;
/// The distance of all patches.
const DISTANCE_M: f32 = 4.0;
/// The side of a patch in pixels, and the number of its cells along a side.
const PATCH: u32 = 48;
const CELL: u32 = 8;
const CELLS: u32 = PATCH / CELL;
/// The number of patches in a row and in a column.
const PATCHES: u32 = 5;

/// Returns the position of a corner of pixels in the world.
fn place(x: u32, y: u32) -> Vec3 {
    let part = |pixel: u32| pixel as f32 / (SIDE / 2) as f32 - 1.0;
    vec3(part(x) * DISTANCE_M, -part(y) * DISTANCE_M, -DISTANCE_M)
}

/// Returns the unit normal at a corner of a patch's cells: the normal of a sphere, where it faces
/// the eye.
fn normal(column: u32, row: u32) -> Vec3 {
    let part = |cell: u32| (cell as f32 / CELLS as f32 * 2.0 - 1.0) * 0.68;
    let x = part(column);
    let y = -part(row);
    vec3(x, y, (1.0 - x * x - y * y).sqrt())
}

/// Returns a patch in a space in which it is `scale` times as large. The inverse of `scale`
/// transforms it to the world.
fn patch(origin: [u32; 2], scale: Vec3, material: u32) -> (Mesh, SurfaceMesh) {
    let mut positions = Vec::new();
    let mut vertices = Vec::new();
    for row in 0..=CELLS {
        for column in 0..=CELLS {
            positions.push(place(origin[0] + column * CELL, origin[1] + row * CELL) * scale);
            vertices.push(SurfaceVertex {
                normal: snorm16(normal(column, row), 0),
                tangent: snorm16(Vec3::X, 1),
                uv: [[0.0; 2]; 2],
                colour: [65535; 4],
            });
        }
    }
    let cell = |number: u32| {
        let first = number % CELLS + number / CELLS * (CELLS + 1);
        let a = first;
        let b = first + CELLS + 1;
        let c = first + 1;
        let d = first + CELLS + 2;
        [a, b, c, c, b, d]
    };
    mesh(&positions, vertices, (0..CELLS * CELLS).flat_map(cell).collect(), material)
}

/// Returns the surface normal at a pixel of a patch: transformed into the world's space at the
/// corners by `to_world`, and interpolated over the triangle that the pixel's middle is in.
fn normal_at(place: [u32; 2], to_world: DMat3) -> DVec3 {
    let [x, y] = place;
    let at = |column, row| {
        let [x, y, z, _] = snorm16(normal(column, row), 0).map(|part| f64::from(part) / 32767.0);
        (to_world * DVec3::new(x, y, z)).normalize()
    };
    let column = x / CELL;
    let row = y / CELL;
    let part = |pixel: u32| (f64::from(pixel % CELL) + 0.5) / f64::from(CELL);
    let u = part(x);
    let v = part(y);
    let a = at(column, row);
    let b = at(column, row + 1);
    let c = at(column + 1, row);
    let d = at(column + 1, row + 1);
    if u + v <= 1.0 {
        a + (c - a) * u + (b - a) * v
    } else {
        d + (b - d) * (1.0 - u) + (c - d) * (1.0 - v)
    }
}

/// A sweep of metallic (to the right) and roughness (down) under a light.
struct Sweep {
    surfaces: Surfaces,
    lights: Vec<ReferenceLight>,
    ambient: Ambient,
    transform: Mat3A,
    exposure: f32,
}

impl Sweep {
    fn new() -> Self {
        let material = |number: u32| Material {
            base_colour: [0.9, 0.55, 0.2, 1.0],
            metallic: (number % PATCHES) as f32 / (PATCHES - 1) as f32,
            roughness: (number / PATCHES) as f32 / (PATCHES - 1) as f32,
            ..Material::default()
        };
        let materials = (0..PATCHES * PATCHES).map(material).collect();
        Self {
            surfaces: Surfaces { materials, ..Surfaces::default() },
            lights: Vec::new(),
            ambient: [DVec3::ZERO; 2],
            transform: Mat3A::IDENTITY,
            exposure: 1.0,
        }
    }

    fn lit_by(mut self, light: PunctualLight) -> Self {
        let strength = reference::wide(light.colour) * f64::from(light.intensity);
        let along = light.direction.as_dvec3().normalize_or_zero();
        let position = light.position.as_dvec3();
        let range = light.range_m.map(f64::from);
        self.lights.push(match light.kind {
            LightKind::Directional => {
                ReferenceLight::Directional { towards: -along, lux: strength }
            }
            LightKind::Point => ReferenceLight::Point { position, candela: strength, range },
            LightKind::Spot { inner_rad, outer_rad } => {
                let inner = inner_rad.into();
                let outer = outer_rad.into();
                ReferenceLight::Spot { position, candela: strength, range, along, inner, outer }
            }
        });
        self.surfaces.lights.push(light);
        self
    }

    fn origin(number: u32) -> [u32; 2] {
        [number % PATCHES, number / PATCHES].map(|place| 8 + place * PATCH)
    }

    fn scene(&self) -> Scene {
        let x = self.transform.x_axis.x;
        let y = self.transform.y_axis.y;
        let z = self.transform.z_axis.z;
        let scale = vec3(x, y, z).recip();
        let meshes =
            (0..PATCHES * PATCHES).map(|number| patch(Self::origin(number), scale, number));
        let transforms = vec![
            Affine3A { matrix3: self.transform, translation: Vec3A::ZERO };
            (PATCHES * PATCHES) as usize
        ];
        let surfaces = Surfaces { exposure: self.exposure, ..self.surfaces.clone() };
        let mut scene = scene(meshes.collect(), &transforms, surfaces);
        let narrow = |v: DVec3| v.as_vec3().to_array();
        scene.light.ambient_above = narrow(self.ambient[0]);
        scene.light.ambient_below = narrow(self.ambient[1]);
        scene.light.sky = [0.0, 0.0, 1.0];
        scene
    }

    /// Returns the specification's value of a pixel; `None` where there is no patch.
    fn expected(&self, pixel: [u32; 2]) -> Option<[f64; 3]> {
        let number = (0..PATCHES * PATCHES).find(|number| {
            let origin = Self::origin(*number);
            (0..2).all(|side| (origin[side]..origin[side] + PATCH).contains(&pixel[side]))
        })?;
        let origin = Self::origin(number);
        let material = &self.surfaces.materials[number as usize];
        let matrix = self.transform.as_dmat3();
        let to_world = matrix.inverse().transpose();
        let normal = normal_at([pixel[0] - origin[0], pixel[1] - origin[1]], to_world);
        let part = |pixel: u32| (f64::from(pixel) + 0.5) / f64::from(SIDE / 2) - 1.0;
        let distance = f64::from(DISTANCE_M);
        let [red, green, blue, _] = material.base_colour;
        let point = ReferencePoint {
            base_colour: reference::wide([red, green, blue]),
            metallic: material.metallic.into(),
            roughness: material.roughness.into(),
            occlusion: 1.0,
            emission: DVec3::ZERO,
            position: DVec3::new(part(pixel[0]) * distance, -part(pixel[1]) * distance, -distance),
            normal: normal.normalize(),
        };
        let light = reference::radiance(&point, DVec3::ZERO, &self.lights, &self.ambient);
        Some(reference::encoded(reference::tone_mapped(light * f64::from(self.exposure))))
    }

    /// Draws and compares every pixel. Returns the average brightness of patches, so that a test
    /// can check that something is visible.
    fn compare(&self, device: &Device, what: &str) -> f64 {
        let found =
            image(device, &self.scene(), &square_camera(), [SIDE; 2], &SurfaceOptions::default());
        let mut sum = 0.0;
        let mut count = 0.0;
        let mut worst = (0.0_f64, [0, 0]);
        for pixel in (0..SIDE * SIDE).map(|pixel| [pixel % SIDE, pixel / SIDE]) {
            let start = (pixel[1] * SIDE + pixel[0]) as usize * 4;
            let found = &found[start..start + 4];
            let Some(expected) = self.expected(pixel) else {
                assert_eq!(found, [0, 0, 255, 255], "{what}: the sky at {pixel:?}");
                continue;
            };
            for (found, expected) in found.iter().zip(expected) {
                sum += expected;
                count += 1.0;
                let difference = (f64::from(*found) - expected).abs();
                if difference > worst.0 {
                    worst = (difference, pixel);
                }
            }
            assert_eq!(found[3], 255);
        }
        let (difference, pixel) = worst;
        eprintln!("{what} on {}: {difference:.3} of 255 at {pixel:?}", device.adapter().name);
        assert!(difference <= 2.0, "{what}: {difference} of 255 at {pixel:?}");
        sum / count
    }
}

fn sun() -> PunctualLight {
    PunctualLight {
        kind: LightKind::Directional,
        colour: [1.0, 0.9, 0.8],
        intensity: 2.5,
        range_m: None,
        position: Vec3::ZERO,
        direction: vec3(-0.5, -0.6, -0.7),
        cookie: None,
    }
}

fn bulb() -> PunctualLight {
    PunctualLight {
        kind: LightKind::Point,
        colour: [0.6, 0.8, 1.0],
        intensity: 20.0,
        range_m: Some(9.0),
        position: vec3(-1.5, 1.0, -2.0),
        direction: Vec3::NEG_Z,
        cookie: None,
    }
}

fn torch() -> PunctualLight {
    PunctualLight {
        kind: LightKind::Spot { inner_rad: 0.3, outer_rad: 0.7 },
        colour: [1.0, 0.5, 0.9],
        intensity: 60.0,
        range_m: None,
        position: vec3(1.0, -0.5, 0.5),
        direction: vec3(0.1, 0.2, -1.0),
        cookie: None,
    }
}

#[test]
fn each_kind_of_light_is_the_specifications() {
    run_on_all(|device| {
        for (what, light) in
            [("a directional light", sun()), ("a point light", bulb()), ("a spot", torch())]
        {
            let brightness = Sweep::new().lit_by(light).compare(device, what);
            assert!(brightness > 20.0, "{what}: {brightness}");
        }
    });
}

#[test]
fn all_lights_together_are_exposed_and_tone_mapped() {
    run_on_all(|device| {
        let mut sweep = Sweep::new().lit_by(sun()).lit_by(torch()).lit_by(bulb());
        sweep.ambient = [DVec3::new(0.3, 0.4, 0.5), DVec3::new(0.2, 0.1, 0.05)];
        assert!(sweep.compare(device, "all lights") > 100.0);
        sweep.exposure = 6.0;
        assert!(sweep.compare(device, "all lights, overexposed") > 180.0);
    });
}

#[test]
fn ambient_light_comes_from_above_and_below() {
    run_on_all(|device| {
        let mut sweep = Sweep::new();
        sweep.ambient = [DVec3::new(0.5, 0.6, 0.7), DVec3::new(0.2, 0.1, 0.0)];
        assert!(sweep.compare(device, "ambient light") > 50.0);
    });
}

#[test]
fn normals_hold_where_objects_are_stretched_or_mirrored() {
    run_on_all(|device| {
        let tiny = vec3(-1.0e-13, 1.0e-13, 1.0e-13);
        let scales = [vec3(0.5, 2.0, 1.0), vec3(-1.0, 1.0, 1.0), vec3(-2.0, -0.25, -0.5), tiny];
        for scale in scales {
            let mut sweep = Sweep::new().lit_by(sun()).lit_by(bulb());
            sweep.transform = Mat3A::from_diagonal(scale);
            sweep.compare(device, &format!("scaled by {scale}"));
        }
    });
}
