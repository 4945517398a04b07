//! What does not belong together is refused before anything is recorded, with a sentence that helps.
#![forbid(unsafe_code)]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use cull::{Aabb, CostTable, Hierarchy, Strategy};
use gpu::Readback;
use render::scene::{CameraPath, PathKind};
use render::{
    Costs, Error, FrameRequest, MAX_FRAMES_IN_FLIGHT, Renderer, RendererOptions, ViewsRequest,
    object_bounds,
};
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
fn options_beyond_all_limits_are_refused_before_anything_is_made() {
    run(Driver::Lavapipe, |device| {
        let scene = SceneKind::Field.build(9);
        let refused = |options: RendererOptions| {
            Renderer::new(device, &scene, &options).err().unwrap().to_string()
        };
        for frames_in_flight in [MAX_FRAMES_IN_FLIGHT + 1, 100_000, usize::MAX] {
            let sentence = refused(RendererOptions { frames_in_flight, ..options() });
            assert!(sentence.starts_with(&format!("{frames_in_flight} frames")), "{sentence}");
            assert!(sentence.contains("(16)"), "{sentence}");
            let mut renderer = Renderer::new(device, &scene, &options()).unwrap();
            let before = renderer.frames_in_flight();
            let later = renderer.set_frames_in_flight(frames_in_flight).unwrap_err().to_string();
            assert_eq!((later, renderer.frames_in_flight()), (sentence, before));
        }
        for spare_objects in [usize::MAX, (1 << 30) + 1, 1 << 30] {
            let sentence = refused(RendererOptions { spare_objects, ..options() });
            assert!(sentence.contains("objects are more than one hierarchy holds"), "{sentence}");
        }
        // What a hierarchy could hold, and the device cannot: 64 bytes each.
        let most = device.adapter().limits.max_storage_buffer_range as usize / 64;
        let sentence = refused(RendererOptions { spare_objects: most, ..options() });
        let names_limit = sentence.contains(&format!("at most {most} here"));
        assert!(names_limit && sentence.contains("room"), "{sentence}");
        for (value, words) in [(f32::NAN, "is NaN"), (-1.0, "is -1")] {
            let costs = Costs::Table(CostTable { draw_ns: value, ..CostTable::default() });
            let sentence = refused(RendererOptions { costs, ..options() });
            assert!(sentence.contains(&format!("`draw_ns` {words}")), "{sentence}");
        }
    });
}

#[test]
fn the_largest_options_that_are_taken_draw_a_frame() {
    run(Driver::Lavapipe, |device| {
        let scene = SceneKind::City.build(60);
        let path = CameraPath::new(PathKind::Street, &scene).unwrap();
        let largest = RendererOptions {
            frames_in_flight: MAX_FRAMES_IN_FLIGHT,
            query_budget: usize::MAX,
            ..options()
        };
        let mut renderer = Renderer::new(device, &scene, &largest).unwrap();
        let mut view = renderer.new_view().unwrap();
        for frame in 0..2 * MAX_FRAMES_IN_FLIGHT as u32 {
            let request = FrameRequest::new(Strategy::Antumbra, path.camera(frame));
            renderer.render(&mut view, &request).unwrap();
        }
        renderer.drain(&mut view).unwrap();
    });
}

#[test]
fn a_frame_without_a_view_is_refused() {
    run(Driver::Lavapipe, |device| {
        let mut renderer = Renderer::new(device, &SceneKind::Field.build(9), &options()).unwrap();
        let picture = Readback::new(device, SIZE).unwrap();
        for picture in [None, Some(&picture)] {
            let request = ViewsRequest { strategy: Strategy::Antumbra, picture, after: None };
            let refused = renderer.render_views(&mut [], &request).unwrap_err();
            assert!(matches!(refused, Error::NoView), "{refused}");
        }
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
