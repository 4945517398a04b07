//! Objects that do not belong together are refused before anything is recorded, with a helpful
//! message.

use cull::{
    Aabb, Camera, ClipY, CostTable, CullView, DepthConvention, Hierarchy, InvalidView, Projection,
    Strategy, ViewError, ViewProjection,
};
use glam::Vec3;
use gpu::{FrameRing, Readback, Target, Tick, Timeline};
use occlusion::{CulledScene, CulledSceneOptions, DrawRequest};
use render::{
    CostModel, Error, FrameRequest, MAX_FRAMES_IN_FLIGHT, Rect, Renderer, RendererOptions,
    ViewsRequest, object_bounds,
};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::walk::SceneKind;
use tests::{Driver, run};

const SIZE: [u32; 2] = [64, 36];

fn options() -> RendererOptions {
    RendererOptions { size: SIZE, ..Default::default() }
}

#[test]
fn a_view_of_another_renderer_is_refused() {
    run(Driver::Lavapipe, |device| {
        let small = SceneKind::City.build(50).scene;
        let GeneratedScene { scene, routes } = SceneKind::City.build(900);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let few = Renderer::new(device, &small, &options()).unwrap();
        let mut many = Renderer::new(device, &scene, &options()).unwrap();
        let mut foreign = few.new_view().unwrap();
        let mut view = many.new_view().unwrap();
        let request = FrameRequest::new(Strategy::ANTUMBRA, path.camera(0));
        let refused = |error: Error| assert!(error.to_string().contains("another renderer"));
        refused(many.render(&mut foreign, request).unwrap_err());
        refused(many.wait_idle(&mut foreign).unwrap_err());
        let seen = many.view_of(&path.camera(0));
        refused(many.snapshot(&mut foreign, seen).unwrap_err());
        many.render(&mut view, request).unwrap();
        many.wait_idle(&mut view).unwrap();
    });
}

#[test]
fn an_image_of_another_size_is_refused() {
    run(Driver::Lavapipe, |device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(50);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options()).unwrap();
        let mut view = renderer.new_view().unwrap();
        let image = Readback::new(device, [SIZE[0], SIZE[1] + 1]).unwrap();
        let request = FrameRequest {
            image: Some(&image),
            ..FrameRequest::new(Strategy::ANTUMBRA, path.camera(0))
        };
        let refused = renderer.render(&mut view, request).unwrap_err().to_string();
        assert!(refused.contains("64x37") && refused.contains("64x36"), "{refused}");
        renderer.render(&mut view, FrameRequest { image: None, ..request }).unwrap();
        let snapshot = renderer.snapshot(&mut view, renderer.view_of(&path.camera(0))).unwrap();
        assert!(renderer.top_down(&snapshot, &image).is_err());
    });
}

#[test]
fn a_hierarchy_over_other_objects_is_refused() {
    run(Driver::Lavapipe, |device| {
        let scene = SceneKind::City.build(60).scene;
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
            assert!(refused.contains("is not over this scene"), "{refused}");
        }
        // Larger boxes hold the objects, and free leaves leave room for more.
        let larger = bounds.iter().map(|bounds| bounds.enlarged(0.5)).chain([Aabb::EMPTY; 3]);
        let hierarchy = Hierarchy::build(&larger.collect::<Vec<Aabb>>()).unwrap();
        Renderer::with_hierarchy(device, &scene, hierarchy, &options()).unwrap();
    });
}

#[test]
fn options_beyond_all_limits_are_refused_before_anything_is_made() {
    run(Driver::Lavapipe, |device| {
        let scene = SceneKind::Field.build(9).scene;
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
        // More objects than fit the device, at 64 bytes each, but not too many for a hierarchy.
        let most = device.adapter().limits.max_storage_buffer_range as usize / 64;
        let sentence = refused(RendererOptions { spare_objects: most, ..options() });
        let names_limit = sentence.contains(&format!("at most {most} here"));
        assert!(names_limit && sentence.contains("room"), "{sentence}");
        for (value, words) in [(f32::NAN, "is NaN"), (-1.0, "is -1")] {
            let cost_model = CostModel::Table(CostTable { draw_ns: value, ..CostTable::default() });
            let sentence = refused(RendererOptions { cost_model, ..options() });
            assert!(sentence.contains(&format!("`draw_ns` {words}")), "{sentence}");
        }
    });
}

