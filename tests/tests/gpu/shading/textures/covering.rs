//! Surfaces that cover each other: holes, ties, blending, the sky.

use glam::{Affine3A, DVec3, EulerRot, Quat, Vec3};
use scene::{
    Alpha, Encoding, Material, MaterialId, MeshId, Object, SurfaceMesh, SurfaceVertex, Surfaces,
};
use tests::{run_on_all, surface_fixture};

use super::{
    SHARP, SIDE, assert_close, draw, image, one, reference, scene_of, texture, unlit, using, whole,
};

const ONCE: [[f32; 2]; 2] = [[0.0; 2], [1.0; 2]];

#[test]
fn masks_cut_holes_where_alpha_is_below_the_cutoff() {
    run_on_all(|device| {
        // Alpha grows to the right, and is scaled by factor and vertex.
        let ramp = |x: u32, _| [200, 100, 50, (x * 17) as u8];
        for cutoff in [0.0, 0.3, 0.5, 1.0, 1.5] {
            let masked = Material {
                alpha: Alpha::Mask { cutoff },
                base_colour: [1.0, 1.0, 1.0, 0.8],
                ..unlit()
            };
            let behind = Material {
                base_colour: [0.0, 0.0, 1.0, 1.0],
                is_unlit: true,
                ..Material::default()
            };
            let mut surfaces = one(image([16, 1], ramp), texture(0, Encoding::Srgb, SHARP), masked);
            surfaces.materials.push(behind);
            let meshes = vec![
                whole(ONCE, |_| {}),
                surface_fixture::quad(SIDE, [0, 0], [SIDE, SIDE / 2], 5.0, ONCE, 1, |_| {}),
            ];
            let mut scene = scene_of(meshes, surfaces);
            scene.light.sky = [1.0, 1.0, 0.0];
            for (pixel, found) in draw(device, &scene).into_iter().enumerate() {
                let x = pixel as u32 % SIDE / 4;
                let alpha = f64::from(x * 17) / 255.0 * 0.8;
                let is_hole = alpha < f64::from(cutoff);
                let expected = match (is_hole, pixel as u32 / SIDE < SIDE / 2) {
                    (false, _) => [200, 100, 50, 255],
                    (true, true) => [0, 0, 255, 255],
                    (true, false) => [255, 255, 0, 255],
                };
                assert_eq!(found, expected, "cutoff {cutoff} at {pixel}");
            }
        }
    });
}

#[test]
fn ties_do_not_depend_on_the_order_of_draws() {
    run_on_all(|device| {
        let colours = [[0.8, 0.1, 0.3, 1.0], [0.2, 0.9, 0.3, 1.0], [0.1, 0.1, 0.7, 1.0]];
        let material =
            |base_colour| Material { base_colour, is_unlit: true, ..Material::default() };
        let draw_in = |order: [usize; 3]| {
            let materials = order.map(|place| material(colours[place])).to_vec();
            let surfaces = Surfaces { materials, ..Surfaces::default() };
            let square = |material| {
                surface_fixture::quad(SIDE, [0, 0], [SIDE, SIDE], 4.0, ONCE, material, |_| {})
            };
            draw(device, &scene_of((0..3).map(square).collect(), surfaces))
        };
        let first = draw_in([0, 1, 2]);
        for order in [[2, 1, 0], [1, 2, 0], [2, 0, 1]] {
            assert_eq!(draw_in(order), first);
        }
        let largest = DVec3::new(0.8, 0.9, 0.7);
        assert_close(first[0], reference::encoded(largest), 0, "the largest of each channel");
    });
}

#[test]
fn the_sky_is_where_nothing_is_and_black_surfaces_stay_black() {
    run_on_all(|device| {
        let black =
            Material { base_colour: [0.0, 0.0, 0.0, 1.0], is_unlit: true, ..Material::default() };
        let surfaces = Surfaces { materials: vec![black], ..Surfaces::default() };
        // Far away, where the depth is almost the depth of the background.
        let half = surface_fixture::quad(SIDE, [0, 0], [SIDE / 2, SIDE], 1.0e6, ONCE, 0, |_| {});
        let mut scene = scene_of(vec![half], surfaces);
        scene.light.sky = [0.0, 1.0, 0.0];
        for (pixel, found) in draw(device, &scene).into_iter().enumerate() {
            let is_black = (pixel as u32 % SIDE) < SIDE / 2;
            assert_eq!(found, if is_black { [0, 0, 0, 255] } else { [0, 255, 0, 255] });
        }
    });
}

