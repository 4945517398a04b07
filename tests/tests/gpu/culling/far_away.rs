//! Scenes far from the origin of the world, as in map coordinates. They look the same as at the
//! origin, with all shadows, flares and sprites, and a pixel picks the same object. Positions are
//! whole metres, which single precision can represent up to 13,000 km.

use std::ops::ControlFlow;
use std::path::Path;

use cull::{Aabb, Camera, Strategy};
use glam::{Vec3, Vec3A, vec3};
use gpu::Device;
use import::LoadOptions;
use render::{CostModel, Renderer, RendererOptions};
use scene::{FlarePlace, LensFlare, PunctualLight, Scene};
use shadows::{ShadowFilter, ShadowMethod, ShadowOptions};
use tests::shapes::{box_at, box_scene};
use tests::walk::{pixels_that_differ, walk_cameras};
use tests::{run_on_all, shadow_scene};

use crate::culling::coplanar::with_sprites;
use crate::shadows::shadow_maps::raycast::{Judged, judge};
use crate::shadows::shadow_maps::{SIZE, image, renderer, shadows};

/// Places at 50 km, 1,000 km and 13,000 km.
const AWAY: [Vec3; 3] = [
    vec3(35_360.0, 12.0, -35_360.0),
    vec3(-707_120.0, 300.0, 707_120.0),
    vec3(12_958_155.0, 4_865_579.0, -220.0),
];

/// Returns boxes whose lower corners are whole metres: a ground, a wall, columns, small ones, a
/// roof and a bar in the air.
fn boxes() -> Vec<Aabb> {
    let at = |low: Vec3, size: Vec3| Aabb::new(low, low + size);
    let mut boxes = vec![at(vec3(-16.0, -1.0, -16.0), vec3(32.0, 1.0, 32.0))];
    boxes.push(at(vec3(-8.0, 0.0, -6.0), vec3(6.0, 2.5, 0.4)));
    boxes.extend(
        (0..5).map(|index| at(vec3(index as f32 * 3.0 - 6.0, 0.0, 2.0), vec3(0.5, 3.0, 0.5))),
    );
    for small in 0..25 {
        let [x, z] = [small % 5, small / 5].map(|place| place as f32 * 2.0 - 2.0);
        let height = 0.4 + 0.3 * (small % 4) as f32;
        boxes.push(at(vec3(x, 0.0, z - 6.0), vec3(0.6, height, 0.6)));
    }
    boxes.push(at(vec3(5.0, 3.0, -2.0), vec3(4.0, 0.2, 5.0)));
    boxes.push(at(vec3(-6.0, 3.0, -1.0), vec3(10.0, 0.15, 0.15)));
    boxes
}

fn lights() -> [PunctualLight; 3] {
    let mut lights = shadow_scene::lights();
    lights.iter_mut().for_each(|light| light.position = light.position.round());
    lights
}

fn camera(away: Vec3) -> Camera {
    let eye = vec3(1.0, 6.0, 11.0);
    Camera {
        eye: eye + away,
        forward: (vec3(0.0, 0.0, -1.5) - eye).normalize(),
        ..shadow_scene::camera()
    }
}

/// Returns a scene with its objects and lights moved away.
fn moved(scene: &Scene, away: Vec3) -> Scene {
    let mut scene = scene.clone();
    for object in &mut scene.objects {
        object.transform.translation += Vec3A::from(away);
    }
    for light in scene.surfaces.iter_mut().flat_map(|surfaces| &mut surfaces.lights) {
        light.position += away;
    }
    scene
}

/// Returns images of a scene that is moved away: with several kinds of shadows, with and without
/// occlusion culling.
fn images(device: &Device, scene: &Scene, away: Vec3, all: &[ShadowOptions]) -> Vec<Vec<u8>> {
    let mut renderer = renderer(device, &moved(scene, away), ShadowOptions::default());
    let mut images = Vec::new();
    for options in all {
        renderer.set_shadows(*options).unwrap();
        for strategy in [Strategy::FRUSTUM, Strategy::ANTUMBRA] {
            let mut view = renderer.new_view().unwrap();
            images.push(image(&mut renderer, &mut view, strategy, camera(away)));
        }
    }
    images
}

fn volumes() -> ShadowOptions {
    ShadowOptions { method: ShadowMethod::Volumes, ..ShadowOptions::default() }
}

