//! Scenes beyond the hard limits of a renderer are refused, with the name, the limit and the
//! remedy. Scenes beyond its soft limits are drawn, and the report lists what is missing.

use cull::{Camera, ObjectId, Projection, Strategy};
use glam::{Affine2, Affine3A, Vec2, Vec3, vec3};
use gpu::{Device, OptionalFeature, Readback};
use render::surfaces::TextureStorage;
use render::{Error, FrameRequest, RenderView, Renderer, RendererOptions, SceneDegradations};
use scene::limits::{
    MAX_LIGHTS, MAX_LIGHTS_PER_OBJECT, MAX_OWN_IMAGES, MAX_PAGES, MAX_TEXTURE_TRANSFORMS,
};
use scene::{
    Encoding, Image, ImageId, LightId, LightKind, Material, MaterialId, MeshId, Object,
    ObjectChange, PunctualLight, Sampler, Scene, Surfaces, Texture, TextureId, TextureUse,
};
use tests::shapes::coloured_cubes;
use tests::{Driver, run, run_on_all, run_where};

const SIZE: [u32; 2] = [64, 36];

fn cubes(count: u32) -> Scene {
    let place = |number: u32| Affine3A::from_translation(vec3(number as f32 * 3.0, 0.0, 0.0));
    let object = |number| Object { mesh: MeshId(0), transform: place(number), tint: u32::MAX };
    coloured_cubes(1, (0..count).map(object).collect())
}

fn with(change: impl FnOnce(&mut Surfaces)) -> Scene {
    let mut scene = cubes(3);
    change(scene.surfaces.as_mut().unwrap());
    scene
}

fn renderer(device: &Device, scene: &Scene) -> Result<Renderer, Error> {
    stored(device, scene, TextureStorage::ArrayPacked)
}

fn stored(device: &Device, scene: &Scene, textures: TextureStorage) -> Result<Renderer, Error> {
    let textures = Some(textures);
    Renderer::new(device, scene, &RendererOptions { size: SIZE, textures, ..Default::default() })
}

fn lamp(position: Vec3) -> PunctualLight {
    PunctualLight {
        kind: LightKind::Point,
        colour: [1.0; 3],
        intensity: 1.0,
        range_m: Some(1.5),
        position,
        direction: Vec3::NEG_Z,
        cookie: None,
    }
}

fn textured(texture: u32, transform: Affine2) -> Material {
    let texture_use = TextureUse { texture: TextureId(texture), uv_set: 0, transform };
    Material { base_colour_texture: Some(texture_use), is_unlit: true, ..Material::default() }
}

fn image(size: [u32; 2], texel: [u8; 4]) -> Image {
    let pixels = (size[0] * size[1]) as usize;
    Image::of_rgba8("an image", size, texel.repeat(pixels))
}

fn look(image: u32) -> Texture {
    Texture { image: ImageId(image), encoding: Encoding::Srgb, sampler: Sampler::default() }
}

#[test]
fn what_is_too_much_is_refused_by_name() {
    run_on_all(|device| {
        let lights =
            |count| with(|surfaces| surfaces.lights = vec![lamp(Vec3::splat(1.0e6)); count]);
        let transforms = |count: usize| {
            with(|surfaces| {
                surfaces.images = vec![image([1, 1], [255; 4])];
                surfaces.textures = vec![look(0)];
                let shift =
                    |number: usize| Affine2::from_translation(Vec2::X * (number + 1) as f32);
                surfaces.materials = (0..count).map(|number| textured(0, shift(number))).collect();
            })
        };
        let layers = device.adapter().limits.max_image_array_layers.min(2048) as usize;
        let most_images = MAX_PAGES * layers;
        let images = |count: usize| {
            with(|surfaces| {
                surfaces.images = vec![image([1, 1], [255; 4]); count];
                surfaces.textures = (0..count as u32).map(look).collect();
                let all = 0..count as u32;
                surfaces.materials =
                    all.map(|number| textured(number, Affine2::IDENTITY)).collect();
            })
        };
        let refused = |scene: Scene, count: usize, named: &str| {
            let Err(error) = renderer(device, &scene) else { panic!("{named} are accepted") };
            let text = error.to_string();
            let Error::SceneTooLarge { wanted, limit, .. } = error else { panic!("{text}") };
            assert_eq!((wanted, limit), (count as u64 + 1, count as u64), "{text}");
            assert!(text.contains(named) && text.contains(": "), "{text}");
        };
        refused(lights(MAX_LIGHTS + 1), MAX_LIGHTS, "lights");
        refused(transforms(MAX_TEXTURE_TRANSFORMS + 1), MAX_TEXTURE_TRANSFORMS, "transforms");
        refused(images(most_images + 1), most_images, "images");
        assert!(renderer(device, &lights(MAX_LIGHTS)).is_ok());
        assert!(renderer(device, &transforms(MAX_TEXTURE_TRANSFORMS)).is_ok());
    });
}

fn draw(renderer: &mut Renderer, view: &mut RenderView, eye: Vec3) -> Readback {
    let image = Readback::new(renderer.device(), SIZE).unwrap();
    let camera = Camera {
        eye,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::perspective(0.3),
        near: 0.05,
    };
    let request =
        FrameRequest { image: Some(&image), ..FrameRequest::new(Strategy::ANTUMBRA, camera) };
    renderer.render(view, request).unwrap();
    renderer.wait_idle(view).unwrap();
    image
}