#[test]
fn the_largest_options_that_are_taken_draw_a_frame() {
    run(Driver::Lavapipe, |device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(60);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let largest = RendererOptions {
            frames_in_flight: MAX_FRAMES_IN_FLIGHT,
            query_budget: usize::MAX,
            ..options()
        };
        let mut renderer = Renderer::new(device, &scene, &largest).unwrap();
        let mut view = renderer.new_view().unwrap();
        for frame in 0..2 * MAX_FRAMES_IN_FLIGHT as u32 {
            let request = FrameRequest::new(Strategy::ANTUMBRA, path.camera(frame));
            renderer.render(&mut view, request).unwrap();
        }
        renderer.wait_idle(&mut view).unwrap();
    });
}

#[test]
fn a_frame_without_a_view_is_refused() {
    run(Driver::Lavapipe, |device| {
        let mut renderer =
            Renderer::new(device, &SceneKind::Field.build(9).scene, &options()).unwrap();
        let image = Readback::new(device, SIZE).unwrap();
        for image in [None, Some(&image)] {
            let request =
                ViewsRequest { strategy: Strategy::ANTUMBRA, image, overlay: None, after: None };
            let refused = renderer.render_views(&mut [], &request).unwrap_err();
            assert!(matches!(refused, Error::NoView), "{refused}");
        }
    });
}

/// Returns cameras with a number that is not finite, and the field that has it.
fn impossible_cameras(good: Camera) -> Vec<(Camera, &'static str)> {
    let mut cameras = Vec::new();
    for number in [f32::NAN, f32::INFINITY] {
        cameras.push((Camera { eye: Vec3::X * number, ..good }, "camera.eye"));
        cameras.push((Camera { forward: Vec3::splat(number), ..good }, "camera.forward"));
        cameras.push((Camera { up: Vec3::splat(number), ..good }, "camera.up"));
        cameras.push((Camera { near: number, ..good }, "camera.near"));
        for (projection, field) in [
            (Projection::perspective(number), "camera.projection.fov_y"),
            (Projection::Orthographic { height: number, far: 9.0 }, "camera.projection.height"),
            (Projection::Orthographic { height: 9.0, far: number }, "camera.projection.far"),
        ] {
            cameras.push((Camera { projection, ..good }, field));
        }
    }
    // Each number is finite, and products of them are not.
    cameras.push((Camera { eye: Vec3::splat(3.0e38), ..good }, "view.view_proj"));
    cameras
}

/// Returns true for the refusal of a number in `expected`.
fn is_not_finite(error: &Error, expected: &str) -> bool {
    matches!(error, Error::InvalidView(InvalidView::NotFinite { field }) if *field == expected)
}

/// Returns the reason why a host's view was refused.
fn invalid_view(error: &occlusion::Error) -> Option<InvalidView> {
    match error {
        occlusion::Error::InvalidView(reason) => Some(*reason),
        _ => None,
    }
}

#[test]
fn a_camera_with_impossible_numbers_is_refused_and_the_next_frame_is_right() {
    run(Driver::Lavapipe, |device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(50);
        let camera = CameraPath::new(PathKind::Street, &routes).unwrap().camera(0);
        let mut renderer = Renderer::new(device, &scene, &options()).unwrap();
        let mut view = renderer.new_view().unwrap();
        let image = Readback::new(device, SIZE).unwrap();
        let good =
            FrameRequest { image: Some(&image), ..FrameRequest::new(Strategy::ANTUMBRA, camera) };
        renderer.render(&mut view, good).unwrap();
        device.wait_idle().unwrap();
        let before = image.rgba8().unwrap().to_vec();
        let seen = renderer.view_of(&camera);
        let snapshot = renderer.snapshot(&mut view, seen).unwrap();
        for (bad, field) in impossible_cameras(camera) {
            for strategy in [Strategy::ANTUMBRA, Strategy::FRUSTUM] {
                let request = FrameRequest::new(strategy, bad);
                let error = renderer.render(&mut view, request).unwrap_err();
                assert!(is_not_finite(&error, field), "{field}: {error}");
            }
            if field.starts_with("camera") {
                let error = renderer.render_snapshot(&snapshot, bad, None, None).unwrap_err();
                assert!(is_not_finite(&error, field), "{field}: {error}");
            }
        }
        let depth = DepthConvention::Reversed;
        let mut matrix = ViewProjection { matrix: seen.view_proj, depth, y: ClipY::Down };
        matrix.matrix.w_axis.x = f32::NAN;
        let error = renderer.render(&mut view, matrix).unwrap_err();
        assert!(matches!(error, Error::CullView(ViewError::NotFinite { .. })), "{error}");
        let broken = CullView { anchor: Vec3::NAN, ..seen };
        let error = renderer.snapshot(&mut view, broken).unwrap_err();
        assert!(is_not_finite(&error, "view.anchor"), "{error}");
        let nothing = Rect { origin: [0, 0], size: [0, 8] };
        let error = renderer.view_in(camera, nothing).unwrap_err();
        let expected = InvalidView::NoPixels { size: [0, 8] };
        assert!(matches!(error, Error::InvalidView(found) if found == expected), "{error}");
        renderer.render(&mut view, good).unwrap();
        device.wait_idle().unwrap();
        assert!(*image.rgba8().unwrap() == before);
    });
}

