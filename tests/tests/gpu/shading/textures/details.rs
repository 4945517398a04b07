//! Detail textures: normals, roughness and metallic, occlusion, emission.

use glam::{Affine3A, DVec3, Vec3, dvec3};
use gpu::Device;
use scene::{Encoding, LightKind, Material, PunctualLight, Surfaces};
use tests::run_on_all;
use tests::surface_fixture::snorm16;

use super::{
    SHARP, SIDE, assert_close, draw, image, one, reference, scene_of, texture, using, whole,
};

const ONCE: [[f32; 2]; 2] = [[0.0; 2], [1.0; 2]];

fn sun() -> PunctualLight {
    PunctualLight {
        kind: LightKind::Directional,
        colour: [1.0; 3],
        intensity: 2.0,
        range_m: None,
        position: Vec3::ZERO,
        direction: Vec3::new(-0.6, -0.48, -0.64),
        cookie: None,
    }
}

const TOWARDS_SUN: DVec3 = dvec3(0.6, 0.48, 0.64);

/// Returns a matt point in the middle of a pixel.
fn point(pixel: usize) -> reference::ReferencePoint {
    let part = |pixel: usize| (pixel as f64 + 0.5) / f64::from(SIDE / 2) - 1.0;
    let x = part(pixel % SIDE as usize);
    let y = -part(pixel / SIDE as usize);
    reference::ReferencePoint {
        base_colour: DVec3::splat(0.5),
        metallic: 0.0,
        roughness: 1.0,
        occlusion: 1.0,
        emission: DVec3::ZERO,
        position: dvec3(x, y, -1.0) * 4.0,
        normal: DVec3::Z,
    }
}

fn matt() -> Material {
    Material { base_colour: [0.5, 0.5, 0.5, 1.0], metallic: 0.0, ..Material::default() }
}

fn compare(
    found: &[[u8; 4]],
    what: &str,
    ambient: DVec3,
    point_at: impl Fn(usize) -> reference::ReferencePoint,
) {
    let towards = TOWARDS_SUN.normalize();
    let sun = reference::ReferenceLight::Directional { towards, lux: DVec3::splat(2.0) };
    for (pixel, found) in found.iter().enumerate() {
        let light = reference::radiance(&point_at(pixel), DVec3::ZERO, &[sun], &[ambient; 2]);
        assert_close(*found, reference::encoded(reference::tone_mapped(light)), pixel, what);
    }
}

/// Draws a square whose normals come from one texel, under a transform.
fn bumpy(
    device: &Device,
    texel: [u8; 4],
    scale: f32,
    sign: i16,
    transform: Affine3A,
    has_both_sides: bool,
) -> Vec<[u8; 4]> {
    let material = Material { normal_texture: using(0), normal_scale: scale, ..matt() };
    let mut surfaces =
        one(image([1, 1], |_, _| texel), texture(0, Encoding::Linear, SHARP), material);
    surfaces.lights = vec![sun()];
    let (mut mesh, mut surface) = whole(ONCE, |vertex| vertex.tangent = snorm16(Vec3::X, sign));
    // The normal in the world, after the transform.
    let back = transform.inverse();
    for vertex in &mut mesh.vertices {
        vertex.position = back.transform_point3(Vec3::from_array(vertex.position)).to_array();
    }
    mesh.bounds = scene::bounds_of_vertices(&mesh.vertices);
    // A mirror shows the back of a triangle, with all directions reversed.
    let is_back = has_both_sides && transform.matrix3.determinant() < 0.0;
    let side = if is_back { -1 } else { 1 };
    for vertex in &mut surface.vertices {
        let inward = (transform.matrix3.transpose() * Vec3::Z).normalize() * side as f32;
        let along = back.transform_vector3(Vec3::X).normalize() * side as f32;
        vertex.normal = snorm16(inward, i16::from(has_both_sides));
        vertex.tangent = snorm16(along, sign * side);
    }
    let mut scene = scene_of(vec![(mesh, surface)], surfaces);
    scene.objects[0].transform = transform;
    draw(device, &scene)
}

#[test]
fn normals_lean_along_tangent_and_bitangent() {
    run_on_all(|device| {
        // Leaning along +x and a little along +y of tangent space.
        let texel = [218, 166, 217, 255];
        let stored = [218.0, 166.0, 217.0].map(|byte: f64| byte / 255.0 * 2.0 - 1.0);
        for sign in [1, -1] {
            for scale in [1.0, 0.5, -1.0] {
                for mirrored in [1.0, -1.0] {
                    let transform = Affine3A::from_scale(Vec3::new(mirrored, 1.0, 1.0));
                    let found = bumpy(device, texel, scale, sign, transform, false);
                    let both = bumpy(device, texel, scale, sign, transform, true);
                    assert_eq!(found, both, "with both sides, mirrored {mirrored}");
                    let [x, y, z] = stored;
                    let lean = f64::from(scale);
                    // The bitangent belongs to the object, so mirroring the object mirrors the
                    // bitangent.
                    let up = f64::from(sign) * f64::from(mirrored);
                    let normal = dvec3(x * lean, y * lean * up, z).normalize();
                    let what = format!("sign {sign}, scale {scale}, mirrored {mirrored}");
                    compare(&found, &what, DVec3::ZERO, |pixel| reference::ReferencePoint {
                        normal,
                        ..point(pixel)
                    });
                }
            }
        }
    });
}

