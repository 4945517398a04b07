//! Midpoint depths: closed and open surfaces do not shadow themselves even where the plane of a
//! receiver does not help, and both still cast their shadows.

use std::f32::consts::TAU;

use cull::{Aabb, Camera, Projection, Strategy};
use glam::{Affine3A, Vec3, vec3};
use gpu::Device;
use scene::{
    Mesh, MeshId, Object, PunctualLight, Scene, Vertex, bounds_of_vertices, pack_normal, pack_unorm,
};
use shadows::{ShadowBias, ShadowCaching, ShadowFilter, ShadowOptions};
use tests::{run_on_all, shadow_scene, shapes};

use super::{image, renderer, shadows};

/// The side of a sheet in metres, and its cells along one.
const SIDE_M: f32 = 8.0;
const CELLS: u32 = 128;

/// Returns the height of waves, which any sufficiently high light reaches everywhere.
fn waves(x: f32, z: f32) -> f32 {
    0.1 * (x * TAU / 0.8).cos() * (z * TAU / 1.1).cos()
}

/// Returns a sheet at heights over the ground (metres): closed if it has a thickness, otherwise
/// only its upper side.
fn sheet(height: impl Fn(f32, f32) -> f32, thickness_m: Option<f32>) -> Mesh {
    let row = CELLS + 1;
    let mut vertices = Vec::new();
    let mut indices = Vec::new();
    for lowered in [Some(0.0), thickness_m].into_iter().flatten() {
        for place in 0..row * row {
            let [x, z] =
                [place % row, place / row].map(|step| (step as f32 / CELLS as f32 - 0.5) * SIDE_M);
            let position = [x, height(x, z) - lowered, z];
            let slope = |dx, dz| (height(x + dx, z + dz) - height(x - dx, z - dz)) / 0.002;
            let up = vec3(-slope(0.001, 0.0), 1.0, -slope(0.0, 0.001)).normalize();
            let normal = pack_normal(if lowered > 0.0 { -up } else { up });
            vertices.push(Vertex { position, normal, colour: pack_unorm([1.0; 4]) });
        }
    }
    let at = |x: u32, z: u32| z * row + x;
    for cell in 0..CELLS * CELLS {
        let x = cell % CELLS;
        let z = cell / CELLS;
        let a = at(x, z);
        let b = at(x + 1, z);
        let c = at(x, z + 1);
        let d = at(x + 1, z + 1);
        indices.extend([a, c, b, b, c, d]);
        if thickness_m.is_some() {
            let [a, b, c, d] = [a, b, c, d].map(|vertex| vertex + row * row);
            indices.extend([a, b, c, b, d, c]);
        }
    }
    if thickness_m.is_some() {
        let corners = [[0, 0], [0, CELLS], [CELLS, CELLS], [CELLS, 0], [0, 0]];
        for (from, to) in corners.iter().zip(&corners[1..]) {
            let along = |step: u32| {
                let [x, z] = [0, 1].map(|axis| {
                    let a = from[axis];
                    let b = to[axis];
                    if a == b {
                        a
                    } else if b > a {
                        step
                    } else {
                        CELLS - step
                    }
                });
                at(x, z)
            };
            for step in 0..CELLS {
                let a = along(step);
                let b = along(step + 1);
                let c = a + row * row;
                let d = b + row * row;
                indices.extend([a, c, b, b, c, d]);
            }
        }
    }
    let bounds = bounds_of_vertices(&vertices);
    Mesh { name: "sheet".to_owned(), vertices, indices, bounds, has_backs: false }
}

/// Returns a scene of a sheet at a height, and boxes.
fn scene(mesh: Mesh, height_m: f32, boxes: &[Aabb], lights: &[PunctualLight]) -> Scene {
    let mut scene = shadow_scene::scene(boxes, lights);
    let surfaces = scene.surfaces.as_mut().unwrap();
    surfaces.meshes.push(shapes::surface_of(&mesh, surfaces.meshes[0].material));
    scene.meshes.push(mesh);
    let transform = Affine3A::from_translation(Vec3::Y * height_m);
    scene.objects.push(Object { mesh: MeshId(1), transform, tint: u32::MAX });
    scene
}

/// Returns lights of each kind that reach all parts of the waves.
fn lights_above() -> [PunctualLight; 3] {
    let [sun, spot, point] = shadow_scene::lights();
    [
        PunctualLight { direction: vec3(0.05, -1.0, 0.03).normalize(), ..sun },
        PunctualLight { position: vec3(0.2, 6.0, 0.1), direction: Vec3::NEG_Y, ..spot },
        PunctualLight { position: vec3(0.1, 5.0, -0.2), ..point },
    ]
}

/// Returns a camera that looks from one place at another.
fn looking(eye: Vec3, at: Vec3) -> Camera {
    Camera {
        eye,
        forward: (at - eye).normalize(),
        up: Vec3::Y,
        projection: Projection::perspective(1.0),
        near: 0.1,
    }
}