#[test]
fn lamps_maps_and_volumes_and_sprites_are_the_same_to_the_bit() {
    run_on_all(|device| {
        let [sun, spot, point] = lights();
        let mut of_lamps = with_sprites(shadow_scene::scene(&boxes(), &[spot, point]));
        for object in &mut of_lamps.objects {
            object.transform.translation = object.transform.translation.round();
        }
        let maps = ShadowFilter::ALL.map(|filter| ShadowOptions { filter, ..shadows() });
        let of_lamps = (of_lamps, [&[ShadowOptions::default(), volumes()][..], &maps].concat());
        let of_sun = (shadow_scene::scene(&boxes(), &[sun]), vec![volumes()]);
        for (scene, all) in [of_lamps, of_sun] {
            let expected = images(device, &scene, Vec3::ZERO, &all);
            for (place, away) in AWAY.into_iter().enumerate() {
                // Each filter of maps is at one place. An option has an image of each strategy.
                let is_there = |number: &usize| *number < 2 || number % AWAY.len() == place;
                let there: Vec<usize> = (0..all.len()).filter(is_there).collect();
                let options: Vec<ShadowOptions> = there.iter().map(|number| all[*number]).collect();
                let found = images(device, &scene, away, &options);
                let expected = there.iter().flat_map(|number| &expected[2 * number..][..2]);
                let differ = |(a, b): (&Vec<u8>, &Vec<u8>)| pixels_that_differ(a, b);
                let wrong: Vec<usize> = expected.zip(&found).map(differ).collect();
                // The volumes of a sun end elsewhere, so their sides are rounded differently.
                let allowed = if all.len() == 1 { 2 } else { 0 };
                assert!(wrong.iter().all(|wrong| *wrong <= allowed), "{away}: {wrong:?}");
            }
        }
    });
}

#[test]
fn sun_maps_agree_with_ray_casting_at_every_distance() {
    run_on_all(|device| {
        let boxes = boxes();
        let [sun, ..] = lights();
        let scene = shadow_scene::scene(&boxes, &[sun]);
        let fine = ShadowOptions { distance_m: Some(40.0), sun_side: 1024, ..shadows() };
        let all = [
            ShadowOptions::default(),
            ShadowOptions { filter: ShadowFilter::Single, ..fine },
            ShadowOptions { filter: ShadowFilter::Adaptive, ..fine },
        ];
        let expected = images(device, &scene, Vec3::ZERO, &all);
        for away in [Vec3::ZERO].into_iter().chain(AWAY) {
            let found = images(device, &scene, away, &all);
            let [lit, culled_lit, hard, culled_hard, soft, culled_soft] = &found[..] else {
                panic!("six images")
            };
            assert_eq!([lit, culled_lit], [&expected[0]; 2], "{away}");
            assert!(hard == culled_hard && soft == culled_soft, "{away}");
            let of_boxes = &boxes[..];
            let of_camera = &camera(Vec3::ZERO);
            let Judged { checked, dark, wrong } = judge(of_boxes, of_camera, &sun, lit, hard);
            assert!(wrong.is_empty(), "{away}: {} of {checked}: {wrong:#?}", wrong.len());
            assert!(checked > 500 && dark > 10, "{checked}, {dark}");
            // The texels lie elsewhere, which changes edges of shadows.
            let apart = |(a, b): (&u8, &u8)| a.abs_diff(*b) > 40;
            let differing = expected[4].iter().zip(soft).filter(|pixel| apart(*pixel)).count();
            assert!(differing * 100 < soft.len(), "{away}: {differing}");
        }
    });
}

fn loaded(name: &str) -> (Scene, Camera) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gpu/culling/far_away").join(name);
    let loaded = import::load(&file, &LoadOptions::default(), &mut |_| ControlFlow::Continue(()));
    let loaded = loaded.unwrap();
    let camera = loaded.default_camera(SIZE);
    (loaded.scene, camera)
}

/// Draws boxes on a ground under a sun, at 100 km by transforms of nodes and at 13,000 km by
/// positions of vertices. Most of the ground was once in shadow.
#[test]
fn files_in_map_coordinates_have_the_shadows_of_the_same_at_the_origin() {
    let by_nodes = loaded("sun_100_km.gltf");
    let by_vertices = loaded("sun_mercator.gltf");
    let back = [vec3(-100_000.0, 0.0, -100_000.0), vec3(-12_958_095.0, -4_865_469.0, 0.0)];
    let mut vertices_back = by_vertices.0.clone();
    for mesh in &mut vertices_back.meshes {
        for vertex in &mut mesh.vertices {
            vertex.position = (Vec3::from(vertex.position) + back[1]).to_array();
        }
        mesh.bounds = Aabb::new(mesh.bounds.min + back[1], mesh.bounds.max + back[1]);
    }
    let at_origin = [moved(&by_nodes.0, back[0]), vertices_back];
    run_on_all(|device| {
        for (number, (scene, camera)) in [&by_nodes, &by_vertices].into_iter().enumerate() {
            let draw = |scene: &Scene, away: Vec3, options| {
                let mut renderer = renderer(device, scene, options);
                let mut view = renderer.new_view().unwrap();
                let camera = Camera { eye: camera.eye + away, ..*camera };
                image(&mut renderer, &mut view, Strategy::ANTUMBRA, camera)
            };
            let options = ShadowOptions { distance_m: None, sun_side: 1024, ..shadows() };
            let lit = draw(scene, Vec3::ZERO, ShadowOptions::default());
            let near = draw(&at_origin[number], back[number], options);
            let far = draw(scene, Vec3::ZERO, options);
            let apart =
                |a: &[u8], b: &[u8]| a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 24).count();
            let dark = apart(&lit, &near);
            let wrong = apart(&near, &far);
            assert!(dark > 1000 && wrong * 20 < dark, "{number}: {wrong} of {dark}");
        }
    });
}