#[test]
fn blended_surfaces_mix_and_are_hidden_but_hide_nothing() {
    run_on_all(|device| {
        let unlit = |base_colour, alpha| Material {
            base_colour,
            alpha,
            is_unlit: true,
            ..Material::default()
        };
        let materials = vec![
            unlit([1.0, 0.0, 0.0, 1.0], Alpha::Opaque),
            unlit([0.0, 1.0, 0.0, 0.25], Alpha::Blend),
            unlit([0.0, 0.0, 1.0, 0.5], Alpha::Blend),
        ];
        let surfaces = Surfaces { materials, ..Surfaces::default() };
        let meshes = vec![
            surface_fixture::quad(SIDE, [0, 0], [SIDE, SIDE], 4.0, ONCE, 0, |_| {}),
            surface_fixture::quad(SIDE, [0, 0], [SIDE, SIDE], 3.0, ONCE, 1, |_| {}),
            surface_fixture::quad(SIDE, [0, 0], [SIDE, SIDE], 2.0, ONCE, 2, |_| {}),
            surface_fixture::quad(SIDE, [0, 0], [SIDE, SIDE], 5.0, ONCE, 2, |_| {}),
        ];
        let mut scene = scene_of(meshes, surfaces);
        let transparent: Vec<Object> = scene.objects.drain(1..).collect();
        assert_eq!(transparent[0].mesh, MeshId(1));
        scene.surfaces.as_mut().unwrap().transparent = transparent;
        let mixed = (DVec3::X * 0.75 + DVec3::Y * 0.25) * 0.5 + DVec3::Z * 0.5;
        for (pixel, found) in draw(device, &scene).into_iter().enumerate() {
            assert_close(found, reference::encoded(mixed), pixel, "two blended");
            assert_eq!(found[3], 255);
        }
    });
}

#[test]
fn numbers_out_of_range_leave_images_whole() {
    run_on_all(|device| {
        let strange = Material {
            base_colour: [1.0e30, 2.0, -1.0, -7.0],
            metallic: -3.0e38,
            roughness: 0.0,
            emission: [3.0e38, -1.0e30, 1.0e30],
            normal_scale: 3.0e38,
            normal_texture: using(0),
            occlusion_strength: -3.0,
            ..Material::default()
        };
        let mut surfaces = one(
            image([1, 1], |_, _| [128, 128, 0, 255]),
            texture(0, Encoding::Linear, SHARP),
            strange,
        );
        let bulb = scene::PunctualLight {
            kind: scene::LightKind::Point,
            colour: [1.0; 3],
            intensity: 1.0e9,
            range_m: None,
            position: glam::Vec3::new(0.0, 0.0, -4.0),
            direction: glam::Vec3::ZERO,
            cookie: None,
        };
        surfaces.lights = vec![
            bulb,
            scene::PunctualLight { intensity: f32::NAN, ..bulb },
            scene::PunctualLight { position: glam::Vec3::INFINITY, ..bulb },
            scene::PunctualLight { kind: scene::LightKind::Directional, ..bulb },
        ];
        surfaces.exposure = 1.0e30;
        let square = whole(ONCE, |vertex| {
            vertex.normal = [0; 4];
            vertex.tangent = [0; 4];
        });
        let mut scene = scene_of(vec![square], surfaces);
        // So flat that it has no normal.
        scene.objects[0].transform.matrix3.z_axis *= 1.0e-30;
        scene.objects[0].transform.translation.z = -4.0;
        scene.light.sky = [0.0, 0.0, 1.0];
        let found = draw(device, &scene);
        let is_whole = |pixel: &[u8; 4]| pixel[0] == 255 && pixel[3] == 255;
        assert!(found.iter().all(is_whole), "{:?}", found.iter().find(|pixel| !is_whole(pixel)));
    });
}

#[test]
fn colour_finds_every_depth_again() {
    run_on_all(|device| {
        for alpha in [Alpha::Opaque, Alpha::Mask { cutoff: 0.5 }] {
            let material = Material {
                alpha,
                base_colour: [0.7, 0.8, 0.9, 1.0],
                is_unlit: true,
                ..Material::default()
            };
            let cube = tests::shapes::box_scene(&[]).meshes.remove(0);
            let plain = SurfaceVertex {
                normal: [0; 4],
                tangent: [0; 4],
                uv: [[0.0; 2]; 2],
                colour: [u16::MAX; 4],
            };
            let surface =
                SurfaceMesh { vertices: vec![plain; cube.vertices.len()], material: MaterialId(0) };
            let surfaces = Surfaces { materials: vec![material], ..Surfaces::default() };
            let mut scene = scene_of(vec![(cube, surface)], surfaces);
            // Intersecting at all angles, some through the near plane.
            let place = |number: u32| {
                let turn = |step: f32| number as f32 * step;
                Affine3A::from_scale_rotation_translation(
                    Vec3::new(
                        1.0 + turn(0.37) % 2.0,
                        0.3 + turn(0.73) % 1.5,
                        0.5 + turn(0.11) % 3.0,
                    ),
                    Quat::from_euler(EulerRot::XYZ, turn(1.3), turn(2.1), turn(0.7)),
                    Vec3::new(
                        turn(0.9) % 5.0 - 2.5,
                        turn(1.7) % 4.0 - 2.0,
                        -0.5 - turn(0.31) % 6.0,
                    ),
                )
            };
            let object = scene.objects[0];
            scene.objects =
                (0..200).map(|number| Object { transform: place(number), ..object }).collect();
            scene.light.sky = [0.0, 0.0, 1.0];
            let found = draw(device, &scene);
            let expected = reference::encoded(reference::wide([0.7, 0.8, 0.9]));
            let mut drawn = 0;
            for (pixel, found) in found.into_iter().enumerate() {
                if found != [0, 0, 255, 255] {
                    assert_close(found, expected, pixel, "what has a depth has its colour");
                    drawn += 1;
                }
            }
            assert!(drawn > 1000, "{drawn}");
        }
    });
}
