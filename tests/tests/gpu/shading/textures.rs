//! Textures of the surface pass: every pixel shows the texel that the specification requires,
//! correctly lit.

mod arrays;
mod blocks;
mod covering;
mod details;

use glam::{Affine2, Affine3A, Mat2, Vec2, vec2};
use gpu::Device;
use render::surfaces::SurfaceOptions;
use scene::{
    Encoding, Filter, Image, ImageId, Material, Mesh, Sampler, Scene, SurfaceMesh, SurfaceVertex,
    Surfaces, Texture, TextureId, TextureUse, Wrap,
};
use tests::reference;
use tests::run_on_all;
use tests::shapes::square_camera;
use tests::surface_fixture;

/// The side of the images in pixels.
const SIDE: u32 = 64;

/// A sampler that shows one texel per pixel, without filtering.
const SHARP: Sampler = Sampler {
    wrap: [Wrap::Repeat; 2],
    magnified: Filter::Nearest,
    minified: Filter::Nearest,
    between_levels: None,
};

fn image(size: [u32; 2], texel: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let rgba8 = pixels.flat_map(|(x, y)| texel(x, y)).collect();
    Image::of_rgba8("test", size, rgba8)
}

/// Returns texels that are all different, in every channel.
fn distinct(x: u32, y: u32) -> [u8; 4] {
    [(40 + 50 * x) as u8, (30 + 50 * y) as u8, (200 - 20 * x - 10 * y) as u8, 255]
}

fn texture(image: u32, encoding: Encoding, sampler: Sampler) -> Texture {
    Texture { image: ImageId(image), encoding, sampler }
}

fn using(texture: u32) -> Option<TextureUse> {
    Some(TextureUse { texture: TextureId(texture), uv_set: 0, transform: Affine2::IDENTITY })
}

/// Returns a material that shows only its texels.
fn unlit() -> Material {
    Material { base_colour_texture: using(0), is_unlit: true, ..Material::default() }
}

/// Returns surfaces of one image, one texture and one material.
fn one(image: Image, texture: Texture, material: Material) -> Surfaces {
    Surfaces {
        images: vec![image],
        textures: vec![texture],
        materials: vec![material],
        ..Surfaces::default()
    }
}

/// Returns a square over the whole image.
fn whole(uv: [[f32; 2]; 2], change: impl Fn(&mut SurfaceVertex)) -> (Mesh, SurfaceMesh) {
    surface_fixture::quad(SIDE, [0, 0], [SIDE, SIDE], 4.0, uv, 0, change)
}

fn scene_of(meshes: Vec<(Mesh, SurfaceMesh)>, surfaces: Surfaces) -> Scene {
    let places = vec![Affine3A::IDENTITY; meshes.len()];
    surface_fixture::scene(meshes, &places, surfaces)
}

fn draw(device: &Device, scene: &Scene) -> Vec<[u8; 4]> {
    draw_with(device, scene, &SurfaceOptions::default())
}

fn draw_with(device: &Device, scene: &Scene, options: &SurfaceOptions) -> Vec<[u8; 4]> {
    let image = surface_fixture::image(device, scene, &square_camera(), [SIDE; 2], options);
    image.chunks_exact(4).map(|pixel| pixel.try_into().unwrap()).collect()
}

/// Returns the texture coordinates at the middle of a pixel of a [`whole`] square.
fn at(pixel: usize, uv: [[f32; 2]; 2]) -> Vec2 {
    let part = |pixel: usize| (pixel as f32 + 0.5) / SIDE as f32;
    let share = vec2(part(pixel % SIDE as usize), part(pixel / SIDE as usize));
    let [from, to] = uv.map(Vec2::from_array);
    from + (to - from) * share
}

/// Returns the texel of an image of `size` at texture coordinates, without filtering.
fn texel_at(uv: Vec2, size: u32, wrap: [Wrap; 2]) -> [u32; 2] {
    std::array::from_fn(|side| {
        let texel = (uv[side] * size as f32).floor() as i32;
        let size = size as i32;
        let texel = match wrap[side] {
            Wrap::Repeat => texel.rem_euclid(size),
            Wrap::Clamp => texel.clamp(0, size - 1),
            Wrap::Mirror => {
                let turned = texel.rem_euclid(2 * size);
                if turned < size { turned } else { 2 * size - 1 - turned }
            }
        };
        texel as u32
    })
}

fn assert_close(found: [u8; 4], expected: [f64; 3], pixel: usize, what: &str) {
    for (found, expected) in found.into_iter().zip(expected) {
        let difference = (f64::from(found) - expected).abs();
        assert!(
            difference <= 2.0,
            "{what} at {}, {}: {found} is not {expected}",
            pixel % 64,
            pixel / 64
        );
    }
}

#[test]
fn edges_wrap_each_way_along_each_axis() {
    run_on_all(|device| {
        let uv = [[-1.5, -1.25], [2.5, 2.75]];
        for across in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for down in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                let sampler = Sampler { wrap: [across, down], ..SHARP };
                let surfaces =
                    one(image([4, 4], distinct), texture(0, Encoding::Srgb, sampler), unlit());
                let found = draw(device, &scene_of(vec![whole(uv, |_| {})], surfaces));
                for (pixel, found) in found.into_iter().enumerate() {
                    let [x, y] = texel_at(at(pixel, uv), 4, sampler.wrap);
                    assert_eq!(found, distinct(x, y), "{across:?} {down:?} at {pixel}");
                }
            }
        }
    });
}

