//! Textures with an image each: they look the same as textures on pages, keep their size, and
//! arrive while frames are in flight. Runs where there is descriptor indexing: on SwiftShader, and
//! on newer versions of lavapipe than 22.3.

mod arriving;
mod cancelled;

use cull::{Camera, Projection, Strategy};
use glam::{Affine2, Affine3A, Mat2, Vec2, Vec3, vec2, vec3};
use gpu::{Device, DeviceOptions, OptionalFeature};
use render::surfaces::TextureStorage;
use render::{CostModel, Error, Renderer, RendererOptions};
use scene::{
    Alpha, Encoding, Filter, Image, ImageId, LightCookie, LightKind, Material, MeshId, Object,
    PunctualLight, Sampler, Scene, Surfaces, Texture, TextureId, TextureUse, Wrap,
};
use shadows::{ShadowMethod, ShadowOptions};
use tests::fault_injection::FaultInjection;
use tests::shapes::coloured_cubes;
use tests::walk::{ComparedWalk, frame_loop, pixels_that_differ};
use tests::{Driver, instance_with, run_on_all, run_where};

const SIZE: [u32; 2] = [160, 100];
const MATERIALS: u32 = 6;
/// The index of the first texture that holds numbers.
const NUMBERS: u32 = 2;

fn options(textures: Option<TextureStorage>) -> RendererOptions {
    RendererOptions {
        methods: methods::all(),
        size: SIZE,
        cost_model: CostModel::Off,
        textures,
        ..Default::default()
    }
}

/// Returns a pattern of texels, some of which are holes.
fn image(step: u32, side: u32) -> Image {
    let texel = |at: u32| {
        let x = at % side;
        let y = at / side;
        let alpha = if (x / 3 + y / 2 + step).is_multiple_of(3) { 40 } else { 250 };
        [(x * 37 + step * 50) as u8, (y * 29) as u8, (at * step) as u8, alpha]
    };
    let rgba8 = (0..side * side).flat_map(texel).collect();
    Image::of_rgba8(format!("pattern {step}"), [side; 2], rgba8)
}

fn texture(image: u32, encoding: Encoding, sampler: Sampler) -> Texture {
    Texture { image: ImageId(image), encoding, sampler }
}

fn using(texture: u32, transform: Affine2) -> Option<TextureUse> {
    Some(TextureUse { texture: TextureId(texture), uv_set: 0, transform })
}

/// Returns a material with textures of all kinds.
fn material(number: u32) -> Material {
    let turned = Affine2::from_mat2_translation(Mat2::from_angle(0.4) * 1.7, vec2(0.1, 0.3));
    let transform = if number.is_multiple_of(2) { Affine2::IDENTITY } else { turned };
    let plain = Affine2::IDENTITY;
    Material {
        base_colour_texture: using(number % 2, transform),
        metallic_roughness_texture: using(NUMBERS, transform),
        normal_texture: using(NUMBERS + 1, plain),
        occlusion_texture: (number == 3).then_some(using(NUMBERS, plain)).flatten(),
        emission: if number == 4 { [0.2; 3] } else { [0.0; 3] },
        emission_texture: using(1, transform),
        metallic: 0.2,
        alpha: match number % 3 {
            0 => Alpha::Opaque,
            1 => Alpha::Mask { cutoff: 0.5 },
            _ => Alpha::Mask { cutoff: 0.3 },
        },
        ..Material::default()
    }
}

fn object(mesh: u32, low: Vec3, size: Vec3) -> Object {
    let transform = Affine3A::from_scale_rotation_translation(size, glam::Quat::IDENTITY, low);
    Object { mesh: MeshId(mesh), transform, tint: u32::MAX }
}

