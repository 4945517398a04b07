//! What does not belong together is refused before anything is recorded, with a sentence that helps.
#![forbid(unsafe_code)]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use cull::{Aabb, Hierarchy, Strategy};
use gpu::Readback;
use render::scene::{CameraPath, PathKind};
use render::{Error, FrameRequest, Renderer, RendererOptions, object_bounds};
use tests::walk::SceneKind;
use tests::{Driver, run};

const SIZE: [u32; 2] = [64, 36];

fn options() -> RendererOptions {
    RendererOptions { size: SIZE, ..Default::default() }
}

#[test]
fn a_view_of_another_renderer_is_refused() {
    run(Driver::Lavapipe, |device| {
        let (small, large) = (SceneKind::City.build(50), SceneKind::City.build(900));
        let path = CameraPath::new(PathKind::Street, &large).unwrap();
        let few = Renderer::new(device, &small, &options()).unwrap();
        let mut many = Renderer::new(device, &large, &options()).unwrap();
        let mut foreign = few.new_view().unwrap();
        let mut view = many.new_view().unwrap();
        let request = FrameRequest::new(Strategy::Antumbra, path.camera(0));
        let refused = |error: Error| assert!(error.to_string().contains("another renderer"));
        refused(many.render(&mut foreign, &request).unwrap_err());
        refused(many.drain(&mut foreign).unwrap_err());
        let seen = many.view_of(&path.camera(0));
        refused(many.moment(&mut foreign, seen).unwrap_err());
        many.render(&mut view, &request).unwrap();
        many.drain(&mut view).unwrap();
    });
}

#[test]
fn a_picture_of_another_size_is_refused() {
    run(Driver::Lavapipe, |device| {
        let scene = SceneKind::City.build(50);
        let path = CameraPath::new(PathKind::Street, &scene).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options()).unwrap();
        let mut view = renderer.new_view().unwrap();
        let picture = Readback::new(device, [SIZE[0], SIZE[1] + 1]).unwrap();
        let request = FrameRequest {
            picture: Some(&picture),
            ..FrameRequest::new(Strategy::Antumbra, path.camera(0))
        };
        let refused = renderer.render(&mut view, &request).unwrap_err().to_string();
        assert!(refused.contains("64x37") && refused.contains("64x36"), "{refused}");
        renderer.render(&mut view, &FrameRequest { picture: None, ..request }).unwrap();
        let moment = renderer.moment(&mut view, renderer.view_of(&path.camera(0))).unwrap();
        assert!(renderer.birds_eye(&moment, &picture).is_err());
    });
}

#[test]
fn a_hierarchy_over_other_objects_is_refused() {
    run(Driver::Lavapipe, |device| {
        let scene = SceneKind::City.build(60);
        let bounds = object_bounds(&scene).unwrap();
        let others = [
            bounds[1..].to_vec(),
            bounds.iter().copied().chain([bounds[0]]).collect(),
            bounds.iter().rev().copied().collect::<Vec<Aabb>>(),
        ];
        for other in others {
            let hierarchy = Hierarchy::build(&other).unwrap();
            let made = Renderer::with_hierarchy(device, &scene, hierarchy, &options());
            let refused = made.err().unwrap().to_string();
            assert!(refused.contains("not that of the scene"), "{refused}");
        }
        // Larger boxes hold the objects, and free leaves are room for more.
        let larger = bounds.iter().map(|bounds| bounds.enlarged(0.5)).chain([Aabb::EMPTY; 3]);
        let hierarchy = Hierarchy::build(&larger.collect::<Vec<Aabb>>()).unwrap();
        Renderer::with_hierarchy(device, &scene, hierarchy, &options()).unwrap();
    });
}

#[test]
fn outcomes_that_nobody_takes_are_kept_within_bounds() {
    run(Driver::Lavapipe, |device| {
        let scene = SceneKind::Field.build(3);
        let path = CameraPath::new(PathKind::Street, &scene).unwrap();
        let tiny = RendererOptions { size: [4, 4], ..options() };
        let mut renderer = Renderer::new(device, &scene, &tiny).unwrap();
        let mut view = renderer.new_view().unwrap();
        for _ in 0..1_100 {
            let request = FrameRequest::new(Strategy::Frustum, path.camera(0));
            renderer.render(&mut view, &request).unwrap();
        }
        renderer.drain(&mut view).unwrap();
        let outcomes: Vec<u64> = view.take_outcomes().map(|outcome| outcome.frame.0).collect();
        assert_eq!(outcomes, (77..=1_100).collect::<Vec<u64>>());
    });
}
