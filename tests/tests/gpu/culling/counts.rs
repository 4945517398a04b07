//! Visible samples of single objects: counted exactly, read back late without a wait, and never
//! assigned to another object.

use cull::{Aabb, Camera, ObjectId, Strategy};
use glam::{Affine3A, Vec3};
use gpu::{Device, PredicationMode, Readback};
use render::{
    CostModel, FrameRequest, Rect, RenderView, Renderer, RendererOptions, ViewRequest,
    ViewsRequest, VisibleSamples,
};
use scene::{MeshId, Object, ObjectChange, pack_unorm};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::run_on_all;
use tests::shapes::{box_at, box_scene, square_camera};
use tests::walk::{SceneKind, pixels_that_differ};

const SIZE: [u32; 2] = [128, 128];

fn options() -> RendererOptions {
    // Measured costs differ from run to run; without costs, everything is tested.
    RendererOptions {
        methods: methods::all(),
        size: SIZE,
        cost_model: CostModel::Off,
        ..Default::default()
    }
}

fn renderer(device: &Device, boxes: &[Aabb], options: &RendererOptions) -> Renderer {
    Renderer::new(device, &box_scene(boxes), options).unwrap()
}

fn frame(renderer: &mut Renderer, view: &mut RenderView, strategy: Strategy, camera: Camera) {
    renderer.render(view, FrameRequest::new(strategy, camera)).unwrap();
}

fn of(view: &RenderView, object: u32) -> Option<VisibleSamples> {
    view.visible_samples().iter().find(|known| known.object == ObjectId(object)).copied()
}

/// Returns the image of plain frustum culling.
fn image(renderer: &mut Renderer, camera: Camera) -> Vec<u8> {
    let mut view = renderer.new_view().unwrap();
    let image = Readback::new(renderer.device(), SIZE).unwrap();
    let request =
        FrameRequest { image: Some(&image), ..FrameRequest::new(Strategy::FRUSTUM, camera) };
    renderer.render(&mut view, request).unwrap();
    renderer.wait_idle(&mut view).unwrap();
    image.rgba8().unwrap().to_vec()
}

/// The objects of [`half_covered`] behind the two walls: one half hidden, one hidden, a floor that
/// reaches behind the eye, and an object behind the eye.
const HALF: u32 = 2;
const HIDDEN: u32 = 3;
const FLOOR: u32 = 4;
const BEHIND: u32 = 5;

fn half_covered() -> Vec<Aabb> {
    vec![
        Aabb::new(Vec3::new(-2.0, -1.5, -5.1), Vec3::new(0.0, 2.0, -5.0)),
        Aabb::new(Vec3::new(2.0, 2.0, -5.1), Vec3::new(4.0, 4.0, -5.0)),
        box_at(Vec3::new(0.0, 0.3, -10.0), Vec3::new(1.5, 1.2, 1.0)),
        box_at(Vec3::new(5.0, 5.0, -9.0), Vec3::splat(0.4)),
        Aabb::new(Vec3::new(-3.0, -2.5, -30.0), Vec3::new(3.0, -2.0, 30.0)),
        box_at(Vec3::new(0.0, 0.0, 20.0), Vec3::ONE),
    ]
}

/// Returns the number of pixels that change when an object is removed.
fn pixels_of(renderer: &mut Renderer, object: u32, camera: Camera) -> u32 {
    let whole = image(renderer, camera);
    renderer.update(&[ObjectChange::Remove { object: ObjectId(object) }]).unwrap();
    pixels_that_differ(&whole, &image(renderer, camera)) as u32
}

/// Returns every strategy that the device supports.
fn strategies(renderer: &Renderer) -> impl Iterator<Item = Strategy> {
    methods::strategies().into_iter().filter(|strategy| renderer.supports(*strategy).is_ok())
}

