//! Several views in one frame: each is exact, with its own history and part of the image.

use cull::{Camera, Projection, Strategy};
use glam::Vec3;
use gpu::{Device, PredicationMode, Readback};
use render::{
    CostModel, FrameReport, FrameRequest, Rect, RenderView, Renderer, RendererOptions, ViewRequest,
    ViewsRequest, VisibleSet,
};
use scenes::{CameraPath, Cast, GeneratedScene, Motion, PathKind};
use tests::walk::{SceneKind, images_that_differ, pixels_that_differ, show_motion};
use tests::{Driver, run, run_on_all};

const SIZE: [u32; 2] = [320, 100];

fn options(frames_in_flight: usize) -> RendererOptions {
    // Measured costs differ from run to run; without costs, everything is tested.
    RendererOptions {
        methods: methods::all(),
        size: SIZE,
        frames_in_flight,
        cost_model: CostModel::Off,
        ..Default::default()
    }
}

/// Returns the eyes of a stereo pair.
fn pair(camera: Camera) -> [Camera; 2] {
    let right = camera.forward.cross(camera.up).normalize();
    [-0.0325, 0.0325].map(|aside| Camera { eye: camera.eye + right * aside, ..camera })
}

/// Renders a frame with one view per camera, in `areas`.
fn render(
    renderer: &mut Renderer,
    histories: &mut [RenderView],
    strategy: Strategy,
    cameras: &[Camera],
    areas: &[Rect],
    image: &Readback,
) -> FrameReport {
    let mut eyes: Vec<ViewRequest<'_>> = histories
        .iter_mut()
        .zip(cameras)
        .zip(areas)
        .map(|((history, camera), area)| ViewRequest {
            state: history,
            viewpoint: (*camera).into(),
            visible: None,
            rect: *area,
        })
        .collect();
    let request = ViewsRequest { strategy, image: Some(image), overlay: None, after: None };
    renderer.render_views(&mut eyes, &request).unwrap()
}

/// Walks with a stereo pair and compares every image with that of frustum culling.
fn check_pair(
    device: &Device,
    scene: &GeneratedScene,
    path: PathKind,
    percent: u32,
    options: &RendererOptions,
    frames: u32,
) {
    check_pair_with(device, Strategy::ANTUMBRA, scene, path, percent, options, frames);
}

fn check_pair_with(
    device: &Device,
    strategy: Strategy,
    GeneratedScene { scene, routes }: &GeneratedScene,
    path: PathKind,
    percent: u32,
    options: &RendererOptions,
    frames: u32,
) {
    let path = CameraPath::new(path, routes).unwrap();
    let motion = Motion::new(scene, percent, 3).unwrap();
    let mut renderer = Renderer::new(device, scene, options).unwrap();
    let mut cast = Cast::new(&motion);
    let areas: Vec<Rect> = Rect::side_by_side(SIZE, 2).collect();
    let [expected, got] = [Strategy::FRUSTUM, strategy].map(|strategy| {
        let mut views = [(); 2].map(|()| renderer.new_view().unwrap());
        let waits = renderer.device().wait_counts().other;
        let images: Vec<Readback> = (0..frames)
            .map(|frame| {
                show_motion(&mut renderer, &motion, &mut cast, frame).unwrap();
                let image = Readback::new(device, SIZE).unwrap();
                let cameras = pair(path.camera(frame));
                render(&mut renderer, &mut views, strategy, &cameras, &areas, &image);
                image
            })
            .collect();
        let waited = renderer.device().wait_counts().other - waits;
        assert_eq!(waited > 0, strategy.is_blocking(), "{strategy} waited for {waited} answers");
        let mut draws = 0;
        for view in &mut views {
            renderer.wait_idle(view).unwrap();
            draws += view.drain_stats().map(|outcome| outcome.draws).sum::<u64>();
        }
        (images, draws)
    });
    for (frame, (expected, got)) in expected.0.iter().zip(&got.0).enumerate() {
        let wrong = images_that_differ(expected, got);
        assert_eq!(wrong, 0, "{strategy}, frame {frame}, {percent} % move");
    }
    assert!(got.1 * 10 < expected.1 * 9, "{strategy}: {} of {} drawn", got.1, expected.1);
}

#[test]
fn a_stereo_pair_is_exact() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(900);
        check_pair(device, &scene, PathKind::Street, 0, &options(1), 10);
        check_pair(device, &scene, PathKind::Cut, 0, &options(3), 14);
    });
}

#[test]
#[ignore = "long walk"]
fn a_stereo_pair_is_exact_with_every_tester() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(1_000);
        for strategy in [
            methods::NAIVE,
            methods::BATCHED,
            methods::STOP_AND_WAIT,
            methods::CHC,
            methods::HZB,
            Strategy::ANTUMBRA_QUERIES,
            Strategy::ANTUMBRA_FLAGS,
            Strategy::ANTUMBRA_COMPUTE,
        ] {
            for path in [PathKind::Street, PathKind::Cut] {
                check_pair_with(device, strategy, &scene, path, 20, &options(2), 20);
            }
        }
    });
}

