//! Environment light: surfaces and sky against a reference on the CPU, and impossible environments.

use cull::{Camera, Strategy};
use glam::{Vec3, vec3};
use gpu::{Device, Readback};
use render::{CostModel, Error, FrameRequest, Renderer, RendererOptions};
use scene::{
    Environment, Light, LightKind, Material, Panorama, PunctualLight, Scene, Sky, SkyDisk,
};
use shadows::{ShadowMethod, ShadowOptions};
use tests::reference::{decoded, encoded, tone_mapped};
use tests::{run_on_all, shadow_scene, shapes};

const SIZE: [u32; 2] = [64, 48];

fn sky() -> Sky {
    Sky {
        towards_sun: vec3(0.4, 0.6, 0.3).normalize(),
        zenith: [0.1, 0.25, 0.6],
        horizon: [0.5, 0.55, 0.6],
        ground: [0.12, 0.1, 0.08],
        glow: [0.5, 0.4, 0.2],
    }
}

/// Returns a floor of a material under an environment, without other light.
fn floor(material: Material, environment: Option<Environment>) -> Scene {
    let mut scene = shadow_scene::scene(&[shadow_scene::GROUND], &[]);
    let surfaces = scene.surfaces.as_mut().unwrap();
    surfaces.materials = vec![material];
    surfaces.environment = environment;
    scene.light = Light { ambient_above: [0.0; 3], ambient_below: [0.0; 3], ..Light::afternoon() };
    scene
}

fn renderer(device: &Device, scene: &Scene) -> Renderer {
    let options = RendererOptions { size: SIZE, cost_model: CostModel::Off, ..Default::default() };
    Renderer::new(device, scene, &options).unwrap()
}

fn image(renderer: &mut Renderer, strategy: Strategy, camera: Camera) -> Vec<u8> {
    let mut view = renderer.new_view().unwrap();
    let image = Readback::new(renderer.device(), SIZE).unwrap();
    let request = FrameRequest { image: Some(&image), ..FrameRequest::new(strategy, camera) };
    renderer.render(&mut view, request).unwrap();
    renderer.wait_idle(&mut view).unwrap();
    image.rgba8().unwrap().to_vec()
}

/// Returns the direction of a pixel from the eye.
fn direction(camera: &Camera, x: u32, y: u32) -> Vec3 {
    let half = 0.5_f32.tan();
    let right = camera.forward.cross(camera.up).normalize();
    let up = right.cross(camera.forward);
    let aspect = SIZE[0] as f32 / SIZE[1] as f32;
    let across = ((x as f32 + 0.5) / SIZE[0] as f32 * 2.0 - 1.0) * half * aspect;
    let down = ((y as f32 + 0.5) / SIZE[1] as f32 * 2.0 - 1.0) * half;
    (camera.forward + right * across - up * down).normalize()
}

fn bytes(light: Vec3) -> [f64; 3] {
    encoded(tone_mapped(light.as_dvec3()))
}

fn pixel(image: &[u8], x: u32, y: u32) -> [f64; 3] {
    let at = ((y * SIZE[0] + x) * 4) as usize;
    [0, 1, 2].map(|channel| f64::from(image[at + channel]))
}

fn assert_near(found: [f64; 3], expected: [f64; 3], place: &str) {
    for channel in 0..3 {
        let error = (found[channel] - expected[channel]).abs();
        assert!(error < 2.5, "{place}: {found:?} and not {expected:?}");
    }
}

#[test]
fn the_sky_and_matt_and_metal_floors_are_those_of_the_reference() {
    run_on_all(|device| {
        let environment = Environment::of_sky(&sky()).unwrap();
        let camera = Camera {
            eye: vec3(0.0, 2.0, 3.0),
            forward: vec3(0.3, -0.2, -1.0).normalize(),
            ..shadow_scene::camera()
        };
        let matt =
            Material { metallic: 0.0, base_colour: [0.5, 0.4, 0.3, 1.0], ..Material::default() };
        let metal = Material { metallic: 1.0, roughness: 0.3, ..matt.clone() };
        for material in [matt, metal] {
            let scene = floor(material.clone(), Some(environment.clone()));
            let image = image(&mut renderer(device, &scene), Strategy::ANTUMBRA, camera);
            let mut above = 0;
            let mut below = 0;
            for y in 0..SIZE[1] {
                for x in 0..SIZE[0] {
                    let towards = direction(&camera, x, y);
                    let place = format!("{x}, {y}");
                    let found = pixel(&image, x, y);
                    if towards.y > 0.02 {
                        above += 1;
                        assert_near(found, bytes(sky().radiance(towards)), &place);
                    }
                    let hit = camera.eye - towards * (camera.eye.y / towards.y);
                    if towards.y < -0.1 && hit.abs().max_element() < 15.0 {
                        below += 1;
                        assert_near(
                            found,
                            bytes(floor_light(&environment, &material, towards)),
                            &place,
                        );
                    }
                }
            }
            assert!(above > 500 && below > 500, "{above}, {below}");
        }
    });
}