#[test]
fn counts_are_pixels_with_every_strategy() {
    run_on_all(|device| {
        let camera = square_camera();
        let mut other = renderer(device, &half_covered(), &options());
        let expected = pixels_of(&mut other, HALF, camera);
        assert!(expected > 100, "{expected}");
        let mut renderer = renderer(device, &half_covered(), &options());
        for strategy in strategies(&renderer).collect::<Vec<_>>() {
            let mut finder = renderer.new_view().unwrap();
            let visible = renderer.visible_set(&mut finder, camera, Rect::whole(SIZE)).unwrap();
            let mut view = renderer.new_view().unwrap();
            let watched = [HIDDEN, HALF, FLOOR, BEHIND, 99];
            view.watch(&watched.map(ObjectId)).unwrap();
            assert_eq!(view.visible_samples(), []);
            let waits = device.wait_counts().other;
            for number in 1..=8_u64 {
                let request =
                    FrameRequest { visible: Some(&visible), ..FrameRequest::new(strategy, camera) };
                renderer.render(&mut view, request).unwrap();
                for known in view.visible_samples() {
                    assert_eq!(known.frame.0 + known.age_frames, number, "{strategy}");
                    assert_eq!(known.age_frames == 0, known.object == ObjectId(BEHIND));
                    assert!(known.age_frames <= 2, "{strategy}: {known:?}");
                }
                let known = view.visible_samples().len();
                assert!(number <= 2 || known == 4, "{strategy}, frame {number}: {known}");
            }
            let has_waited = device.wait_counts().other > waits;
            assert!(!has_waited || strategy.is_blocking(), "{strategy} waited");

            let half = of(&view, HALF).unwrap();
            assert_eq!(half.samples, expected, "{strategy}");
            let proxy = half.proxy.unwrap();
            assert!(proxy.visible >= expected && proxy.total > proxy.visible, "{half:?}");
            assert!((half.fraction().unwrap() - 0.5).abs() < 0.05, "{strategy}: {half:?}");
            let hidden = of(&view, HIDDEN).unwrap();
            assert_eq!((hidden.samples, hidden.fraction()), (0, Some(0.0)), "{strategy}");
            assert!(hidden.proxy.unwrap().total > 10);
            let floor = of(&view, FLOOR).unwrap();
            assert!(floor.samples > 1_000 && floor.proxy.is_none(), "{strategy}: {floor:?}");
            let behind = of(&view, BEHIND).unwrap();
            assert_eq!((behind.samples, behind.proxy), (0, None), "{strategy}");
            renderer.wait_idle(&mut view).unwrap();
            assert_eq!(of(&view, HALF).unwrap().age_frames, 0);
        }
    });
}

/// Checks that the samples of all objects together are the pixels that are not sky.
#[test]
fn counts_of_all_objects_add_up_to_the_image() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(300);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let all: Vec<ObjectId> = (0..scene.objects.len() as u32).map(ObjectId).collect();
        for predication in
            [PredicationMode::Counts, PredicationMode::Instances, PredicationMode::Compacted]
        {
            let options = RendererOptions { predication: Some(predication), ..options() };
            let Ok(mut renderer) = Renderer::new(device, &scene, &options) else { continue };
            let mut finder = renderer.new_view().unwrap();
            for strategy in [Strategy::ANTUMBRA_QUERIES, methods::HZB, Strategy::FRUSTUM] {
                let mut view = renderer.new_view().unwrap();
                view.watch(&all).unwrap();
                let camera = path.camera(10);
                for _ in 0..4 {
                    frame(&mut renderer, &mut view, strategy, camera);
                }
                renderer.wait_idle(&mut view).unwrap();
                let set = renderer.visible_set(&mut finder, camera, Rect::whole(SIZE)).unwrap();
                let shown = view.visible_samples().iter().filter(|known| known.samples > 0);
                assert_eq!(shown.count(), set.leaves().len(), "{strategy}");
                let samples = view.visible_samples().iter().map(|known| known.samples);
                let samples: u32 = samples.sum();
                // A pixel in which two faces of an object meet may count twice.
                let pixels = SIZE[0] * SIZE[1];
                assert!((pixels / 3..=pixels + pixels / 20).contains(&samples), "{samples}");
                for known in view.visible_samples() {
                    let proxy = known.proxy.unwrap_or_default();
                    assert!(proxy.visible <= proxy.total, "{known:?}");
                    assert!(known.samples == 0 || known.fraction() != Some(0.0), "{known:?}");
                }
            }
        }
    });
}