#[test]
fn textures_follow_the_set_and_the_transform_that_they_name() {
    run_on_all(|device| {
        let first = [[0.0, 0.0], [1.0, 1.0]];
        let second = [[0.25, 0.5], [2.25, 1.0]];
        // As in KHR_texture_transform: offset, rotation, scale.
        let (sin, cos) = 0.5_f32.sin_cos();
        let rotation = Mat2::from_cols(vec2(cos, -sin), vec2(sin, cos));
        let scale = Mat2::from_diagonal(vec2(1.5, -0.75));
        let transform = Affine2::from_mat2_translation(rotation * scale, vec2(0.3, -0.6));
        for (uv_set, transform) in
            [(0, Affine2::IDENTITY), (1, Affine2::IDENTITY), (0, transform), (1, transform)]
        {
            let used = TextureUse { texture: TextureId(0), uv_set, transform };
            let material = Material { base_colour_texture: Some(used), ..unlit() };
            let surfaces =
                one(image([4, 4], distinct), texture(0, Encoding::Srgb, SHARP), material);
            let square = whole(first, |vertex| {
                let [u, v] = vertex.uv[0];
                vertex.uv[1] = [0.25 + 2.0 * u, 0.5 + 0.5 * v];
            });
            let found = draw(device, &scene_of(vec![square], surfaces));
            for (pixel, found) in found.into_iter().enumerate() {
                let uv =
                    transform.transform_point2(at(pixel, [first, second][usize::from(uv_set)]));
                // On an edge of texels rounding decides.
                let is_edge = (uv * 4.0 - (uv * 4.0).round()).abs().min_element() < 1e-3;
                let [x, y] = texel_at(uv, 4, SHARP.wrap);
                assert!(
                    is_edge || found == distinct(x, y),
                    "set {uv_set}, {transform:?} at {pixel}: {found:?}"
                );
            }
        }
    });
}

#[test]
fn colours_are_srgb_and_numbers_are_not() {
    run_on_all(|device| {
        let shade = |x: u32, _| [(x * 17) as u8, (x * 11) as u8, 255 - (x * 17) as u8, 255];
        for encoding in [Encoding::Srgb, Encoding::Linear] {
            let surfaces = one(image([16, 1], shade), texture(0, encoding, SHARP), unlit());
            let found =
                draw(device, &scene_of(vec![whole([[0.0; 2], [1.0; 2]], |_| {})], surfaces));
            for (pixel, found) in found.into_iter().enumerate() {
                let texel = shade(pixel as u32 % SIDE / 4, 0);
                if encoding == Encoding::Srgb {
                    assert_eq!(found, texel);
                    continue;
                }
                let light =
                    reference::wide([0, 1, 2].map(|channel| f32::from(texel[channel]) / 255.0));
                assert_close(found, reference::encoded(light), pixel, "linear");
            }
        }
    });
}

#[test]
fn what_is_enlarged_is_mixed_in_linear_light() {
    run_on_all(|device| {
        let sampler = Sampler { magnified: Filter::Linear, wrap: [Wrap::Clamp; 2], ..SHARP };
        let shade = |x: u32, _| if x == 0 { [255, 0, 20, 255] } else { [0, 255, 200, 255] };
        let surfaces = one(image([2, 1], shade), texture(0, Encoding::Srgb, sampler), unlit());
        let found = draw(device, &scene_of(vec![whole([[0.0; 2], [1.0; 2]], |_| {})], surfaces));
        let light = |texel: [u8; 4]| {
            glam::DVec3::from_array([0, 1, 2].map(|channel| reference::decoded(texel[channel])))
        };
        for (pixel, found) in found.into_iter().enumerate() {
            let u = f64::from(at(pixel, [[0.0; 2], [1.0; 2]]).x);
            let share = (u * 2.0 - 0.5).clamp(0.0, 1.0);
            let mixed = light(shade(0, 0)) * (1.0 - share) + light(shade(1, 0)) * share;
            assert_close(found, reference::encoded(mixed), pixel, "enlarged");
        }
    });
}

#[test]
fn vertex_colours_and_factors_multiply_texels() {
    run_on_all(|device| {
        let material = Material { base_colour: [0.5, 0.25, 1.0, 1.0], ..unlit() };
        let surfaces = one(
            image([1, 1], |_, _| [200, 220, 240, 255]),
            texture(0, Encoding::Srgb, SHARP),
            material,
        );
        let square = whole([[0.0; 2], [1.0; 2]], |vertex| {
            vertex.colour = [u16::MAX, 32768, 16384, u16::MAX]
        });
        let found = draw(device, &scene_of(vec![square], surfaces));
        let light = [0.5, 0.25 * 32768.0 / 65535.0, 16384.0 / 65535.0];
        let light = std::array::from_fn(|channel| {
            light[channel] * reference::decoded([200, 220, 240][channel])
        });
        for (pixel, found) in found.into_iter().enumerate() {
            assert_close(
                found,
                reference::encoded(glam::DVec3::from_array(light)),
                pixel,
                "factors",
            );
        }
    });
}