#[test]
fn a_view_of_a_host_with_impossible_numbers_is_refused() {
    run(Driver::Lavapipe, |device| {
        let target = Target::new(device, SIZE, "views").unwrap();
        let attachments = target.attachments();
        let mut scene =
            CulledScene::new(device, attachments, &CulledSceneOptions::default()).unwrap();
        let mut state = scene.new_view(&target).unwrap();
        let mut other = scene.new_view(&target).unwrap();
        let mut frames = FrameRing::new(device, 2).unwrap();
        let good = CullView::new(&Camera::look_at([0.0, 0.0, 5.0], [0.0; 3]), SIZE, 8);
        let mut nan = good;
        nan.view_proj.y_axis.y = f32::NAN;
        for (bad, expected) in [
            (nan, InvalidView::NotFinite { field: "view.view_proj" }),
            (
                CullView { anchor: Vec3::INFINITY, ..good },
                InvalidView::NotFinite { field: "view.anchor" },
            ),
            (CullView { size: [0, 0], ..good }, InvalidView::NoPixels { size: [0, 0] }),
        ] {
            let frame = frames.begin().unwrap();
            let mut scope = scene.begin(frame).unwrap();
            let refused = scope.plan(&mut state, &bad).err().unwrap();
            assert_eq!(invalid_view(&refused), Some(expected), "{refused}");
            drop(scope);
            let mut scope = scene.begin(frames.begin().unwrap()).unwrap();
            let views = [(&mut other, DrawRequest::from(&good)), (&mut state, (&bad).into())];
            let refused = scope.plan_all(views, 100).err().unwrap();
            assert_eq!(invalid_view(&refused), Some(expected), "{refused}");
        }
        // The next frame is planned.
        let mut scope = scene.begin(frames.begin().unwrap()).unwrap();
        assert!(scope.plan(&mut state, &good).is_ok());
    });
}

#[test]
fn outcomes_that_nobody_takes_are_kept_within_bounds() {
    run(Driver::Lavapipe, |device| {
        let GeneratedScene { scene, routes } = SceneKind::Field.build(3);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let tiny = RendererOptions { size: [4, 4], ..options() };
        let mut renderer = Renderer::new(device, &scene, &tiny).unwrap();
        let mut view = renderer.new_view().unwrap();
        for _ in 0..1_100 {
            let request = FrameRequest::new(Strategy::FRUSTUM, path.camera(0));
            renderer.render(&mut view, request).unwrap();
        }
        renderer.wait_idle(&mut view).unwrap();
        let outcomes: Vec<u64> = view.drain_stats().map(|outcome| outcome.frame.0).collect();
        assert_eq!(outcomes, (77..=1_100).collect::<Vec<u64>>());
    });
}