#[test]
fn each_view_counts_what_it_sees() {
    run_on_all(|device| {
        let mut renderer = renderer(device, &half_covered(), &options());
        for strategy in [Strategy::ANTUMBRA, methods::HZB, methods::CHC] {
            let mut histories = [(); 2].map(|()| renderer.new_view().unwrap());
            for history in &mut histories {
                history.watch(&[ObjectId(HALF)]).unwrap();
            }
            // The second eye looks past the wall, into an area that overlaps the first one's.
            let camera = square_camera();
            let cameras = [camera, Camera { eye: Vec3::new(5.0, 0.0, 0.0), ..camera }];
            let areas = [0, 32].map(|x| Rect { origin: [x, 0], size: [96, 96] });
            for _ in 0..4 {
                let eyes = histories.iter_mut().zip(cameras).zip(areas);
                let mut eyes: Vec<ViewRequest<'_>> = eyes
                    .map(|((history, camera), area)| ViewRequest {
                        state: history,
                        viewpoint: camera.into(),
                        visible: None,
                        rect: area,
                    })
                    .collect();
                let request = ViewsRequest { strategy, image: None, overlay: None, after: None };
                renderer.render_views(&mut eyes, &request).unwrap();
            }
            let [half, whole] = histories.each_ref().map(|view| of(view, HALF).unwrap());
            assert!((half.fraction().unwrap() - 0.5).abs() < 0.06, "{strategy}: {half:?}");
            assert_eq!(whole.fraction(), Some(1.0), "{strategy}: {whole:?}");
            assert!(whole.samples > half.samples * 3 / 2 && half.samples > 20);
            for history in &mut histories {
                renderer.wait_idle(history).unwrap();
            }
        }
    });
}

#[test]
fn counts_follow_objects_that_move_and_end_with_those_that_go() {
    run_on_all(|device| {
        let boxes = half_covered();
        let camera = square_camera();
        let mut renderer = renderer(device, &boxes, &options());
        for strategy in [Strategy::ANTUMBRA, methods::HZB, methods::STOP_AND_WAIT] {
            let mut view = renderer.new_view().unwrap();
            view.watch(&[ObjectId(HALF), ObjectId(FLOOR)]).unwrap();
            for _ in 0..4 {
                frame(&mut renderer, &mut view, strategy, camera);
            }
            let before = of(&view, HALF).unwrap();
            let place = |by: Vec3| {
                let bounds = boxes[HALF as usize];
                let scale = bounds.max - bounds.min;
                let at = bounds.min + by;
                Affine3A::from_scale_rotation_translation(scale, glam::Quat::IDENTITY, at)
            };
            // The object moves out from behind the wall.
            let transform = place(Vec3::X * 3.5);
            renderer.update(&[ObjectChange::Move { object: ObjectId(HALF), transform }]).unwrap();
            for _ in 0..4 {
                frame(&mut renderer, &mut view, strategy, camera);
            }
            let after = of(&view, HALF).unwrap();
            assert!(after.samples > before.samples * 3 / 2, "{strategy}: {before:?} {after:?}");
            assert_eq!(after.fraction(), Some(1.0));

            // While queries are in flight, the object is removed and another one takes its place.
            renderer.update(&[ObjectChange::Remove { object: ObjectId(HALF) }]).unwrap();
            frame(&mut renderer, &mut view, strategy, camera);
            assert!(of(&view, HALF).is_none() && of(&view, FLOOR).is_some());
            let mesh = MeshId(0);
            let tint = pack_unorm([0.1, 0.9, 0.2, 1.0]);
            let object = Object { mesh, transform: place(Vec3::X * 40.0), tint };
            let added = renderer.update(&[ObjectChange::Add { object }]).unwrap().added;
            assert_eq!(added, [ObjectId(HALF)], "the id is given to the next");
            for _ in 0..6 {
                frame(&mut renderer, &mut view, strategy, camera);
                let known = of(&view, HALF).unwrap();
                assert_eq!((known.samples, known.age_frames), (0, 0), "{strategy}");
            }
            let back = ObjectChange::Move { object: ObjectId(HALF), transform: place(Vec3::ZERO) };
            renderer.update(&[back]).unwrap();
            renderer.wait_idle(&mut view).unwrap();
        }
    });
}

