//! The frame loop waits for the GPU only for its own slot, and reports its work.

use cull::Strategy;
use gpu::{Device, Readback, Tick, Timeline};
use render::{CostModel, FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::run_on_all;
use tests::walk::{SceneKind, frame_loop, images_that_differ};

fn renderer(device: &Device, frames_in_flight: usize) -> (Renderer, CameraPath) {
    let GeneratedScene { scene, routes } = SceneKind::City.build(600);
    // Measured costs differ from run to run; without costs, everything is tested.
    let options = RendererOptions {
        size: [160, 90],
        frames_in_flight,
        cost_model: CostModel::Off,
        ..Default::default()
    };
    let path = CameraPath::new(PathKind::Street, &routes).unwrap();
    (Renderer::new(device, &scene, &options).unwrap(), path)
}

#[test]
fn recording_goes_on_while_the_gpu_is_held_back() {
    run_on_all(|device| {
        const FRAMES_IN_FLIGHT: u32 = 4;
        let (mut renderer, path) = renderer(device, FRAMES_IN_FLIGHT as usize);
        let mut view = renderer.new_view().unwrap();
        // Fills every slot with queries, so that a wait for a missing answer would show.
        for frame in 0..20 {
            let camera = path.camera(frame);
            let request = FrameRequest::new(Strategy::ANTUMBRA, camera);
            renderer.render(&mut view, request).unwrap();
        }
        device.wait_idle().unwrap();
        let gate = Timeline::new(device, "gate").unwrap();
        let image = Readback::new(device, renderer.size()).unwrap();
        let waits = device.wait_counts();
        let over = device.completed().unwrap();
        for number in 0..FRAMES_IN_FLIGHT {
            let report = renderer.render(
                &mut view,
                FrameRequest {
                    image: (number + 1 == FRAMES_IN_FLIGHT).then_some(&image),
                    after: Some(gate.at(Tick(1))),
                    ..FrameRequest::new(Strategy::ANTUMBRA, path.camera(20 + number))
                },
            );
            assert!(report.unwrap().tests > 0, "there is something to wait for");
        }
        // N frames are recorded and submitted, and the GPU has not begun any of them.
        assert_eq!(device.completed().unwrap(), over);
        assert_eq!(device.submitted().0, over.0 + u64::from(FRAMES_IN_FLIGHT));
        assert_eq!(device.wait_counts().other, waits.other, "nothing but slots was waited for");
        gate.signal(Tick(1)).unwrap();
        renderer.wait_idle(&mut view).unwrap();

        let camera = [path.camera(20 + FRAMES_IN_FLIGHT - 1)];
        let mut plain = renderer.new_view().unwrap();
        let expected = frame_loop(&mut renderer, &mut plain, Strategy::FRUSTUM, &camera);
        assert_eq!(images_that_differ(&expected.images[0], &image), 0);
    });
}

#[test]
fn what_a_frame_reports_is_what_it_did() {
    run_on_all(|device| {
        let (mut renderer, path) = renderer(device, 2);
        let mut view = renderer.new_view().unwrap();
        let cameras: Vec<_> = (0..40).map(|frame| path.camera(frame)).collect();
        let walked = frame_loop(&mut renderer, &mut view, Strategy::ANTUMBRA, &cameras);
        for (number, (report, outcome)) in walked.reports.iter().zip(&walked.outcomes).enumerate() {
            // Frames are reported in their order. The draws are the taken and the revealed ones.
            assert_eq!(outcome.frame.0, walked.outcomes[0].frame.0 + number as u64);
            let taken = report.plan.visible + report.plan.too_near + report.plan.occluders;
            let taken = u64::from(taken + report.plan.over_budget);
            assert_eq!(outcome.draws, taken + outcome.revealed, "frame {number}");
            assert!(outcome.triangles > outcome.draws, "more than a triangle an object");
            let decided = report.plan.frontier;
            assert_eq!(report.predicated_draws, decided);
            assert!(report.tests >= decided);
        }
        // At rest, revealed objects become visible and all others stay hidden.
        let still = vec![cameras[0]; 60];
        let walked = frame_loop(&mut renderer, &mut view, Strategy::ANTUMBRA, &still);
        let late = &walked.outcomes[40..];
        assert!(late.iter().map(|outcome| outcome.revealed).sum::<u64>() <= 60, "{late:?}");
    });
}

#[test]
fn passes_are_timed_by_their_labels() {
    run_on_all(|device| {
        let (mut renderer, path) = renderer(device, 2);
        renderer.time_passes().unwrap();
        let mut view = renderer.new_view().unwrap();
        let cameras: Vec<_> = (0..8).map(|frame| path.camera(frame)).collect();
        frame_loop(&mut renderer, &mut view, Strategy::ANTUMBRA, &cameras);
        let labels: Vec<_> = renderer.pass_times().iter().map(|time| time.label).collect();
        assert_eq!(&labels[..3], ["draw visible", "resolve tests", "draw revealed"]);
        assert_eq!(labels.last(), Some(&"copy image"));
        let total_ms: f64 = renderer.pass_times().iter().map(|time| time.gpu_ms).sum();
        assert!(total_ms > 0.0 && total_ms < 60_000.0, "{total_ms} ms");
    });
}

#[test]
fn a_moment_is_all_that_was_decided() {
    run_on_all(|device| {
        let (mut renderer, path) = renderer(device, 2);
        let mut view = renderer.new_view().unwrap();
        let cameras: Vec<_> = (0..40).map(|frame| path.camera(frame)).collect();
        let outcomes = frame_loop(&mut renderer, &mut view, Strategy::ANTUMBRA, &cameras).outcomes;
        let seen = renderer.view_of(&cameras[39]);
        let snapshot = renderer.snapshot(&mut view, seen).unwrap();
        let drawn: u64 = snapshot.drawn.iter().map(|range| u64::from(range.count)).sum();
        assert_eq!(drawn, outcomes[39].draws);
        assert!(!snapshot.hidden.is_empty());
        assert!(snapshot.hidden.len() as u32 <= view.plan().stats.frontier);

        let image = Readback::new(device, renderer.size()).unwrap();
        renderer.top_down(&snapshot, &image).unwrap();
        let pixels = image.rgba8().unwrap();
        let background = &pixels[..4];
        let painted = pixels.chunks_exact(4).filter(|pixel| pixel != &background).count();
        assert!(painted > 160 * 90 / 10, "{painted} pixels of something");
    });
}
