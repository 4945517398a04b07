//! The GPU times of frames reach the cost models for any set of views, and images stay right.

use cull::{Camera, Corrections, CostTable, Strategy};
use gpu::{Device, FrameRing, Readback};
use render::{
    CostModel, DebugOverlay, FrameRequest, Rect, Renderer, RendererOptions, ViewRequest,
    ViewsRequest,
};
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use tests::run_on_all;
use tests::walk::images_that_differ;

const SIZE: [u32; 2] = [160, 90];
const FRAMES: u32 = 64;
/// The least number of timed frames: one in 16 is timed, and the last one may not be read back.
const LEAST_TIMED: u64 = FRAMES as u64 / 16 - 1;

fn renderer(
    device: &Device,
    cost_model: CostModel,
    frames_in_flight: usize,
) -> (Renderer, Vec<Camera>) {
    let GeneratedScene { scene, routes } = city(400, 5).unwrap();
    let path = CameraPath::new(PathKind::Street, &routes).unwrap();
    let options =
        RendererOptions { size: SIZE, cost_model, frames_in_flight, ..Default::default() };
    let cameras = (0..FRAMES).map(|frame| path.camera(frame)).collect();
    (Renderer::new(device, &scene, &options).unwrap(), cameras)
}

fn check(found: Corrections, least_frames: u64, what: &str) {
    println!("{what}: {found:?}");
    assert!((least_frames..=least_frames + 2).contains(&found.frames), "{what}: {found:?}");
    for factor in [found.draws, found.tests, found.proportion] {
        assert!((0.125..=8.0).contains(&factor), "{what}: {found:?}");
    }
    assert_ne!([found.draws, found.tests], [1.0, 1.0], "{what}: nothing was learned: {found:?}");
}

/// Walks with a tester, and checks that the frames are learned from and the images are right.
fn learn(device: &Device, strategy: Strategy, frames_in_flight: usize) {
    let (mut renderer, cameras) = renderer(device, CostModel::Measured, frames_in_flight);
    let images = [0, 1].map(|_| Readback::new(device, SIZE).unwrap());
    let mut views = [0, 1].map(|_| renderer.new_view().unwrap());
    let mut learned = Corrections::default();
    for camera in cameras {
        let strategies = [Strategy::FRUSTUM, strategy];
        for ((view, image), strategy) in views.iter_mut().zip(&images).zip(strategies) {
            let request =
                FrameRequest { image: Some(image), ..FrameRequest::new(strategy, camera) };
            let report = renderer.render(view, request).unwrap();
            learned = report.corrections.expect("a governor");
            let is_known = report.plan.proxy_pixels > 0 || report.tests == 0;
            assert!(is_known, "{report:?}");
        }
        device.wait_idle().unwrap();
        let [expected, found] = &images;
        assert_eq!(images_that_differ(expected, found), 0);
    }
    check(learned, LEAST_TIMED, &format!("{strategy}, {frames_in_flight} in flight"));
}

#[test]
fn frames_are_learned_from_and_images_are_right() {
    run_on_all(|device| {
        learn(device, Strategy::ANTUMBRA, 2);
        learn(device, Strategy::ANTUMBRA_QUERIES, 1);
        learn(device, Strategy::ANTUMBRA_COMPUTE, 4);
    });
}

#[test]
#[ignore = "long walk"]
fn every_tester_learns_with_any_number_of_frames_in_flight() {
    run_on_all(|device| {
        for frames_in_flight in [1, 2, 4] {
            for strategy in
                [Strategy::ANTUMBRA, Strategy::ANTUMBRA_QUERIES, Strategy::ANTUMBRA_COMPUTE]
            {
                learn(device, strategy, frames_in_flight);
            }
        }
    });
}

#[test]
fn views_that_are_drawn_together_learn_the_same() {
    run_on_all(|device| {
        let (mut renderer, cameras) = renderer(device, CostModel::Measured, 2);
        let mut views = [0, 1].map(|_| renderer.new_view().unwrap());
        let mut learned = [Corrections::default(); 2];
        for camera in cameras {
            let areas = Rect::side_by_side(SIZE, 2);
            let mut eyes: Vec<ViewRequest<'_>> = views
                .iter_mut()
                .zip(areas)
                .map(|(history, area)| ViewRequest {
                    state: history,
                    viewpoint: camera.into(),
                    visible: None,
                    rect: area,
                })
                .collect();
            let request = ViewsRequest {
                strategy: Strategy::ANTUMBRA,
                image: None,
                overlay: None,
                after: None,
            };
            renderer.render_views(&mut eyes, &request).unwrap();
            for (learned, view) in learned.iter_mut().zip(&views) {
                *learned = view.corrections().expect("a governor");
            }
        }
        check(learned[0], LEAST_TIMED, "two eyes");
        assert_eq!(learned[0], learned[1]);
    });
}