#[test]
fn an_image_is_read_when_its_frame_is_over_and_not_before() {
    run(Driver::Lavapipe, |device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(50);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options()).unwrap();
        let mut view = renderer.new_view().unwrap();
        let image = Readback::new(device, SIZE).unwrap();
        let is_refused = |what: &str| {
            let refused = image.rgba8().err().expect(what);
            assert!(matches!(refused, gpu::Error::NoImage), "{what}: {refused}");
        };
        let gate = Timeline::new(device, "gate").unwrap();
        let request = |number: u32, after| FrameRequest {
            image: Some(&image),
            after,
            ..FrameRequest::new(Strategy::ANTUMBRA, path.camera(number))
        };
        is_refused("never written");
        let waits = device.wait_counts().other;
        let held_back = request(0, Some(gate.at(Tick(1))));
        let tick = renderer.render(&mut view, held_back).unwrap().tick;
        is_refused("on its way");
        assert_eq!(device.wait_counts().other, waits, "nobody waits for an image");
        gate.signal(Tick(1)).unwrap();
        renderer.wait_idle(&mut view).unwrap();
        assert!(device.completed().unwrap() >= tick);
        let first = image.rgba8().unwrap();

        // During a read, frames must not write, and the image stays the same.
        let before = first.to_vec();
        let refused = renderer.render(&mut view, request(40, None)).unwrap_err().to_string();
        assert!(refused.contains("that is being read"), "{refused}");
        device.wait_idle().unwrap();
        assert!(*first == before);
        drop(first);

        // Written again: first the image is not ready, then it is a new one.
        renderer.render(&mut view, request(40, Some(gate.at(Tick(2))))).unwrap();
        is_refused("on its way again");
        gate.signal(Tick(2)).unwrap();
        renderer.wait_idle(&mut view).unwrap();
        assert!(*image.rgba8().unwrap() != before);

        // Dropped while in flight.
        let early = Readback::new(device, SIZE).unwrap();
        let last = FrameRequest {
            image: Some(&early),
            ..FrameRequest::new(Strategy::ANTUMBRA, path.camera(0))
        };
        renderer.render(&mut view, last).unwrap();
        drop(early);
        renderer.wait_idle(&mut view).unwrap();
    });
}

#[test]
fn an_image_whose_frame_was_given_up_is_never_there() {
    run(Driver::Lavapipe, |device| {
        let image = Readback::new(device, SIZE).unwrap();
        let mut target = gpu::Target::new(device, SIZE, "target").unwrap();
        let mut ring = gpu::FrameRing::new(device, 1).unwrap();
        let mut draw = |is_submitted: bool| {
            let frame = ring.begin().unwrap();
            target.prepare(frame.commands());
            frame.commands().rendering(target.render_target(Some([1.0; 4])), |_| {});
            target.copy_to(frame.commands(), &image);
            if is_submitted {
                frame.submit(None).unwrap();
                device.wait_idle().unwrap();
            }
        };
        draw(false);
        device.wait_idle().unwrap();
        assert!(matches!(image.rgba8(), Err(gpu::Error::NoImage)));
        draw(true);
        assert!(image.rgba8().unwrap().iter().all(|byte| *byte == 255));
        draw(false);
        assert!(matches!(image.rgba8(), Err(gpu::Error::NoImage)), "the newest was given up");
    });
}

/// Checks that only one of two open frames may copy an image to the same place. The older frame
/// could be submitted last, and overwrite data that are read after the newer one.
#[test]
fn of_two_open_frames_one_copies_a_image_to_the_same_place() {
    run(Driver::Lavapipe, |device| {
        let image = Readback::new(device, SIZE).unwrap();
        let mut target = gpu::Target::new(device, SIZE, "target").unwrap();
        let mut rings = [(); 2].map(|()| gpu::FrameRing::new(device, 1).unwrap());
        let [first, second] = &mut rings;
        let mut draw = |frame: &gpu::Frame, colour| {
            target.prepare(frame.commands());
            frame.commands().rendering(target.render_target(Some([colour; 4])), |_| {});
            target.copy_to(frame.commands(), &image);
        };
        let older = first.begin().unwrap();
        draw(&older, 0.0);
        let newer = second.begin().unwrap();
        draw(&newer, 1.0);
        let refused = newer.submit(None).unwrap_err().to_string();
        assert!(refused.contains("two frames that are both open"), "{refused}");
        older.submit(None).unwrap();
        device.wait_idle().unwrap();
        assert_eq!(image.rgba8().unwrap()[..4], [0; 4], "the older one's");
        // When no frame is open any more, the next frame may copy.
        let newer = second.begin().unwrap();
        draw(&newer, 1.0);
        newer.submit(None).unwrap();
        device.wait_idle().unwrap();
        assert_eq!(image.rgba8().unwrap()[..4], [255; 4]);
    });
}
