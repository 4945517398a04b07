//! Pictures that spot lights project. Each pixel has the light of the texel on the ray from the
//! lamp, with and without shadows. Pictures are added and removed like textures of materials.

use cull::{Aabb, Camera, Strategy};
use glam::{Vec2, Vec3, vec2, vec3};
use gpu::Device;
use render::{
    CostModel, Error, RenderView, Renderer, RendererOptions, SpareCapacity, TextureCapacity,
};
use scene::{
    Encoding, Filter, Image, ImageId, LightCookie, LightId, LightKind, PreparedTexture,
    PunctualLight, Sampler, Scene, Texture, TextureId,
};
use shadows::{ShadowMethod, ShadowOptions};
use tests::box_rays::hit;
use tests::single_frame::{first_image, image};
use tests::walk::pixels_that_differ;
use tests::{Driver, run, run_on_all, shadow_scene};

const SIZE: [u32; 2] = [160, 120];

/// Texels along a side of the picture.
const TEXELS: u32 = 4;

/// A sampler with sharp texels.
const SHARP: Sampler = Sampler {
    wrap: [scene::Wrap::Clamp; 2],
    magnified: Filter::Nearest,
    minified: Filter::Nearest,
    between_levels: None,
};

/// Returns the colour of a texel, in which each channel is on or off.
fn mask(texel: u32, turned: u32) -> u32 {
    // All rows, columns and diagonals differ.
    [7, 1, 2, 4, 0, 3, 5, 6, 6, 7, 4, 1, 2, 0, 3, 5][((texel + turned * 5) % 16) as usize]
}

fn channels(mask: u32) -> [f32; 3] {
    [0, 1, 2].map(|channel| (mask >> channel & 1) as f32)
}

fn picture_image(turned: u32) -> Image {
    let texel = |texel: u32| {
        let [red, green, blue] = channels(mask(texel, turned)).map(|part| part as u8 * 255);
        [red, green, blue, 255]
    };
    let rgba8 = (0..TEXELS * TEXELS).flat_map(texel).collect();
    Image::of_rgba8("picture", [TEXELS; 2], rgba8)
}

fn spot(texture: u32, up: Vec3) -> PunctualLight {
    PunctualLight {
        kind: LightKind::Spot { inner_rad: 0.5, outer_rad: 0.6 },
        colour: [0.5, 0.4, 0.45],
        intensity: 60.0,
        range_m: Some(30.0),
        position: vec3(1.0, 2.0, 9.0),
        direction: vec3(-0.1, -0.15, -1.0).normalize(),
        cookie: Some(LightCookie { texture: TextureId(texture), up }),
    }
}

/// Returns a wall, and a few boxes in front of it that cast shadows on it.
fn boxes() -> Vec<Aabb> {
    let mut boxes = vec![Aabb::new(vec3(-8.0, -7.0, -0.5), vec3(8.0, 7.0, 0.0))];
    for place in 0..5 {
        let low = vec3(place as f32 * 1.5 - 4.0, place as f32 * 0.6 - 2.0, 1.0);
        boxes.push(Aabb::new(low, low + vec3(0.5, 0.7, 0.4)));
    }
    boxes
}

fn scene(light: PunctualLight) -> Scene {
    let mut scene = shadow_scene::scene(&boxes(), &[light]);
    (scene.light.ambient_above, scene.light.ambient_below) = ([0.02; 3], [0.02; 3]);
    let surfaces = scene.surfaces.as_mut().unwrap();
    surfaces.images = vec![picture_image(0), picture_image(1)];
    let texture =
        |image| Texture { image: ImageId(image), encoding: Encoding::Srgb, sampler: SHARP };
    surfaces.textures = vec![texture(0), texture(1)];
    scene
}

fn camera() -> Camera {
    let eye = vec3(3.0, 1.0, 11.0);
    Camera { eye, forward: (vec3(0.0, 0.2, 0.0) - eye).normalize(), ..shadow_scene::camera() }
}

fn options() -> RendererOptions {
    RendererOptions { size: SIZE, cost_model: CostModel::Off, ..Default::default() }
}

fn shadowed() -> RendererOptions {
    let shadows = ShadowOptions { method: ShadowMethod::Maps, ..ShadowOptions::default() };
    RendererOptions { shadows, ..options() }
}

fn draw(renderer: &mut Renderer, view: &mut RenderView) -> Vec<u8> {
    image(renderer, view, Strategy::ANTUMBRA, camera())
}