/// Checks that each eye of a pair draws exactly its own visible set, in an image of odd width.
#[test]
fn each_eye_has_an_ideal_of_its_own() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(800);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let size = [321, 100];
        let options = RendererOptions { size, ..options(2) };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let areas: Vec<Rect> = Rect::side_by_side(size, 2).collect();
        let mut views = [(); 2].map(|()| renderer.new_view().unwrap());
        let mut ideals = [(); 2].map(|()| renderer.new_view().unwrap());
        let mut plain = [(); 2].map(|()| renderer.new_view().unwrap());
        let [expected, got] = [(); 2].map(|()| Readback::new(device, size).unwrap());
        for frame in 0..4 {
            let cameras = [path.camera(frame), path.camera(frame + 400)];
            let sets: Vec<VisibleSet> = (0..2)
                .map(|eye| renderer.visible_set(&mut views[eye], cameras[eye], areas[eye]).unwrap())
                .collect();
            render(&mut renderer, &mut plain, Strategy::FRUSTUM, &cameras, &areas, &expected);
            let mut eyes: Vec<ViewRequest<'_>> = ideals
                .iter_mut()
                .enumerate()
                .map(|(eye, history)| ViewRequest {
                    state: history,
                    viewpoint: cameras[eye].into(),
                    visible: Some(&sets[eye]),
                    rect: areas[eye],
                })
                .collect();
            let request = ViewsRequest {
                strategy: methods::IDEAL,
                image: Some(&got),
                overlay: None,
                after: None,
            };
            renderer.render_views(&mut eyes, &request).unwrap();
            device.wait_idle().unwrap();
            assert_eq!(images_that_differ(&expected, &got), 0, "frame {frame}");
            assert_ne!(sets[0], sets[1]);
        }
    });
}

#[test]
#[ignore = "long walk"]
fn a_stereo_pair_is_exact_while_objects_move() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(1_200);
        for percent in [10, 100] {
            check_pair(device, &scene, PathKind::Street, percent, &options(2), 20);
        }
    });
}

#[test]
fn every_way_to_skip_draws_knows_its_view() {
    run(Driver::Lavapipe, |device| {
        let scene = SceneKind::City.build(800);
        for predication in PredicationMode::ALL {
            let options = RendererOptions { predication: Some(predication), ..options(2) };
            check_pair(device, &scene, PathKind::Cut, 20, &options, 14);
        }
    });
}

/// Checks four views that look in all directions, in overlapping parts of all sizes.
#[test]
fn areas_may_be_anywhere() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(900);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options(2)).unwrap();
        let area = |x, y, width, height| Rect { origin: [x, y], size: [width, height] };
        let areas =
            [area(0, 0, 320, 100), area(5, 3, 77, 41), area(300, 0, 20, 100), area(9, 60, 1, 1)];
        let mut views = [(); 4].map(|()| renderer.new_view().unwrap());
        let mut plain = [(); 4].map(|()| renderer.new_view().unwrap());
        let [expected, got] = [(); 2].map(|()| Readback::new(device, SIZE).unwrap());
        for frame in 0..10 {
            let cameras: Vec<Camera> = (0..4).map(|eye| path.camera(frame + 211 * eye)).collect();
            render(&mut renderer, &mut plain, Strategy::FRUSTUM, &cameras, &areas, &expected);
            let report =
                render(&mut renderer, &mut views, Strategy::ANTUMBRA, &cameras, &areas, &got);
            let queries: usize = views.iter().map(|view| view.plan().query_count()).sum();
            assert_eq!(report.queries as usize, queries, "a report is of all views");
            device.wait_idle().unwrap();
            assert_eq!(images_that_differ(&expected, &got), 0, "frame {frame}");
        }
    });
}

