//! Shadow volumes in the renderer: images against rays, with every strategy, in several views and
//! sizes, and by each way of extruding.

mod changes;
mod culling;
mod devices;
mod masked;
mod masks;
mod rays;

use cull::{Camera, Strategy};
use glam::{Vec3, vec3};
use gpu::{Device, Readback};
use render::{Rect, RenderView, Renderer, ViewRequest, ViewsRequest};
use scene::Scene;
use shadows::{ShadowMethod, ShadowOptions};
use tests::walk::pixels_that_differ;
use tests::{run_on_all, shadow_scene};

use crate::shadows::shadow_maps::bad_options::badly_lit;
use crate::shadows::shadow_maps::casters::walking;
use crate::shadows::shadow_maps::{SIZE, image, renderer};

const VOLUMES: ShadowMethod = ShadowMethod::Volumes;

/// Returns the options of volumes.
fn volumes() -> ShadowOptions {
    ShadowOptions { method: VOLUMES, ..ShadowOptions::default() }
}

/// Draws a frame of a new renderer.
fn fresh(device: &Device, scene: &Scene, options: ShadowOptions, camera: Camera) -> Vec<u8> {
    let mut renderer = renderer(device, scene, options);
    let mut view = renderer.new_view().unwrap();
    image(&mut renderer, &mut view, Strategy::FRUSTUM, camera)
}

#[test]
fn every_exact_strategy_has_the_same_volumes() {
    run_on_all(|device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let mut renderer = renderer(device, &scene, volumes());
        let strategies = [
            Strategy::ANTUMBRA_QUERIES,
            Strategy::ANTUMBRA_FLAGS,
            Strategy::ANTUMBRA_COMPUTE,
            methods::CHC,
            methods::HZB,
        ];
        let supported =
            strategies.into_iter().filter(|strategy| renderer.supports(*strategy).is_ok());
        let supported: Vec<Strategy> = supported.collect();
        let mut views: Vec<_> =
            (0..=supported.len()).map(|_| renderer.new_view().unwrap()).collect();
        let mut counted = [0, 0];
        for frame in 0..8 {
            let camera = walking(frame);
            let [reference, views @ ..] = &mut views[..] else { panic!("no view") };
            let expected = image(&mut renderer, reference, Strategy::FRUSTUM, camera);
            for (strategy, view) in supported.iter().zip(views) {
                let found = image(&mut renderer, view, *strategy, camera);
                let wrong = pixels_that_differ(&expected, &found);
                assert_eq!(wrong, 0, "{strategy} at frame {frame}");
            }
            let stats = renderer.shadow_stats();
            assert!(stats.lights > 0 && stats.casters > 0);
            counted = [counted[0] + stats.casters, counted[1] + stats.z_fail_volumes];
        }
        let [casters, by_z_fail] = counted;
        assert!(by_z_fail > 0 && by_z_fail * 4 < casters, "{by_z_fail} of {casters} by z-fail");
    });
}

#[test]
fn each_of_two_views_has_a_mask_of_its_own() {
    run_on_all(|device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        // Of different sizes, the second one larger.
        let parts = [
            Rect { origin: [8, 4], size: [40, 70] },
            Rect { origin: [56, 8], size: [72, SIZE[1] - 8] },
        ];
        let far = Camera {
            eye: vec3(-9.0, 3.0, -12.0),
            forward: vec3(0.5, -0.2, 0.8),
            ..shadow_scene::camera()
        };
        let cameras = [shadow_scene::camera(), far];
        let draw = |shown: &[usize]| {
            let mut renderer = renderer(device, &scene, volumes());
            let mut views: Vec<_> = shown.iter().map(|_| renderer.new_view().unwrap()).collect();
            draw_parts(&mut renderer, &mut views, shown, cameras, parts)
        };
        let both = draw(&[0, 1]);
        for (view, part) in parts.iter().enumerate() {
            let alone = draw(&[view]);
            let row_bytes = SIZE[0] as usize * 4;
            let columns = part.origin[0] as usize * 4..(part.origin[0] + part.size[0]) as usize * 4;
            let rows = both.chunks(row_bytes).zip(alone.chunks(row_bytes)).enumerate();
            for (row, (a, b)) in rows.skip(part.origin[1] as usize).take(part.size[1] as usize) {
                assert!(a[columns.clone()] == b[columns.clone()], "row {row} of view {view}");
            }
        }
        assert!(both != draw(&[1, 0]), "the order of views is that of their parts");
    });
}

fn draw_parts(
    renderer: &mut Renderer,
    views: &mut [RenderView],
    shown: &[usize],
    cameras: [Camera; 2],
    parts: [Rect; 2],
) -> Vec<u8> {
    let image = Readback::new(renderer.device(), SIZE).unwrap();
    let target = |(state, view): (_, &usize)| ViewRequest {
        state,
        viewpoint: cameras[*view].into(),
        visible: None,
        rect: parts[if shown.len() > 1 && shown[0] == 1 { 1 - *view } else { *view }],
    };
    let mut targets: Vec<_> = views.iter_mut().zip(shown).map(target).collect();
    let request = ViewsRequest {
        strategy: Strategy::ANTUMBRA,
        image: Some(&image),
        overlay: None,
        after: None,
    };
    renderer.render_views(&mut targets, &request).unwrap();
    renderer.device().wait_idle().unwrap();
    image.rgba8().unwrap().to_vec()
}

#[test]
fn images_of_other_sizes_have_masks_of_their_size() {
    run_on_all(|device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let mut resized = renderer(device, &scene, volumes());
        let mut view = resized.new_view().unwrap();
        let first = image(&mut resized, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
        for size in [[200, 60], [40, 90], SIZE] {
            resized.resize(size).unwrap();
            let found = image(&mut resized, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
            let mut other = renderer(device, &scene, volumes());
            other.resize(size).unwrap();
            let mut its_view = other.new_view().unwrap();
            let expected =
                image(&mut other, &mut its_view, Strategy::FRUSTUM, shadow_scene::camera());
            assert!(found == expected, "{size:?}");
            assert!(size != SIZE || found == first);
        }
    });
}

#[test]
fn impossible_lights_and_ten_thousand_of_them_cast_no_harmful_volumes() {
    run_on_all(|device| {
        for count in [0, 10_000] {
            let scene = badly_lit(count);
            let mut renderer = renderer(device, &scene, volumes());
            let mut view = renderer.new_view().unwrap();
            // Most lights are at this corner.
            let corner = shadow_scene::GROUND.max;
            let camera = Camera {
                eye: corner + 3.0,
                forward: Vec3::NEG_ONE.normalize(),
                ..shadow_scene::camera()
            };
            for _ in 0..2 {
                image(&mut renderer, &mut view, Strategy::ANTUMBRA, camera);
            }
            let stats = renderer.shadow_stats();
            let lights = stats.lights;
            let unshadowed = stats.unshadowed_lights;
            let is_full = lights == 256 && unshadowed > 9_000;
            assert!(if count > 0 { is_full } else { lights < 8 && unshadowed == 0 }, "{stats:?}");
        }
    });
}