fn fresh(device: &Device, light: PunctualLight, options: &RendererOptions) -> Vec<u8> {
    first_image(device, &scene(light), options, camera())
}

/// Returns the visible point at a pixel, if any.
fn seen(renderer: &Renderer, pixel: u32, boxes: &[Aabb]) -> Option<Vec3> {
    let view = renderer.view_of(&camera());
    let at = vec2((pixel % SIZE[0]) as f32 + 0.5, (pixel / SIZE[0]) as f32 + 0.5);
    let ndc = at * 2.0 / Vec2::from(SIZE.map(|side| side as f32)) - 1.0;
    let from = view.rays.origin;
    let to = view.rays.point(ndc, 1.0);
    let towards = to - from;
    let met = boxes.iter().filter_map(|bounds| hit(bounds, from, towards));
    let nearest = met.fold(f32::INFINITY, f32::min);
    nearest.is_finite().then(|| from + towards * nearest)
}

/// Returns the place of a point in a light's picture, from the upper left. The picture stands
/// upright for a view along the light, and the cone touches its sides.
fn place(light: &PunctualLight, up: Vec3, point: Vec3) -> Vec2 {
    let LightKind::Spot { outer_rad, .. } = light.kind else { panic!("a spot") };
    let from_light = point - light.position;
    let up = up.reject_from(light.direction).normalize();
    let right = light.direction.cross(up);
    let reach = from_light.dot(light.direction) * outer_rad.tan();
    vec2(0.5 + 0.5 * from_light.dot(right) / reach, 0.5 - 0.5 * from_light.dot(up) / reach)
}

/// Compares each pixel that is not at the edge of a texel with the image under a light of the
/// texel's colour.
fn check(device: &Device, up: Vec3, options: &RendererOptions) {
    let light = spot(0, up);
    let found = fresh(device, light, options);
    let mut renderer =
        Renderer::new(device, &scene(PunctualLight { cookie: None, ..light }), options).unwrap();
    let mut view = renderer.new_view().unwrap();
    let plain = |mask: u32| {
        let of = light.colour;
        let channels = channels(mask);
        let colour = std::array::from_fn(|part| of[part] * channels[part]);
        let plain = PunctualLight { colour, cookie: None, ..light };
        renderer.set_light(LightId(0), plain).unwrap();
        image(&mut renderer, &mut view, Strategy::FRUSTUM, camera())
    };
    let plain: Vec<Vec<u8>> = (0..8).map(plain).collect();
    let mut compared = [0_u32; 16];
    for pixel in 0..SIZE[0] * SIZE[1] {
        let Some(point) = seen(&renderer, pixel, &boxes()) else { continue };
        let texel = place(&light, up, point) * TEXELS as f32;
        let [x, y] = texel.to_array().map(f32::floor);
        let to_edge = (texel - vec2(x, y)).min(vec2(x, y) + 1.0 - texel).min_element();
        let is_inside = [x, y].iter().all(|side| (0.0..TEXELS as f32).contains(side));
        if to_edge < 0.02 || !is_inside {
            continue;
        }
        let number = y as u32 * TEXELS + x as u32;
        let at = pixel as usize * 4;
        let expected = &plain[mask(number, 0) as usize][at..at + 4];
        assert_eq!(&found[at..at + 4], expected, "pixel {pixel}, texel {number}, up {up}");
        compared[number as usize] += 1;
    }
    assert!(compared.iter().all(|count| *count > 50), "each texel shows: {compared:?}");
}

#[test]
fn pixels_have_the_colour_of_the_texel_that_their_light_goes_through() {
    run_on_all(|device| {
        for up in [Vec3::Y, Vec3::X, vec3(-1.0, -0.4, 3.0)] {
            check(device, up, &options());
        }
        check(device, vec3(0.3, 1.0, 0.0), &shadowed());
    });
}

#[test]
fn a_picture_without_an_upward_direction_is_some_way_round() {
    run_on_all(|device| {
        let light = spot(0, Vec3::Y);
        for up in [Vec3::ZERO, light.direction] {
            let picture = Some(LightCookie { texture: TextureId(0), up });
            let odd = fresh(device, PunctualLight { cookie: picture, ..light }, &options());
            let none = fresh(device, PunctualLight { cookie: None, ..light }, &options());
            assert!(pixels_that_differ(&odd, &none) > 500, "there is a picture");
        }
    });
}