#[test]
fn roughness_is_green_and_metallic_is_blue() {
    run_on_all(|device| {
        let texel = |x: u32, y: u32| [255, (60 + x * 60) as u8, (y * 80) as u8, 255];
        let material = Material {
            roughness: 0.9,
            metallic: 0.8,
            metallic_roughness_texture: using(0),
            ..matt()
        };
        let mut surfaces = one(image([4, 4], texel), texture(0, Encoding::Linear, SHARP), material);
        surfaces.lights = vec![sun()];
        let found = draw(device, &scene_of(vec![whole(ONCE, |_| {})], surfaces));
        compare(&found, "roughness and metallic", DVec3::ZERO, |pixel| {
            let x = pixel as u32 % SIDE / 16;
            let y = pixel as u32 / SIDE / 16;
            let [_, green, blue, _] = texel(x, y).map(|byte| f64::from(byte) / 255.0);
            let roughness = green * f64::from(0.9_f32);
            let metallic = blue * f64::from(0.8_f32);
            reference::ReferencePoint { roughness, metallic, ..point(pixel) }
        });
    });
}

#[test]
fn occlusion_darkens_ambient_light_alone_by_its_strength() {
    run_on_all(|device| {
        let texel = |x: u32, _| [(x * 80) as u8, 255, 0, 255];
        for strength in [0.0_f32, 0.5, 1.0] {
            let material =
                Material { occlusion_texture: using(0), occlusion_strength: strength, ..matt() };
            let mut surfaces =
                one(image([4, 1], texel), texture(0, Encoding::Linear, SHARP), material);
            surfaces.lights = vec![sun()];
            let mut scene = scene_of(vec![whole(ONCE, |_| {})], surfaces);
            (scene.light.ambient_above, scene.light.ambient_below) = ([0.5; 3], [0.5; 3]);
            let found = draw(device, &scene);
            compare(&found, "occlusion", DVec3::splat(0.5), |pixel| {
                let red = f64::from(texel(pixel as u32 % SIDE / 16, 0)[0]) / 255.0;
                let occlusion = 1.0 + f64::from(strength) * (red - 1.0);
                reference::ReferencePoint { occlusion, ..point(pixel) }
            });
        }
    });
}

#[test]
fn emission_is_added_with_its_strength() {
    run_on_all(|device| {
        let texel = |x: u32, y: u32| [(x * 80) as u8, (y * 80) as u8, 255, 255];
        // Above 1, as KHR_materials_emissive_strength allows.
        let emission = [3.0, 0.5, 0.25];
        let material = Material { emission, emission_texture: using(0), ..matt() };
        let mut surfaces = one(image([4, 4], texel), texture(0, Encoding::Srgb, SHARP), material);
        surfaces.lights = vec![sun()];
        let found = draw(device, &scene_of(vec![whole(ONCE, |_| {})], surfaces));
        compare(&found, "emission", DVec3::ZERO, |pixel| {
            let x = pixel as u32 % SIDE / 16;
            let y = pixel as u32 / SIDE / 16;
            let [red, green, blue, _] = texel(x, y).map(reference::decoded);
            let emission = dvec3(red, green, blue) * reference::wide(emission);
            reference::ReferencePoint { emission, ..point(pixel) }
        });
    });
}

#[test]
fn textures_of_many_kinds_share_pages_and_each_is_found() {
    run_on_all(|device| {
        // Textures of every size: more kinds than pages, so that some are resampled.
        let count = 16;
        let shade = |number: u32| {
            [(number * 15) as u8, 255 - (number * 15) as u8, (number % 4 * 80) as u8, 255]
        };
        let images =
            (0..count).map(|number| image([1 + number, 2], |_, _| shade(number))).collect();
        let textures = (0..count).map(|number| texture(number, Encoding::Srgb, SHARP)).collect();
        let materials = (0..count).map(|number| Material {
            base_colour_texture: using(number),
            is_unlit: true,
            ..Material::default()
        });
        let surfaces =
            Surfaces { images, textures, materials: materials.collect(), ..Surfaces::default() };
        let column = |number: u32| {
            let from = [number * 4, 0];
            let to = [number * 4 + 4, SIDE];
            tests::surface_fixture::quad(SIDE, from, to, 4.0, ONCE, number, |_| {})
        };
        let found = draw(device, &scene_of((0..count).map(column).collect(), surfaces));
        for (pixel, found) in found.into_iter().enumerate() {
            assert_eq!(found, shade(pixel as u32 % SIDE / 4), "{pixel}");
        }
    });
}
