//! The ideal strategy is a correct yardstick: its image equals the full image, and none of its
//! draws can be left out.

use cull::{Aabb, Camera, CullConfig, CullTuning, ObjectId, Projection, Strategy};
use glam::Vec3;
use gpu::Readback;
use render::{CostModel, FrameRequest, Rect, Renderer, RendererOptions};
use scene::ObjectChange;
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::shapes::{box_at, box_scene, square_camera};
use tests::walk::{SceneKind, images_that_differ};
use tests::{Driver, run, run_on_all};

const SIZE: [u32; 2] = [160, 90];
const AREA: Rect = Rect { origin: [0, 0], size: SIZE };

#[test]
fn the_ideal_is_exact_and_draws_only_what_owns_a_pixel() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(600);
        let path = CameraPath::new(PathKind::Cut, &routes).unwrap();
        let options = RendererOptions { methods: methods::all(), size: SIZE, ..Default::default() };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let mut finder = renderer.new_view().unwrap();
        let mut view = renderer.new_view().unwrap();
        let [expected, got] = [(); 2].map(|()| Readback::new(device, SIZE).unwrap());
        for frame in [0, 1, 9, 10, 20] {
            let camera = path.camera(frame);
            let set = renderer.visible_set(&mut finder, camera, AREA).unwrap();
            let request = |strategy, image| FrameRequest {
                visible: Some(&set),
                image: Some(image),
                ..FrameRequest::new(strategy, camera)
            };
            let all = request(Strategy::FRUSTUM, &expected);
            let in_frustum = renderer.render(&mut view, all).unwrap().plan.visible;
            renderer.render(&mut view, request(methods::IDEAL, &got)).unwrap();
            renderer.wait_idle(&mut view).unwrap();
            assert_eq!(images_that_differ(&expected, &got), 0, "frame {frame}");
            assert!((set.leaves().len() as u32) < in_frustum, "frame {frame}");

            let again = renderer.visible_set(&mut finder, camera, AREA).unwrap();
            assert_eq!(again, set, "frame {frame}: the past of the finder must not matter");
        }
    });
}

#[test]
fn the_ideal_without_a_set_is_refused() {
    run(Driver::Lavapipe, |device| {
        let GeneratedScene { scene, routes } = SceneKind::Field.build(20);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let options = RendererOptions { methods: methods::all(), size: SIZE, ..Default::default() };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let mut view = renderer.new_view().unwrap();
        let request = FrameRequest::new(methods::IDEAL, path.camera(0));
        let refused = renderer.render(&mut view, request).unwrap_err().to_string();
        assert!(refused.contains("Renderer::visible_set"), "{refused}");
        renderer.render(&mut view, FrameRequest::new(Strategy::ANTUMBRA, path.camera(0))).unwrap();
        renderer.wait_idle(&mut view).unwrap();
        let set = renderer.visible_set(&mut view, path.camera(0), AREA).unwrap();
        let request = FrameRequest { visible: Some(&set), ..request };
        renderer.update(&[]).unwrap();
        renderer.render(&mut view, request).unwrap();
        renderer.update(&[ObjectChange::Remove { object: ObjectId(3) }]).unwrap();
        let refused = renderer.render(&mut view, request).unwrap_err().to_string();
        assert!(refused.contains("has changed"), "{refused}");
        renderer.wait_idle(&mut view).unwrap();
    });
}

/// Checks that the set is complete if more boxes show at once than the list of enabled draws holds.
/// The boxes lie in layers, so that tests share proxies.
#[test]
fn the_ideal_is_whole_where_more_shows_than_can_be_listed() {
    run_on_all(|device| {
        const COLUMNS: usize = 72;
        const ROWS: usize = 40;
        let boxes: Vec<Aabb> = (0..COLUMNS * ROWS * 3)
            .map(|number| {
                let layer = number / (COLUMNS * ROWS);
                let place = number % (COLUMNS * ROWS);
                // Each layer shows through the gaps of the previous one.
                let aside = 0.4 * layer as f32;
                let x = (place % COLUMNS) as f32 - 35.5 + aside;
                let y = (place / COLUMNS) as f32 - 19.5;
                let depth = 30.0 + 9.0 * layer as f32 + 0.001 * (place % 7) as f32;
                let spread = 0.8 * depth / 30.0;
                let centre = Vec3::new(x * spread, y * spread, -depth);
                box_at(centre, Vec3::new(0.27, 0.27, 0.1))
            })
            .collect();
        let camera = Camera { projection: Projection::perspective(1.0), ..square_camera() };
        let wall = box_at(camera.eye - 5.0 * camera.forward, Vec3::new(50.0, 50.0, 0.1));
        let hiding = Camera { eye: camera.eye - 10.0 * camera.forward, ..camera };
        let scene = box_scene(&[boxes, vec![wall]].concat());
        let size = [288, 162];
        // Proxies of up to 32 leaves are shared by tests of leaves that show partly through the
        // gaps.
        let tuning = CullTuning { growth_frames_per_leaf: 4, ..Default::default() };
        let cull_config = CullConfig { tuning, ..Default::default() };
        // Tests are not left out because of costs.
        let options = RendererOptions {
            methods: methods::all(),
            size,
            cull_config,
            cost_model: CostModel::Off,
            ..Default::default()
        };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let mut finder = renderer.new_view().unwrap();
        let mut view = renderer.new_view().unwrap();
        let [expected, got] = [(); 2].map(|()| Readback::new(device, size).unwrap());
        // Only hidden nodes share their proxies. Seen from behind the wall, all are hidden.
        for _ in 0..9 {
            let set = renderer.visible_set(&mut finder, hiding, Rect::whole(size)).unwrap();
            assert_eq!(set.leaves().len(), 1);
        }
        let set = renderer.visible_set(&mut finder, camera, Rect::whole(size)).unwrap();
        assert!(set.leaves().len() > gpu::LISTED_LEAVES, "only {} show", set.leaves().len());
        assert!(finder.plan().stats.shared_proxies > 10, "no test answered for another");
        let again = renderer.visible_set(&mut finder, camera, Rect::whole(size)).unwrap();
        assert_eq!(again.leaves().len(), set.leaves().len(), "now most of it is drawn untested");
        for (strategy, image) in [(Strategy::FRUSTUM, &expected), (methods::IDEAL, &got)] {
            let request = FrameRequest {
                visible: Some(&set),
                image: Some(image),
                ..FrameRequest::new(strategy, camera)
            };
            renderer.render(&mut view, request).unwrap();
        }
        renderer.wait_idle(&mut view).unwrap();
        assert_eq!(images_that_differ(&expected, &got), 0);
    });
}