/// Returns spare room for a light, and for two textures of the picture's kind.
fn roomy() -> RendererOptions {
    let room =
        TextureCapacity { size: [TEXELS; 2], encoding: Encoding::Srgb, sampler: SHARP, layers: 2 };
    let spare = SpareCapacity { lights: 1, textures: vec![room], ..SpareCapacity::default() };
    RendererOptions { spare, ..options() }
}

#[test]
fn pictures_come_change_and_go() {
    run_on_all(|device| {
        let mut renderer = Renderer::new(device, &scene(spot(0, Vec3::Y)), &roomy()).unwrap();
        let mut view = renderer.new_view().unwrap();
        let same = |found: &[u8], light, what| {
            let expected = fresh(device, light, &options());
            assert_eq!(pixels_that_differ(found, &expected), 0, "{what}");
        };
        same(&draw(&mut renderer, &mut view), spot(0, Vec3::Y), "as it began");
        renderer.set_light(LightId(0), spot(0, Vec3::X)).unwrap();
        same(&draw(&mut renderer, &mut view), spot(0, Vec3::X), "turned");
        let bare = PunctualLight { cookie: None, ..spot(0, Vec3::Y) };
        renderer.set_light(LightId(0), bare).unwrap();
        same(&draw(&mut renderer, &mut view), bare, "without one");
        let came = PreparedTexture::new(picture_image(1), Encoding::Srgb, SHARP).unwrap();
        let texture = renderer.add_textures(vec![came]).unwrap()[0];
        for _ in 0..4 {
            draw(&mut renderer, &mut view);
        }
        renderer.set_light(LightId(0), spot(texture.0, Vec3::Y)).unwrap();
        let expected = Renderer::new(device, &scene(spot(1, Vec3::Y)), &options());
        let mut expected = expected.unwrap();
        let mut expected_view = expected.new_view().unwrap();
        let expected = draw(&mut expected, &mut expected_view);
        assert_eq!(pixels_that_differ(&draw(&mut renderer, &mut view), &expected), 0, "came later");
        let error = renderer.remove_textures(&[texture]).unwrap_err().to_string();
        assert!(error.contains("lights project it"), "{error}");
        let lights = renderer.add_lights(&[spot(texture.0, Vec3::X)]).unwrap();
        renderer.set_light(LightId(0), bare).unwrap();
        assert!(renderer.remove_textures(&[texture]).is_err(), "the light that came projects it");
        renderer.remove_lights(&lights).unwrap();
        renderer.remove_textures(&[texture]).unwrap();
        let error = renderer.set_light(LightId(0), spot(texture.0, Vec3::Y)).unwrap_err();
        assert!(error.to_string().contains("is not on the GPU"), "{error}");
        same(&draw(&mut renderer, &mut view), bare, "nothing has changed");
    });
}

#[test]
fn pictures_that_cannot_be_are_refused() {
    run(Driver::Lavapipe, |device| {
        let mut renderer = Renderer::new(device, &scene(spot(0, Vec3::Y)), &roomy()).unwrap();
        let bulb = PunctualLight { kind: LightKind::Point, ..spot(0, Vec3::Y) };
        for (light, reason) in [
            (spot(99, Vec3::Y), "does not have the texture"),
            (spot(1, Vec3::Y), "is not on the GPU"),
            (spot(0, Vec3::NAN), "is not finite"),
            (bulb, "only spots"),
        ] {
            let error = renderer.add_lights(&[light]).unwrap_err();
            assert!(matches!(error, Error::LightCookie { index: 0, .. }), "{error:?}");
            assert!(error.to_string().contains(reason), "{error}");
            if light.kind != LightKind::Point {
                let error = renderer.set_light(LightId(0), light).unwrap_err().to_string();
                assert!(error.contains(reason), "{error}");
            }
        }
        let bare = PunctualLight { cookie: None, ..spot(0, Vec3::Y) };
        let mut renderer = Renderer::new(device, &scene(bare), &roomy()).unwrap();
        let error = renderer.set_light(LightId(0), spot(0, Vec3::Y)).unwrap_err().to_string();
        assert!(error.contains("is not on the GPU"), "no light and no material uses it: {error}");
        let mut broken = scene(spot(9, Vec3::Y));
        let error = broken.validate().unwrap_err().to_string();
        assert!(error.contains("light 0") && error.contains("texture of its picture"), "{error}");
        broken.surfaces.as_mut().unwrap().lights = vec![bare];
        broken.validate().unwrap();
    });
}