/// Returns the light of the floor in a direction from the eye.
fn floor_light(environment: &Environment, material: &Material, towards: Vec3) -> Vec3 {
    let [red, green, blue, _] = material.base_colour;
    let base = vec3(red, green, blue);
    let metallic = material.metallic;
    let roughness = material.roughness;
    let diffuse = base * (1.0 - metallic);
    let specular = Vec3::splat(0.04).lerp(base, metallic);
    let n_v = -towards.y;
    let r = [
        1.0 - roughness,
        0.0425 - 0.0275 * roughness,
        1.04 - 0.572 * roughness,
        0.022 * roughness - 0.04,
    ];
    let edge = (r[0] * r[0]).min((-9.28 * n_v).exp2()) * r[0] + r[1];
    let scale = r[2] - 1.04 * edge;
    let offset = r[3] + 1.04 * edge;
    let mirrored = environment.glossy(vec3(towards.x, -towards.y, towards.z), roughness);
    diffuse * environment.matt(Vec3::Y) + mirrored * (specular * scale + offset)
}

#[test]
fn a_disk_is_where_it_should_be_and_as_large() {
    run_on_all(|device| {
        let plain = Environment::of_sky(&sky()).unwrap();
        let camera =
            Camera { eye: vec3(0.0, 2.0, 3.0), forward: Vec3::NEG_Z, ..shadow_scene::camera() };
        let towards = direction(&camera, 40, 12);
        let disk = SkyDisk { towards, radius_rad: 0.06, radiance: [0.2, 0.9, 0.4] };
        let environment = plain.clone().with_disk(disk).unwrap();
        let material = Material::default();
        let scenes = [plain, environment].map(|light| floor(material.clone(), Some(light)));
        let [plain, found] =
            scenes.map(|scene| image(&mut renderer(device, &scene), Strategy::ANTUMBRA, camera));
        let mut inside = 0;
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let seen = direction(&camera, x, y);
                let away = seen.angle_between(towards);
                if seen.y < 0.02 || away > disk.radius_rad {
                    assert_eq!(pixel(&found, x, y), pixel(&plain, x, y), "{x}, {y}");
                } else if away < 0.8 * disk.radius_rad {
                    inside += 1;
                    let light = sky().radiance(seen) + Vec3::from_array(disk.radiance);
                    assert_near(pixel(&found, x, y), bytes(light), &format!("{x}, {y}"));
                }
            }
        }
        assert!(inside > 10, "{inside}");
    });
}

/// Returns a camera far beside the floor, which sees only the environment.
fn outside() -> Camera {
    let forward = vec3(0.3, 0.1, -1.0).normalize();
    Camera { eye: vec3(0.0, 50.0, -500.0), forward, ..shadow_scene::camera() }
}

/// Compares with the sky itself, since an image of 64 by 64 texels would show beads along the
/// horizon.
#[test]
fn a_sky_is_computed_for_each_pixel() {
    run_on_all(|device| {
        let scene = floor(Material::default(), Some(Environment::of_sky(&sky()).unwrap()));
        let image = image(&mut renderer(device, &scene), Strategy::ANTUMBRA, outside());
        let expected = |x, y| bytes(sky().radiance(direction(&outside(), x, y)));
        for (x, y) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))) {
            let found = pixel(&image, x, y);
            let expected = expected(x, y);
            // Rounding removes half a step, and half a step was added.
            let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1.1);
            assert!(is_near, "{x}, {y}: {found:?} and not {expected:?}");
        }
    });
}