/// Checks that alternating views learn their own times. With three slots, consecutive frames of a
/// view are never in the same slot.
#[test]
fn views_that_take_turns_learn_each_their_own() {
    run_on_all(|device| {
        let (mut renderer, cameras) = renderer(device, CostModel::Measured, 3);
        let mut views = [0, 1].map(|_| renderer.new_view().unwrap());
        for camera in cameras {
            for view in &mut views {
                renderer.render(view, FrameRequest::new(Strategy::ANTUMBRA, camera)).unwrap();
            }
        }
        for view in &views {
            check(view.corrections().unwrap(), LEAST_TIMED, "taking turns");
        }
    });
}

/// Checks that learning continues while slots and sizes change under frames whose times were not
/// read back.
#[test]
#[ignore = "long walk"]
fn learning_goes_on_whatever_changes_between_frames() {
    run_on_all(|device| {
        let (mut renderer, cameras) = renderer(device, CostModel::Measured, 2);
        let mut views = [0, 1].map(|_| renderer.new_view().unwrap());
        let mut known = 0;
        for (frames_in_flight, size) in [(2, SIZE), (4, SIZE), (1, [96, 101]), (3, [201, 64])] {
            renderer.set_frames_in_flight(frames_in_flight).unwrap();
            renderer.resize(size).unwrap();
            let images = [0, 1].map(|_| Readback::new(device, size).unwrap());
            for (number, camera) in cameras.iter().enumerate() {
                let strategies = [Strategy::FRUSTUM, Strategy::ANTUMBRA];
                for ((view, image), strategy) in views.iter_mut().zip(&images).zip(strategies) {
                    let image = (number % 8 == 0).then_some(image);
                    let request = FrameRequest { image, ..FrameRequest::new(strategy, *camera) };
                    renderer.render(view, request).unwrap();
                }
                if number % 8 == 0 {
                    device.wait_idle().unwrap();
                    let [expected, found] = &images;
                    let differ = images_that_differ(expected, found);
                    assert_eq!(differ, 0, "{size:?}, {frames_in_flight} in flight, {number}");
                }
            }
            let learned = views[1].corrections().expect("a governor").frames;
            let new = learned - known;
            assert!(new >= LEAST_TIMED, "{size:?}, {frames_in_flight} in flight: {new}");
            known = learned;
        }
    });
}

#[test]
fn what_is_drawn_to_explain_is_not_learned_from() {
    run_on_all(|device| {
        let (mut renderer, cameras) = renderer(device, CostModel::Measured, 2);
        let mut view = renderer.new_view().unwrap();
        renderer.set_debug_overlay(DebugOverlay { has_boxes: true, ..Default::default() }).unwrap();
        for camera in &cameras {
            renderer.render(&mut view, FrameRequest::new(Strategy::ANTUMBRA, *camera)).unwrap();
        }
        assert_eq!(view.corrections(), Some(Corrections::default()));
        renderer.set_debug_overlay(DebugOverlay::default()).unwrap();
        for camera in &cameras {
            renderer.render(&mut view, FrameRequest::new(Strategy::ANTUMBRA, *camera)).unwrap();
        }
        check(view.corrections().unwrap(), LEAST_TIMED, "explained before");
    });
}

#[test]
fn what_is_not_governed_is_not_learned_from() {
    run_on_all(|device| {
        let (mut ungoverned, cameras) = renderer(device, CostModel::Off, 2);
        let (mut cost_driven, _) = renderer(device, CostModel::Table(CostTable::default()), 2);
        let mut views = [ungoverned.new_view().unwrap(), cost_driven.new_view().unwrap()];
        for camera in cameras {
            let request = FrameRequest::new(Strategy::ANTUMBRA, camera);
            assert_eq!(ungoverned.render(&mut views[0], request).unwrap().corrections, None);
            let request = FrameRequest::new(Strategy::FRUSTUM, camera);
            let report = cost_driven.render(&mut views[1], request).unwrap();
            assert_eq!(report.corrections, Some(Corrections::default()));
        }
        device.wait_idle().unwrap();
    });
}

#[test]
fn only_whole_frames_that_ask_are_timed() {
    run_on_all(|device| {
        let mut frames = FrameRing::new(device, 2).unwrap();
        frames.begin().unwrap().begin_timing();
        assert_eq!(frames.begin().unwrap().last_time(), None, "this ring times nothing");
        frames.time_frames().unwrap();
        let mut expected = [None, None];
        for number in 0..12 {
            // This frame is given up: it leaves no time, and the time of the frame before is lost,
            // too.
            if number == 8 {
                frames.begin().unwrap().begin_timing();
                expected[0] = None;
            }
            let mut frame = frames.begin().unwrap();
            let found = frame.last_time();
            let slot = frame.slot().0;
            assert_eq!(found.map(|time| time.tick), expected[slot], "frame {number}");
            assert!(found.is_none_or(|time| time.gpu_ms > 0.0 && time.gpu_ms < 10_000.0));
            let is_timed = number % 5 != 3;
            if is_timed {
                frame.begin_timing();
                frame.begin_timing();
            }
            // A frame may be submitted in several pieces.
            frame.flush(None).unwrap();
            let tick = frame.submit(None).unwrap();
            expected[slot] = is_timed.then_some(tick);
        }
        device.wait_idle().unwrap();
    });
}