/// Returns walls with holes, one behind the other, objects between them, glass, and lamps that
/// project a picture.
fn scene() -> Scene {
    let mut objects = Vec::new();
    for wall in 0..5_u32 {
        let z = -4.0 - 3.0 * wall as f32;
        objects.push(object(wall % MATERIALS, vec3(-6.0, -2.0, z), vec3(12.0, 4.0, 0.3)));
        let thing = |number: u32| vec3(number as f32 * 1.2 - 6.0, -0.6, z + 1.4);
        objects.extend(
            (0..10).map(|index| object((index + wall) % MATERIALS, thing(index), Vec3::ONE)),
        );
    }
    let mut scene = coloured_cubes(MATERIALS + 1, objects);
    let surfaces = scene.surfaces.as_mut().unwrap();
    for (mesh, surface) in scene.meshes.iter().zip(&mut surfaces.meshes) {
        for (vertex, surface) in mesh.vertices.iter().zip(&mut surface.vertices) {
            let [x, y, z] = vertex.position;
            surface.uv = [[3.0 * (x + z), 2.0 * (y + 0.5 * z)]; 2];
        }
    }
    let sharp =
        Sampler { magnified: Filter::Nearest, wrap: [Wrap::Mirror; 2], ..Default::default() };
    surfaces.images =
        [16, 16, 16, 32].into_iter().zip(1..).map(|(side, number)| image(number, side)).collect();
    surfaces.textures = vec![
        texture(0, Encoding::Srgb, Sampler::default()),
        texture(1, Encoding::Srgb, sharp),
        texture(2, Encoding::Linear, Sampler::default()),
        texture(3, Encoding::Linear, Sampler::default()),
    ];
    surfaces.materials = (0..MATERIALS).map(material).collect();
    let glass = Material { alpha: Alpha::Blend, base_colour: [0.5, 0.9, 0.7, 0.5], ..material(0) };
    surfaces.materials.push(glass);
    let pane = |number: u32| vec3(number as f32 * 3.0 - 5.0, -1.0, -3.0 - 3.0 * number as f32);
    surfaces.transparent =
        (0..4).map(|index| object(MATERIALS, pane(index), vec3(2.0, 2.0, 0.1))).collect();
    let spot = LightKind::Spot { inner_rad: 0.3, outer_rad: 0.9 };
    let lamp = |number: u32| PunctualLight {
        kind: spot,
        colour: [1.0, 0.8, 0.6],
        intensity: 8.0,
        range_m: None,
        position: vec3(number as f32 * 2.0 - 3.0, 1.0, 0.5 - 3.0 * number as f32),
        direction: vec3(0.1, -0.2, -1.0).normalize(),
        cookie: Some(LightCookie { texture: TextureId(number % 2), up: Vec3::Y }),
    };
    surfaces.lights = (0..3).map(lamp).collect();
    scene
}

fn cameras(count: u32) -> Vec<Camera> {
    let camera = |frame: u32| Camera {
        eye: vec3((frame as f32 * 0.5).sin() * 2.0, 0.2, 1.0 - frame as f32 * 0.3),
        forward: vec3((frame as f32 * 0.9).sin() * 0.2, -0.05, -1.0),
        up: Vec3::Y,
        projection: Projection::perspective(0.9),
        near: 0.1,
    };
    (0..count).map(camera).collect()
}

/// Draws the scene and returns the last image.
fn drawn(device: &Device, scene: &Scene, options: &RendererOptions) -> Vec<u8> {
    let mut renderer = Renderer::new(device, scene, options).unwrap();
    let mut view = renderer.new_view().unwrap();
    let found = frame_loop(&mut renderer, &mut view, Strategy::ANTUMBRA, &cameras(2));
    found.images.last().unwrap().rgba8().unwrap().to_vec()
}

#[test]
fn devices_with_indexing_keep_an_image_for_each_texture_and_others_pages() {
    run_on_all(|device| {
        let scene = scene();
        let renderer = |textures| Renderer::new(device, &scene, &options(textures));
        let stored = |textures| renderer(textures).unwrap().degradations().textures;
        assert_eq!(stored(Some(TextureStorage::ArrayPacked)), TextureStorage::ArrayPacked);
        if device.capabilities().has(OptionalFeature::DescriptorIndexing) {
            assert!(device.adapter().indexed_textures >= 1024);
            assert_eq!(stored(None), TextureStorage::Bindless);
            return;
        }
        assert_eq!(stored(None), TextureStorage::ArrayPacked);
        let error = renderer(Some(TextureStorage::Bindless)).err().unwrap();
        assert!(matches!(error, Error::Gpu(gpu::Error::Unsupported { .. })), "{error}");
        assert!(error.to_string().contains("descriptor indexing"), "{error}");
    });
}

#[test]
fn images_look_as_pages_do_in_all_passes() {
    run_where(OptionalFeature::DescriptorIndexing, |device| {
        let scene = scene();
        let mut shown = Vec::new();
        for method in ShadowMethod::ALL {
            let shadows = ShadowOptions { method, ..ShadowOptions::default() };
            let [pages, images] =
                [TextureStorage::ArrayPacked, TextureStorage::Bindless].map(|textures| {
                    drawn(device, &scene, &RendererOptions { shadows, ..options(Some(textures)) })
                });
            assert_eq!(pixels_that_differ(&pages, &images), 0, "{method:?}");
            shown.push(images);
        }
        // The textures are visible: without them everything looks different.
        let mut bare = scene.clone();
        let surfaces = bare.surfaces.as_mut().unwrap();
        surfaces.materials.iter_mut().for_each(|material| material.base_colour_texture = None);
        let bare = drawn(device, &bare, &options(None));
        assert!(pixels_that_differ(&bare, &shown[0]) > 3000);
        let shadowed = pixels_that_differ(&shown[1], &shown[0]);
        assert!(shadowed > 100, "{shadowed} pixels in shadow");
    });
}