#[test]
fn what_lies_between_two_codes_is_dithered() {
    run_on_all(|device| {
        let light = [0.203, 0.3, 0.4];
        let dark = [0.0; 3];
        let same = Sky { zenith: light, horizon: light, ground: light, glow: dark, ..sky() };
        let scene = floor(Material::default(), Some(Environment::of_sky(&same).unwrap()));
        let image = image(&mut renderer(device, &scene), Strategy::ANTUMBRA, outside());
        for tile in 0..SIZE[0] / 8 * (SIZE[1] / 8) {
            let left = tile % (SIZE[0] / 8) * 8;
            let top = tile / (SIZE[0] / 8) * 8;
            let pixels = (0..64).map(|place| pixel(&image, left + place % 8, top + place / 8));
            let mut mean = [0.0; 3];
            for pixel in pixels {
                mean.iter_mut().zip(pixel).for_each(|(mean, code)| *mean += code / 64.0);
            }
            for (mean, expected) in mean.into_iter().zip(bytes(Vec3::from_array(light))) {
                assert!((mean - expected).abs() < 0.15, "tile {tile}: {mean} and not {expected}");
            }
        }
    });
}

#[test]
fn a_panorama_is_seen_with_its_own_pixels_and_smooth_where_they_are_too_small() {
    run_on_all(|device| {
        let stripes = |width: u32| -> Vec<[f32; 3]> {
            let light = |x: u32| if (x / 2).is_multiple_of(2) { [0.1, 0.5, 0.3] } else { [0.3; 3] };
            (0..width * width / 2).map(|pixel| light(pixel % width)).collect()
        };
        let drawn = |environment: Environment| {
            let scene = floor(Material::default(), Some(environment));
            image(&mut renderer(device, &scene), Strategy::ANTUMBRA, outside())
        };
        let coarse = Panorama::new([128, 64], &stripes(128)).unwrap();
        let found = drawn(Environment::of_equirectangular([128, 64], &stripes(128)).unwrap());
        let fine = drawn(Environment::of_equirectangular([2048, 1024], &stripes(2048)).unwrap());
        for (x, y) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))) {
            let place = format!("{x}, {y}");
            let expected = coarse.radiance(direction(&outside(), x, y));
            assert_near(pixel(&found, x, y), bytes(expected), &place);
            assert_near(pixel(&fine, x, y), bytes(vec3(0.2, 0.4, 0.3)), &place);
        }
    });
}

#[test]
fn culling_and_shadows_change_nothing_about_it() {
    run_on_all(|device| {
        let mut scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let surfaces = scene.surfaces.as_mut().unwrap();
        surfaces.environment = Some(Environment::of_sky(&sky()).unwrap());
        surfaces.lights.retain(|light: &PunctualLight| light.kind == LightKind::Directional);
        let mut renderer = renderer(device, &scene);
        for method in [ShadowMethod::Off, ShadowMethod::Maps] {
            let options = ShadowOptions { method, sun_side: 256, ..ShadowOptions::default() };
            renderer.set_shadows(options).unwrap();
            let all = image(&mut renderer, Strategy::FRUSTUM, shadow_scene::camera());
            let culled = image(&mut renderer, Strategy::ANTUMBRA, shadow_scene::camera());
            assert!(all == culled, "{method:?}");
        }
    });
}

#[test]
fn environments_come_and_go() {
    run_on_all(|device| {
        let environment = Environment::of_sky(&sky()).unwrap();
        let scene = floor(Material::default(), None);
        let mut changing = renderer(device, &scene);
        let camera = shadow_scene::camera();
        let dark = image(&mut changing, Strategy::ANTUMBRA, camera);
        changing.set_environment(Some(&environment)).unwrap();
        let lit = image(&mut changing, Strategy::ANTUMBRA, camera);
        let other = floor(Material::default(), Some(environment));
        assert!(lit == image(&mut renderer(device, &other), Strategy::ANTUMBRA, camera));
        changing.set_exposure(0.0);
        let unexposed = image(&mut changing, Strategy::ANTUMBRA, camera);
        assert!(unexposed.chunks(4).all(|pixel| decoded(pixel[0]) == 0.0), "no light at all");
        changing.set_exposure(f32::NAN);
        changing.set_environment(None).unwrap();
        assert!(dark == image(&mut changing, Strategy::ANTUMBRA, camera), "as it was");
        let mut plain = renderer(device, &shapes::box_scene(&shadow_scene::boxes()));
        let refused = plain.set_environment(Some(&Environment::of_sky(&sky()).unwrap()));
        assert!(matches!(refused, Err(Error::NoSurfacesForEnvironment)));
    });
}
