//! Levels of detail: frames are exact with every strategy, and far objects have fewer triangles.

mod by_samples;

use cull::{Camera, DetailPolicy, ObjectId, Strategy};
use glam::{Affine3A, Quat, Vec3};
use gpu::{Device, Readback};
use render::{CostModel, FrameRequest, Rect, RenderView, Renderer, RendererOptions};
use scene::{LodLevel, MeshId, Object, Scene};
use tests::shapes::{coloured_cubes, square_camera};
use tests::walk::images_that_differ;
use tests::{Driver, run, run_on_all};

const SIZE: [u32; 2] = [160, 160];

/// Returns a wood of cubes before the camera. Their coarser level lacks half of each face, so that
/// the levels cannot be confused.
fn wood() -> Scene {
    let place = |number: u32| {
        let across = (number * 7 % 23) as f32 - 11.0;
        Vec3::new(across, (number % 5) as f32 - 2.0, -3.0 - (number / 4) as f32)
    };
    let object = |number: u32| Object {
        mesh: MeshId(number % 3),
        transform: Affine3A::from_scale_rotation_translation(
            Vec3::splat(0.6 + 0.2 * (number % 4) as f32),
            Quat::from_rotation_y(number as f32),
            place(number),
        ),
        tint: u32::MAX,
    };
    let mut scene = coloured_cubes(3, (0..200).map(object).collect());
    let levels = scene.meshes.iter().map(|mesh| vec![coarser(&mesh.indices, 0.2)]).collect();
    scene.surfaces.as_mut().unwrap().levels = levels;
    scene
}

/// Returns a level that lacks half of each face.
fn coarser(indices: &[u32], error_m: f32) -> LodLevel {
    let (faces, _) = indices.as_chunks::<6>();
    LodLevel {
        indices: faces.iter().flat_map(|face| [face[0], face[1], face[2]]).collect(),
        error_m,
    }
}

fn options() -> RendererOptions {
    RendererOptions {
        methods: methods::all(),
        size: SIZE,
        cost_model: CostModel::Off,
        ..Default::default()
    }
}

fn renderer(device: &Device) -> Renderer {
    Renderer::new(device, &wood(), &options()).unwrap()
}

fn render(
    renderer: &mut Renderer,
    view: &mut RenderView,
    strategy: Strategy,
    camera: Camera,
) -> Readback {
    let image = Readback::new(renderer.device(), SIZE).unwrap();
    let request = FrameRequest { image: Some(&image), ..FrameRequest::new(strategy, camera) };
    renderer.render(view, request).unwrap();
    image
}

fn camera(frame: u32) -> Camera {
    Camera { eye: Vec3::new(0.0, 0.0, -(frame as f32)), ..square_camera() }
}

#[test]
fn every_strategy_draws_the_same_forms() {
    run_on_all(|device| {
        let mut renderer = renderer(device);
        let strategies = [Strategy::FRUSTUM, Strategy::ANTUMBRA, Strategy::ANTUMBRA_QUERIES];
        let mut views = strategies.map(|_| renderer.new_view().unwrap());
        let mut images = Vec::new();
        let mut changes = 0;
        for frame in 0..30 {
            changes += renderer.choose_detail(&[camera(frame)], &DetailPolicy::default());
            let strategies = strategies.iter().zip(&mut views);
            images.push(
                strategies
                    .map(|(strategy, view)| render(&mut renderer, view, *strategy, camera(frame)))
                    .collect::<Vec<_>>(),
            );
        }
        views.iter_mut().for_each(|view| renderer.wait_idle(view).unwrap());
        assert!(changes > 100, "far ones become coarse, those that come near fine: {changes}");
        for (frame, images) in images.iter().enumerate() {
            for (image, strategy) in images.iter().zip(strategies) {
                let wrong = images_that_differ(&images[0], image);
                assert_eq!(wrong, 0, "frame {frame}, {strategy}");
            }
        }
    });
}

#[test]
fn coarse_forms_have_fewer_triangles_and_go_again() {
    run(Driver::Lavapipe, |device| {
        let mut renderer = renderer(device);
        let mut view = renderer.new_view().unwrap();
        let mut look = |renderer: &mut Renderer| {
            let image = render(renderer, &mut view, Strategy::FRUSTUM, camera(0));
            renderer.wait_idle(&mut view).unwrap();
            (image, view.drain_stats().next_back().unwrap().triangles)
        };
        let (fine, all) = look(&mut renderer);
        let policy = |error_pixels| DetailPolicy { error_pixels, ..Default::default() };
        let count = renderer.hierarchy().leaf_objects().len() as u32;
        assert_eq!(renderer.choose_detail(&[camera(0)], &policy(1.0e6)), count);
        assert_eq!(renderer.choose_detail(&[camera(0)], &policy(1.0e6)), 0);
        let (coarse, half) = look(&mut renderer);
        assert_eq!(half * 2, all);
        assert!(images_that_differ(&fine, &coarse) > 0);
        assert_eq!(renderer.choose_detail(&[camera(0)], &policy(0.0)), count);
        let (again, found) = look(&mut renderer);
        assert_eq!((images_that_differ(&fine, &again), found), (0, all));
    });
}

/// Returns the wood with the back of each triangle as a separate triangle, also in coarser levels.
fn wood_from_both_sides() -> Scene {
    let add_backs = |indices: &mut Vec<u32>| {
        let backs: Vec<u32> =
            indices.as_chunks::<3>().0.iter().flat_map(|[a, b, c]| [*a, *c, *b]).collect();
        indices.extend(backs);
    };
    let mut scene = wood();
    for mesh in &mut scene.meshes {
        add_backs(&mut mesh.indices);
        mesh.has_backs = true;
    }
    for level in scene.surfaces.as_mut().unwrap().levels.iter_mut().flatten() {
        add_backs(&mut level.indices);
    }
    scene
}

#[test]
fn a_triangle_and_its_back_are_counted_as_one() {
    run_on_all(|device| {
        let scene = wood_from_both_sides();
        assert_eq!(scene.triangles(), 12 * 200);
        let mut renderer = Renderer::new(device, &scene, &options()).unwrap();
        // The CPU counts the draws that it decides, and the GPU counts the draws of the pyramid.
        for (error_pixels, of_cube) in [(0.0, 12), (1e6, 6)] {
            let policy = DetailPolicy { error_pixels, hysteresis: 0.0, by_samples: None };
            renderer.choose_detail(&[camera(0)], &policy);
            assert_eq!(renderer.triangles_of(ObjectId(7)), of_cube);
            let mut finder = renderer.new_view().unwrap();
            let whole = Rect::whole(SIZE);
            let visible = renderer.visible_set(&mut finder, camera(0), whole).unwrap();
            for strategy in [Strategy::FRUSTUM, Strategy::ANTUMBRA, methods::HZB, methods::IDEAL] {
                let mut view = renderer.new_view().unwrap();
                let plain = FrameRequest::new(strategy, camera(0));
                let request = FrameRequest { visible: Some(&visible), ..plain };
                for _ in 0..4 {
                    renderer.render(&mut view, request).unwrap();
                }
                renderer.wait_idle(&mut view).unwrap();
                let outcome = view.drain_stats().next_back().unwrap();
                assert!(outcome.draws > 20, "{strategy}: {outcome:?}");
                assert_eq!(outcome.triangles, of_cube * outcome.draws, "{strategy}");
            }
        }
    });
}