#[test]
fn objects_that_too_many_lamps_reach_are_counted_as_things_are_now() {
    run_on_all(|device| {
        let most = MAX_LIGHTS_PER_OBJECT as u32;
        let scene = with(|surfaces| {
            // The first object gets one light too many, the second the maximum, the third none.
            let at = |number: u32| lamp(vec3(if number > most { 3.5 } else { 0.5 }, 0.5, 1.2));
            surfaces.lights = (0..=2 * most).map(at).collect();
            let sun = PunctualLight { kind: LightKind::Directional, ..lamp(Vec3::ZERO) };
            surfaces.lights.extend([sun; 6]);
        });
        let mut renderer = renderer(device, &scene).unwrap();
        let mut view = renderer.new_view().unwrap();
        let counted = |renderer: &Renderer| {
            let SceneDegradations { crowded_objects, dark_suns, .. } = renderer.degradations();
            assert_eq!(dark_suns, 2);
            crowded_objects
        };
        assert_eq!(counted(&renderer), 1);
        assert_eq!(renderer.degradations().texts().len(), 2);
        let mut show = |renderer: &mut Renderer| {
            draw(renderer, &mut view, vec3(1.0, 1.0, 20.0));
            counted(renderer)
        };
        renderer.set_light(LightId(0), lamp(vec3(3.5, 0.5, 1.2))).unwrap();
        assert_eq!(show(&mut renderer), 1, "now the second");
        renderer.set_light(LightId(1), lamp(Vec3::splat(500.0))).unwrap();
        let transform = Affine3A::from_translation(vec3(3.0, 0.2, 0.0));
        renderer.update(&[ObjectChange::Move { object: ObjectId(2), transform }]).unwrap();
        assert_eq!(show(&mut renderer), 2, "the second and the third");
        renderer.update(&[ObjectChange::Remove { object: ObjectId(2) }]).unwrap();
        assert_eq!(show(&mut renderer), 1, "one is gone");
        renderer.set_light(LightId(0), lamp(Vec3::splat(-500.0))).unwrap();
        assert_eq!(show(&mut renderer), 0);
    });
}

#[test]
fn more_textures_than_have_numbers_are_refused_before_any_is_made() {
    run_where(OptionalFeature::DescriptorIndexing, |device| {
        let most = MAX_OWN_IMAGES;
        let scene = with(|surfaces| {
            surfaces.images = vec![image([1, 1], [255; 4]); most as usize + 1];
            surfaces.textures = (0..=most).map(look).collect();
            surfaces.materials =
                (0..=most).map(|index| textured(index, Affine2::IDENTITY)).collect();
        });
        let error = stored(device, &scene, TextureStorage::Bindless).err().unwrap().to_string();
        let says = |part: &str| assert!(error.contains(part), "{error}");
        says(&(most + 1).to_string());
        says("textures with an image each");
        says("TextureStorage::ArrayPacked");
    });
}

#[test]
fn images_of_hundreds_of_sizes_show_their_colours() {
    for driver in Driver::ALL {
        run(driver, |device| show_hundreds_of_sizes(device, TextureStorage::ArrayPacked));
    }
    run_where(OptionalFeature::DescriptorIndexing, |device| {
        show_hundreds_of_sizes(device, TextureStorage::Bindless);
    });
}

fn show_hundreds_of_sizes(device: &Device, textures: TextureStorage) {
    const COUNT: u32 = 300;
    let colour = |number: u32| [(number % 16 * 16) as u8, (number / 16 * 12) as u8, 77, 255];
    let mut scene = cubes(COUNT);
    let surfaces = scene.surfaces.as_mut().unwrap();
    let size = |number: u32| [1 + number % 20 * 3, 1 + number / 20 * 5];
    surfaces.images = (0..COUNT).map(|index| image(size(index), colour(index))).collect();
    surfaces.textures = (0..COUNT).map(look).collect();
    surfaces.materials = (0..COUNT).map(|index| textured(index, Affine2::IDENTITY)).collect();
    let mesh = scene.meshes[0].clone();
    let mut surface = surfaces.meshes[0].clone();
    surface.vertices.iter_mut().for_each(|vertex| vertex.colour = [u16::MAX; 4]);
    scene.meshes = vec![mesh; COUNT as usize];
    let of = |material| scene::SurfaceMesh { material, ..surface.clone() };
    surfaces.meshes = (0..COUNT).map(|index| of(MaterialId(index))).collect();
    for (mesh, object) in (0..).zip(&mut scene.objects) {
        object.mesh = MeshId(mesh);
    }
    let mut renderer = stored(device, &scene, textures).unwrap();
    let mut view = renderer.new_view().unwrap();
    let found = renderer.degradations();
    assert_eq!(found.textures, textures);
    let SceneDegradations { shrunk_images, enlarged_images, .. } = found;
    let are_shared = textures == TextureStorage::ArrayPacked;
    assert_eq!((shrunk_images, enlarged_images > 200), (0, are_shared), "{enlarged_images}");
    assert_eq!(enlarged_images > 0, are_shared);
    for number in (0..COUNT).step_by(13) {
        let eye = vec3(number as f32 * 3.0 + 0.5, 0.5, 4.0);
        let image = draw(&mut renderer, &mut view, eye);
        let middle = ((SIZE[0] * SIZE[1] / 2 + SIZE[0] / 2) * 4) as usize;
        let pixels = image.rgba8().unwrap();
        let found = &pixels[middle..middle + 4];
        let is_close = found.iter().zip(colour(number)).all(|(a, b)| a.abs_diff(b) <= 2);
        assert!(is_close, "{number}: {found:?}, {:?}", colour(number));
    }
}