#[test]
fn holes_of_images_are_exact_by_every_strategy() {
    run_where(OptionalFeature::DescriptorIndexing, |device| {
        let scene = scene();
        let cameras = cameras(6);
        let options = options(Some(TextureStorage::Bindless));
        let mut walk = ComparedWalk::new(device, &scene, &cameras, &options);
        for strategy in [
            Strategy::ANTUMBRA,
            Strategy::ANTUMBRA_QUERIES,
            Strategy::ANTUMBRA_FLAGS,
            Strategy::ANTUMBRA_COMPUTE,
            methods::CHC,
            methods::HZB,
        ] {
            let found = walk.with(strategy);
            assert_eq!(found.pixels_wrong, 0, "{strategy}: {found:?}");
        }
    });
}

#[test]
fn one_image_serves_all_textures_that_are_sampled_alike() {
    run_where(OptionalFeature::DescriptorIndexing, |device| {
        let mut scene = scene();
        let before = drawn(device, &scene, &options(Some(TextureStorage::Bindless)));
        // The same textures under other numbers, with some that nothing uses.
        let surfaces = scene.surfaces.as_mut().unwrap();
        let copies = surfaces.textures.clone();
        surfaces.textures.extend(copies);
        for material in surfaces.materials.iter_mut().step_by(2) {
            material.base_colour_texture.as_mut().unwrap().texture.0 += 4;
        }
        let after = drawn(device, &scene, &options(Some(TextureStorage::Bindless)));
        assert_eq!(pixels_that_differ(&before, &after), 0);
    });
}

#[test]
fn a_device_without_indexing_draws_the_same_from_pages() {
    let scene = scene();
    let images = [false, true].map(|has_no_indexing| {
        let faults = FaultInjection { has_no_indexing, ..FaultInjection::default() };
        let instance = instance_with(faults.entry());
        let adapter = instance.pick_adapter(Some(Driver::SwiftShader.device_name())).unwrap();
        let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
        let renderer = Renderer::new(&device, &scene, &options(None)).unwrap();
        let expected =
            if has_no_indexing { TextureStorage::ArrayPacked } else { TextureStorage::Bindless };
        assert_eq!(renderer.degradations().textures, expected);
        drop(renderer);
        let image = drawn(&device, &scene, &options(None));
        drop(device);
        assert_eq!(instance.validation_log().drain(), []);
        image
    });
    assert!(images[0] == images[1]);
}

/// Returns a scene of one square in the picture's middle, with a texture of the given size.
fn one_texture(size: [u32; 2]) -> (Scene, Vec2) {
    let mut scene = coloured_cubes(1, vec![object(0, vec3(-1.0, -1.0, -9.0), Vec3::splat(2.0))]);
    let surfaces: &mut Surfaces = scene.surfaces.as_mut().unwrap();
    let rgba8 = [10, 200, 30, 255].repeat((size[0] * size[1]) as usize);
    surfaces.images = vec![Image::of_rgba8("one", size, rgba8)];
    surfaces.textures = vec![texture(0, Encoding::Srgb, Sampler::default())];
    surfaces.materials = vec![Material {
        base_colour_texture: using(0, Affine2::IDENTITY),
        is_unlit: true,
        ..Material::default()
    }];
    (scene, Vec2::from_array(size.map(|side| side as f32)))
}

#[test]
fn only_what_is_larger_than_the_device_takes_is_shrunk() {
    run_where(OptionalFeature::DescriptorIndexing, |device| {
        let most = device.adapter().limits.max_image_dimension2_d;
        for (size, shrunk) in [([most, 1], 0), ([most + 1, 1], 1)] {
            let (scene, _) = one_texture(size);
            let renderer = Renderer::new(device, &scene, &options(None)).unwrap();
            let found = renderer.degradations();
            assert_eq!((found.shrunk_images, found.enlarged_images), (shrunk, 0), "{size:?}");
            let texts = found.texts();
            assert_eq!(texts.len(), shrunk, "{texts:?}");
            assert!(texts.iter().all(|text| text.contains("the device takes no larger ones")));
        }
    });
}