/// Checks that the faces of a cube, and the parts of a split screen, share a small budget of
/// queries and have exact images.
#[test]
fn views_on_one_tight_budget_are_exact() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(900);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let split = |frame, part: u32| path.camera(frame + 173 * part);
        let faces = |frame, part: u32| face(path.camera(frame), part as usize);
        // The budget, and the least number of queries that the view with most queries must have.
        let cases: [([usize; 2], PartCamera<'_>); 2] = [([100, 21], &faces), ([48, 8], &split)];
        for ([query_budget, least], camera) in cases {
            let options = RendererOptions { query_budget, ..options(2) };
            let mut renderer = Renderer::new(device, &scene, &options).unwrap();
            let mut views = [(); 6].map(|()| renderer.new_view().unwrap());
            let mut plain = [(); 6].map(|()| renderer.new_view().unwrap());
            let areas: Vec<Rect> = Rect::side_by_side(SIZE, 6).collect();
            let [expected, got] = [(); 2].map(|()| Readback::new(device, SIZE).unwrap());
            let mut most = 0;
            let mut largest = 0;
            for frame in 0..10 {
                let cameras: Vec<Camera> = (0..6).map(|part| camera(frame, part)).collect();
                render(&mut renderer, &mut plain, Strategy::FRUSTUM, &cameras, &areas, &expected);
                let strategy = Strategy::ANTUMBRA_QUERIES;
                let report = render(&mut renderer, &mut views, strategy, &cameras, &areas, &got);
                device.wait_idle().unwrap();
                let wrong = images_that_differ(&expected, &got);
                assert_eq!(wrong, 0, "frame {frame}, {query_budget} queries");
                let used = views.each_ref().map(|view| view.plan().query_count());
                assert_eq!(report.queries as usize, used.iter().sum::<usize>());
                assert!(report.queries as usize <= query_budget, "{used:?} of {query_budget}");
                most = most.max(report.queries as usize);
                largest = largest.max(used.into_iter().max().unwrap_or(0));
            }
            assert!(most * 10 > query_budget * 9, "{most} of {query_budget} queries were used");
            assert!(largest >= least, "nothing was passed on: {largest}");
        }
    });
}

/// The camera of a frame and a part of the image.
type PartCamera<'a> = &'a dyn Fn(u32, u32) -> Camera;

/// Returns the camera of a face of the cube around a camera.
fn face(camera: Camera, number: usize) -> Camera {
    let forward = [Vec3::NEG_Z, Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z][number];
    let up = if forward.y == 0.0 { Vec3::Y } else { Vec3::X };
    let projection = Projection::perspective(std::f32::consts::FRAC_PI_2);
    Camera { forward, up, projection, ..camera }
}

/// Checks that a view has the same plan and pixels alone and together with other views. (In another
/// place of the image a device may round differently.)
#[test]
fn a_view_does_not_notice_the_others() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(900);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let half = [SIZE[0] / 2, SIZE[1]];
        // Plans are compared, so costs must not be measured.
        let options = options(2);
        let mut both = Renderer::new(device, &scene, &options).unwrap();
        let alone_options = RendererOptions { size: half, ..options };
        let mut alone = Renderer::new(device, &scene, &alone_options).unwrap();
        let mut views = [(); 2].map(|()| both.new_view().unwrap());
        let mut single = alone.new_view().unwrap();
        let areas: Vec<Rect> = Rect::side_by_side(SIZE, 2).collect();
        let pair_image = Readback::new(device, SIZE).unwrap();
        let image = Readback::new(device, half).unwrap();
        for frame in 0..10 {
            let cameras = [path.camera(frame), path.camera(500 + frame)];
            render(&mut both, &mut views, Strategy::ANTUMBRA, &cameras, &areas, &pair_image);
            let request = FrameRequest {
                image: Some(&image),
                ..FrameRequest::new(Strategy::ANTUMBRA, cameras[0])
            };
            alone.render(&mut single, request).unwrap();
            device.wait_idle().unwrap();
            let row_bytes = SIZE[0] as usize * 4;
            let pixels = pair_image.rgba8().unwrap();
            let rows = pixels.chunks_exact(row_bytes);
            let left: Vec<u8> = rows.flat_map(|row| row[..row_bytes / 2].to_vec()).collect();
            assert_eq!(pixels_that_differ(&left, &image.rgba8().unwrap()), 0, "frame {frame}");
            assert_eq!(views[0].plan().stats, single.plan().stats, "frame {frame}");
            assert_eq!(views[0].plan().draws, single.plan().draws, "frame {frame}");
        }
    });
}

#[test]
fn areas_outside_of_the_image_are_refused() {
    run(Driver::Lavapipe, |device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(50);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options(2)).unwrap();
        let mut view = renderer.new_view().unwrap();
        for (origin, size) in [
            ([0, 0], [321, 100]),
            ([0, 0], [320, 0]),
            ([160, 1], [160, 100]),
            ([u32::MAX, 0], [1, 1]),
            ([1, 0], [u32::MAX, 1]),
        ] {
            let area = Rect { origin, size };
            let camera = path.camera(0);
            let mut eyes = [ViewRequest {
                state: &mut view,
                viewpoint: camera.into(),
                visible: None,
                rect: area,
            }];
            let request = ViewsRequest {
                strategy: Strategy::ANTUMBRA,
                image: None,
                overlay: None,
                after: None,
            };
            let error = renderer.render_views(&mut eyes, &request).unwrap_err().to_string();
            assert!(error.contains("not within the image of 320x100"), "{error}");
        }
    });
}