/// Draws a frame of a scene with each of several shadow options.
fn draw(device: &Device, scene: &Scene, camera: Camera, all: &[ShadowOptions]) -> Vec<Vec<u8>> {
    let mut renderer = renderer(device, scene, ShadowOptions::default());
    let mut view = renderer.new_view().unwrap();
    let draw = |options: &ShadowOptions| {
        renderer.set_shadows(*options).unwrap();
        image(&mut renderer, &mut view, Strategy::ANTUMBRA, camera)
    };
    all.iter().map(draw).collect()
}

/// Returns the number of pixels that differ by more than the rounding of separately compiled
/// passes.
fn wrong(expected: &[u8], found: &[u8]) -> usize {
    let pixels = expected.chunks_exact(4).zip(found.chunks_exact(4));
    pixels.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1)).count()
}

#[test]
fn hollows_under_wide_filters_are_lit_by_midpoints_and_not_by_first_surfaces() {
    run_on_all(|device| {
        let wide = ShadowOptions { penumbra_m: 0.24, ..shadows() };
        let filters = [ShadowFilter::Adaptive, ShadowFilter::Fixed64, ShadowFilter::Pcss64];
        let of = |bias| filters.map(|filter| ShadowOptions { bias, filter, ..wide });
        let mut all = vec![ShadowOptions::default()];
        all.extend([ShadowBias::Plane, ShadowBias::Midpoint].into_iter().flat_map(of));
        // The rim, which only grazing light reaches, is out of view.
        let camera = looking(vec3(0.3, 2.0, 1.4), vec3(0.0, 0.0, 0.2));
        for light in lights_above() {
            let scene = scene(sheet(waves, Some(0.3)), 0.0, &[], &[light]);
            let images = draw(device, &scene, camera, &all);
            let counts: Vec<usize> =
                images[1..].iter().map(|found| wrong(&images[0], found)).collect();
            println!("{:?}: {counts:?}", light.kind);
            let (planes, midpoints) = counts.split_at(filters.len());
            assert!(planes[..2].iter().all(|wrong| *wrong > 500), "{planes:?}, {light:?}");
            assert_eq!(midpoints, [0; 3], "{light:?}");
        }
    });
}

#[test]
fn open_meshes_do_not_shadow_themselves_and_keep_their_shadow() {
    run_on_all(|device| {
        let flat = || sheet(|_, _| 0.0, None);
        let finer = ShadowOptions { sun_side: 1024, spot_side: 512, point_side: 512, ..shadows() };
        let camera = looking(vec3(-3.5, 2.6, 4.4), vec3(-1.0, 0.0, 0.3));
        for light in shadow_scene::lights() {
            let alone = scene(flat(), 0.0, &[], &[light]);
            let all = ShadowFilter::ALL.map(|filter| ShadowOptions {
                bias: ShadowBias::Midpoint,
                filter,
                ..finer
            });
            let all = [&[ShadowOptions::default()][..], &all].concat();
            let images = draw(device, &alone, camera, &all);
            for (found, options) in images.iter().zip(&all) {
                assert_eq!(wrong(&images[0], found), 0, "{options:?} under {light:?}");
            }
        }
        // Over closed ground, whose lower side is the next back face.
        let [sun, ..] = lights_above();
        let sun = PunctualLight { direction: vec3(-1.0, -0.9, -0.3).normalize(), ..sun };
        let mut roof = flat();
        roof.vertices.iter_mut().for_each(|vertex| vertex.position[0] *= 0.4);
        roof.bounds = bounds_of_vertices(&roof.vertices);
        let roofed = scene(roof, 1.4, &[shadow_scene::GROUND], &[sun]);
        let single = ShadowOptions { filter: ShadowFilter::Single, ..finer };
        let options = [
            ShadowOptions::default(),
            single,
            ShadowOptions { bias: ShadowBias::Midpoint, ..single },
        ];
        let [lit, planes, midpoints] = &draw(device, &roofed, camera, &options)[..] else {
            panic!()
        };
        let dark = wrong(lit, planes);
        let apart = wrong(planes, midpoints);
        assert!(dark > 1000 && apart == 0, "{apart} of {dark} pixels differ");
    });
}

#[test]
fn midpoints_are_made_of_all_casters() {
    run_on_all(|device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let uncached = ShadowOptions { caching: ShadowCaching::Uncached, ..shadows() };
        let [planes, midpoints] = [ShadowBias::Plane, ShadowBias::Midpoint].map(|bias| {
            let mut renderer = renderer(device, &scene, ShadowOptions { bias, ..uncached });
            let mut view = renderer.new_view().unwrap();
            image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
            renderer.shadow_stats()
        });
        assert_eq!(planes.culled_faces, planes.faces);
        assert_eq!((midpoints.culled_faces, midpoints.tests), (0, 0));
        assert!(midpoints.drawn_faces == planes.faces && midpoints.casters == planes.casters);
    });
}
