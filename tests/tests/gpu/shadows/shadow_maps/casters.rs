//! Shadows with every strategy, from casters outside the view, and through holes.

use cull::{Aabb, Camera, Strategy};
use glam::vec3;
use render::{Rect, ViewRequest, ViewsRequest};
use scene::{Alpha, Material};
use shadows::{ShadowBias, ShadowFilter, ShadowOptions};
use tests::{run_on_all, shadow_scene};

use super::{SIZE, image, renderer, shadows};

/// Returns a camera that walks along the yard and turns.
pub fn walking(frame: u32) -> Camera {
    let camera = shadow_scene::camera();
    let (sine, cosine) = (frame as f32 * 0.15).sin_cos();
    let eye = vec3(6.0 * sine, 1.2 + 0.05 * frame as f32, 7.0 + 2.0 * cosine);
    Camera { eye, forward: (vec3(sine, 0.8, -2.0) - eye).normalize(), ..camera }
}

#[test]
fn every_exact_strategy_has_the_same_shadows() {
    run_on_all(|device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        for filter in [ShadowFilter::Adaptive, ShadowFilter::Pcss12] {
            let mut renderer = renderer(device, &scene, ShadowOptions { filter, ..shadows() });
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
            for frame in 0..6 {
                let camera = walking(2 * frame);
                let [reference, views @ ..] = &mut views[..] else { panic!("no view") };
                let expected = image(&mut renderer, reference, Strategy::FRUSTUM, camera);
                for (strategy, view) in supported.iter().zip(views) {
                    let found = image(&mut renderer, view, *strategy, camera);
                    let wrong = tests::walk::pixels_that_differ(&expected, &found);
                    assert_eq!(wrong, 0, "{strategy} at frame {frame} with {filter:?}");
                }
            }
        }
    });
}

#[test]
fn each_of_two_views_has_the_cascades_of_its_own_eye() {
    run_on_all(|device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let halves =
            [0, SIZE[0] / 2].map(|x| Rect { origin: [x, 0], size: [SIZE[0] / 2, SIZE[1]] });
        let far = Camera {
            eye: vec3(-9.0, 3.0, -12.0),
            forward: vec3(0.5, -0.2, 0.8),
            ..shadow_scene::camera()
        };
        let cameras = [shadow_scene::camera(), far];
        let draw = |shown: &[usize]| {
            let mut renderer = renderer(device, &scene, shadows());
            let mut views: Vec<_> = shown.iter().map(|_| renderer.new_view().unwrap()).collect();
            let image = gpu::Readback::new(device, SIZE).unwrap();
            let target = |(state, view): (_, &usize)| ViewRequest {
                state,
                viewpoint: cameras[*view].into(),
                visible: None,
                rect: halves[*view],
            };
            let mut targets: Vec<_> = views.iter_mut().zip(shown).map(target).collect();
            let request = ViewsRequest {
                strategy: Strategy::ANTUMBRA,
                image: Some(&image),
                overlay: None,
                after: None,
            };
            renderer.render_views(&mut targets, &request).unwrap();
            device.wait_idle().unwrap();
            image.rgba8().unwrap().to_vec()
        };
        let both = draw(&[0, 1]);
        for (view, half) in halves.iter().enumerate() {
            let alone = draw(&[view]);
            let row_bytes = SIZE[0] as usize * 4;
            let part = half.origin[0] as usize * 4..(half.origin[0] + half.size[0]) as usize * 4;
            for (row, (a, b)) in both.chunks(row_bytes).zip(alone.chunks(row_bytes)).enumerate() {
                assert!(a[part.clone()] == b[part.clone()], "row {row} of view {view}");
            }
        }
    });
}

#[test]
fn what_no_view_shows_casts_its_shadow() {
    run_on_all(|device| {
        // A plate high above, behind the eye, between the sun and the ground ahead.
        let [sun, ..] = shadow_scene::lights();
        let plate = Aabb::new(vec3(-2.0, 14.0, 3.0), vec3(6.0, 14.2, 12.0));
        let lit = shadow_scene::scene(&[shadow_scene::GROUND], &[sun]);
        let shadowed = shadow_scene::scene(&[shadow_scene::GROUND, plate], &[sun]);
        let camera = Camera {
            eye: vec3(0.0, 4.0, 6.0),
            forward: vec3(-0.4, -0.9, -0.6),
            ..shadow_scene::camera()
        };
        let [lit, shadowed] = [lit, shadowed].map(|scene| {
            let mut renderer = renderer(device, &scene, shadows());
            let mut view = renderer.new_view().unwrap();
            image(&mut renderer, &mut view, Strategy::ANTUMBRA, camera)
        });
        let darker = lit.iter().zip(&shadowed).filter(|(lit, shadowed)| lit > shadowed).count();
        assert!(darker > 1000, "{darker} channels are darker");
    });
}

#[test]
fn light_falls_through_the_holes_of_masked_materials() {
    run_on_all(|device| {
        let [sun, ..] = shadow_scene::lights();
        let plate = Aabb::new(vec3(-3.0, 3.0, -3.0), vec3(3.0, 3.1, 3.0));
        let draw = |alpha: f32, is_there: bool| {
            let boxes = [shadow_scene::GROUND, plate];
            let mut scene = shadow_scene::scene(&boxes[..1 + usize::from(is_there)], &[sun]);
            let mut leaf = scene.meshes[0].clone();
            leaf.name = "leaf".to_owned();
            scene.meshes.push(leaf);
            let surfaces = scene.surfaces.as_mut().unwrap();
            let material = Material {
                alpha: Alpha::Mask { cutoff: 0.5 },
                base_colour: [1.0, 1.0, 1.0, alpha],
                ..surfaces.materials[0].clone()
            };
            surfaces.materials.push(material);
            let mut surface = surfaces.meshes[0].clone();
            surface.material = scene::MaterialId(1);
            surfaces.meshes.push(surface);
            if let Some(object) = scene.objects.get_mut(1) {
                object.mesh = scene::MeshId(1);
            }
            let mut renderer = renderer(device, &scene, shadows());
            let mut view = renderer.new_view().unwrap();
            let camera = Camera {
                eye: vec3(0.0, 2.0, 9.0),
                forward: vec3(0.0, -0.3, -1.0),
                ..shadow_scene::camera()
            };
            image(&mut renderer, &mut view, Strategy::ANTUMBRA, camera)
        };
        let nothing = draw(1.0, false);
        assert!(draw(0.2, true) == nothing, "a hole everywhere casts no shadow");
        assert!(draw(0.8, true) != nothing, "a whole one does");
    });
}

#[test]
fn every_bias_darkens_the_same_places() {
    run_on_all(|device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let draw = |options| {
            let mut renderer = renderer(device, &scene, options);
            let mut view = renderer.new_view().unwrap();
            image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera())
        };
        let lit = draw(ShadowOptions::default());
        let planes = draw(shadows());
        let differing =
            |a: &[u8], b: &[u8]| a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 24).count();
        let shadowed = differing(&lit, &planes);
        for bias in [ShadowBias::BackFaces, ShadowBias::Midpoint] {
            let apart = differing(&planes, &draw(ShadowOptions { bias, ..shadows() }));
            assert!(shadowed > 2000 && apart * 5 < shadowed, "{bias:?}: {apart} of {shadowed}");
        }
    });
}