#[test]
fn lists_can_change_and_nothing_is_recorded_for_an_empty_one() {
    run_on_all(|device| {
        let camera = square_camera();
        let mut renderer = renderer(device, &half_covered(), &options());
        renderer.time_passes().unwrap();
        let mut view = renderer.new_view().unwrap();
        let is_counting = |renderer: &mut Renderer, view: &mut RenderView| {
            for _ in 0..5 {
                frame(renderer, view, Strategy::ANTUMBRA, camera);
            }
            renderer.pass_times().iter().any(|pass| pass.label == "count samples")
        };
        assert!(!is_counting(&mut renderer, &mut view));
        view.watch(&[ObjectId(HALF), ObjectId(HALF), ObjectId(FLOOR)]).unwrap();
        assert!(is_counting(&mut renderer, &mut view));
        assert_eq!(view.visible_samples().len(), 2);
        view.watch(&[ObjectId(HIDDEN), ObjectId(FLOOR)]).unwrap();
        assert_eq!(view.visible_samples().len(), 1, "what is still watched is still known");
        assert!(is_counting(&mut renderer, &mut view));
        assert_eq!(view.visible_samples().len(), 2);
        // Without a watched object in view there is no query.
        view.watch(&[ObjectId(BEHIND), ObjectId(77)]).unwrap();
        assert!(!is_counting(&mut renderer, &mut view));
        view.watch(&[]).unwrap();
        assert!(!is_counting(&mut renderer, &mut view));
        assert_eq!(view.visible_samples(), []);
        renderer.wait_idle(&mut view).unwrap();
    });
}

/// Checks that images with and without counting have the same bits.
#[test]
fn counting_changes_nothing() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(400);
        let path = CameraPath::new(PathKind::Cut, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options()).unwrap();
        let images = [(); 2].map(|()| Readback::new(device, SIZE).unwrap());
        for strategy in [Strategy::ANTUMBRA, methods::HZB, methods::BATCHED] {
            let mut views = [(); 2].map(|()| renderer.new_view().unwrap());
            let all = (0..scene.objects.len() as u32).map(ObjectId);
            views[1].watch(&all.step_by(2).collect::<Vec<_>>()).unwrap();
            let mut counted = 0;
            for number in 5..14 {
                for (view, image) in views.iter_mut().zip(&images) {
                    let camera = path.camera(number);
                    let request =
                        FrameRequest { image: Some(image), ..FrameRequest::new(strategy, camera) };
                    renderer.render(view, request).unwrap();
                    renderer.wait_idle(view).unwrap();
                }
                let [plain, counting] = images.each_ref().map(|image| image.rgba8().unwrap());
                assert_eq!(pixels_that_differ(&plain, &counting), 0, "{strategy}");
                let known = views[1].visible_samples().iter();
                counted += known.map(|known| known.samples).sum::<u32>();
            }
            assert!(counted > 1_000, "{strategy}: {counted}");
        }
    });
}