/// Returns the objects at pixels of a grid, and the shares of lights that flares show.
fn picked(device: &Device, scene: &Scene, away: Vec3) -> (Vec<Option<(u32, f32)>>, Vec<f32>) {
    let mut renderer: Renderer = renderer(device, &moved(scene, away), ShadowOptions::default());
    let mut view = renderer.new_view().unwrap();
    let flare = |place, radius| LensFlare {
        place,
        radius,
        colour: [0.9, 0.7, 0.5],
        glow: 0.4,
        ghosts: 1.0,
    };
    let lamp = |at: Vec3, radius| flare(FlarePlace::At(at + away), radius);
    let flares = [
        lamp(vec3(-6.0, 1.0, 2.0), 0.4),
        lamp(vec3(2.0, 1.0, -7.0), 0.5),
        flare(FlarePlace::Towards(vec3(0.1, -0.1, -1.0)), 0.1),
    ];
    renderer.set_flares(&flares).unwrap();
    for _ in 0..4 {
        image(&mut renderer, &mut view, Strategy::ANTUMBRA, camera(away));
    }
    let shares = view.flares().iter().map(|state| state.fraction()).collect();
    let pixels =
        (0..SIZE[1]).step_by(11).flat_map(|y| (0..SIZE[0]).step_by(13).map(move |x| [x, y]));
    let objects = pixels.map(|pixel| {
        view.point_at(Some(pixel)).unwrap();
        image(&mut renderer, &mut view, Strategy::ANTUMBRA, camera(away));
        let surface = view.pointed().expect("it is over").surface;
        surface.map(|surface| (surface.object.0, surface.depth))
    });
    (objects.collect(), shares)
}

#[test]
fn picks_and_flares_are_the_same() {
    run_on_all(|device| {
        let mut boxes = boxes();
        boxes.push(box_at(vec3(2.0, 1.0, -6.0), vec3(0.25, 2.0, 0.1)));
        let mut scene = shadow_scene::scene(&boxes, &lights());
        for object in &mut scene.objects {
            object.transform.translation = object.transform.translation.round();
        }
        let (objects, shares) = picked(device, &scene, Vec3::ZERO);
        let kinds: std::collections::BTreeSet<u32> =
            objects.iter().flatten().map(|(object, _)| *object).collect();
        assert!(kinds.len() > 10, "{kinds:?}");
        assert!(shares.iter().any(|share| *share > 0.0 && *share < 1.0), "{shares:?}");
        for away in AWAY {
            let (objects_there, shares_there) = picked(device, &scene, away);
            assert_eq!(shares_there, shares, "{away}");
            for (there, here) in objects_there.iter().zip(&objects) {
                assert_eq!(there.map(|found| found.0), here.map(|found| found.0), "{away}");
                let apart =
                    there.zip(*here).map_or(0.0, |(there, here)| (there.1 / here.1 - 1.0).abs());
                assert!(apart < 1e-4, "{away}: {there:?}, {here:?}");
            }
        }
    });
}

/// Walks between blocks of houses that are larger than the margins of boxes so far away, about 25
/// m.
#[test]
fn blocks_are_hidden_exactly_where_positions_are_whole_metres() {
    run_on_all(|device| {
        for away in AWAY {
            let block = |number: u32| {
                let aside = (number % 12) as f32 * 512.0 - 2_496.0;
                let ahead = (number / 12) as f32 * -512.0;
                let low = away + vec3(aside, 0.0, ahead);
                Aabb::new(low, low + vec3(384.0, 192.0 + 32.0 * (number % 5) as f32, 384.0))
            };
            let scene = box_scene(&(0..144).map(block).collect::<Vec<_>>());
            let walked = |frame: u32| Camera {
                eye: away + vec3(0.0, 64.0, 640.0 - 64.0 * frame as f32),
                forward: vec3(0.3, 0.0, -1.0),
                near: 1.0,
                ..shadow_scene::camera()
            };
            let cameras: Vec<Camera> = (0..16).map(walked).collect();
            let options =
                RendererOptions { size: SIZE, cost_model: CostModel::Off, ..Default::default() };
            let found = walk_cameras(device, &scene, &cameras, &options);
            let [all, drawn] = found.draws;
            assert_eq!(found.pixels_wrong, 0, "{away}");
            assert!(drawn * 2 < all, "{away}: {drawn} of {all} drawn");
        }
    });
}
