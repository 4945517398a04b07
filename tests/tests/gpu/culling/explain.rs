//! The debug overlay of frames: at the right place, without an effect on decisions, and removable.

use cull::Strategy;
use gpu::{Device, PredicationMode, Readback};
use render::{
    CostModel, DebugOverlay, FrameReport, FrameRequest, Rect, RenderView, Renderer, RendererOptions,
};
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use tests::{Driver, run, run_on_all};

const SIZE: [u32; 2] = [320, 180];
const CORNER: Rect = Rect { origin: [220, 10], size: [90, 60] };

struct Studio {
    renderer: Renderer,
    history: RenderView,
    image: Readback,
    path: CameraPath,
}

impl Studio {
    fn new(device: &Device) -> Self {
        Self::with(device, None)
    }

    fn with(device: &Device, predication: Option<PredicationMode>) -> Self {
        let GeneratedScene { scene, routes } = city(400, 5).unwrap();
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        // Measured costs, and plans that depend on them, differ between renderers.
        let cost_model = CostModel::Off;
        let options = RendererOptions {
            methods: methods::all(),
            size: SIZE,
            predication,
            cost_model,
            ..RendererOptions::default()
        };
        let renderer = Renderer::new(device, &scene, &options).unwrap();
        let history = renderer.new_view().unwrap();
        let image = Readback::new(device, SIZE).unwrap();
        Self { renderer, history, image, path }
    }

    fn render(&mut self, strategy: Strategy) -> (FrameReport, Vec<u8>) {
        let request = FrameRequest {
            image: Some(&self.image),
            ..FrameRequest::new(strategy, self.path.camera(7))
        };
        let report = self.renderer.render(&mut self.history, request).unwrap();
        self.renderer.wait_idle(&mut self.history).unwrap();
        (report, self.image.rgba8().unwrap().to_vec())
    }

    /// Returns a frame under a debug overlay.
    fn explained(&mut self, debug_overlay: DebugOverlay) -> Vec<u8> {
        self.renderer.set_debug_overlay(debug_overlay).unwrap();
        self.render(Strategy::ANTUMBRA).1
    }
}

/// Returns the numbers of differing pixels inside and outside an area.
fn differences(a: &[u8], b: &[u8], area: Rect) -> (usize, usize) {
    let mut inside = 0;
    let mut outside = 0;
    for (place, (a, b)) in a.as_chunks::<4>().0.iter().zip(b.as_chunks::<4>().0).enumerate() {
        let at = [place as u32 % SIZE[0], place as u32 / SIZE[0]];
        let is_in = |side: usize| {
            (area.origin[side]..area.origin[side] + area.size[side]).contains(&at[side])
        };
        if a == b {
            continue;
        }
        if is_in(0) && is_in(1) {
            inside += 1;
        } else {
            outside += 1;
        }
    }
    (inside, outside)
}

#[test]
fn debug_overlays_are_drawn_where_they_belong_and_go() {
    run_on_all(|device| {
        let mut studio = Studio::new(device);
        for _ in 0..8 {
            studio.render(Strategy::ANTUMBRA);
        }
        let plain = studio.render(Strategy::ANTUMBRA).1;
        let nothing = DebugOverlay::default();
        let whole = Rect { origin: [0, 0], size: SIZE };

        let corner = studio.explained(DebugOverlay { top_down: Some(CORNER), ..nothing });
        let (inside, outside) = differences(&plain, &corner, CORNER);
        assert!(inside > 90 * 60 / 2 && outside == 0, "{inside} {outside}");

        let boxes = studio.explained(DebugOverlay { has_boxes: true, ..nothing });
        let wireframe = studio.explained(DebugOverlay { has_wireframe: true, ..nothing });
        for (image, what) in [(&boxes, "boxes"), (&wireframe, "wireframe")] {
            let changed = differences(&plain, image, whole).0;
            let pixels = (SIZE[0] * SIZE[1]) as usize;
            assert!(changed > 200 && changed < pixels / 2, "{what}: {changed}");
        }
        assert!(studio.explained(nothing) == plain, "no trace is left");
    });
}

#[test]
fn a_debug_overlay_decides_nothing() {
    run_on_all(|device| {
        let mut plain = Studio::new(device);
        let mut explained = Studio::new(device);
        let all = DebugOverlay {
            has_wireframe: true,
            has_boxes: true,
            has_depth_complexity: true,
            top_down: Some(CORNER),
        };
        explained.renderer.set_debug_overlay(all).unwrap();
        assert_eq!(explained.renderer.debug_overlay(), all);
        for frame in 0..12 {
            let [a, b] = [&mut plain, &mut explained].map(|side| side.render(Strategy::ANTUMBRA).0);
            assert_eq!((a.tests, a.plan.visible), (b.tests, b.plan.visible), "frame {frame}");
        }
        for strategy in [Strategy::FRUSTUM, methods::HZB, methods::CHC] {
            explained.render(strategy);
        }
        let beyond = Rect { origin: [300, 0], size: [30, 20] };
        let refused =
            explained.renderer.set_debug_overlay(DebugOverlay { top_down: Some(beyond), ..all });
        assert!(refused.unwrap_err().to_string().contains("is not within the image"));
        assert_eq!(explained.renderer.debug_overlay(), all, "what was explained before still is");
    });
}

#[test]
fn a_debug_overlay_is_the_same_however_draws_are_skipped() {
    run(Driver::Lavapipe, |device| {
        let all = DebugOverlay {
            has_wireframe: true,
            has_boxes: true,
            has_depth_complexity: true,
            top_down: Some(CORNER),
        };
        let kinds = PredicationMode::ALL;
        let mut studios = kinds.map(|kind| Studio::with(device, Some(kind)));
        for frame in 0..8 {
            let images: Vec<_> = studios.iter_mut().map(|studio| studio.explained(all)).collect();
            let whole = Rect { origin: [0, 0], size: SIZE };
            let wrong = [1, 2, 3].map(|other| differences(&images[0], &images[other], whole).0);
            assert_eq!(wrong, [0; 3], "frame {frame}: pixels that differ from conditional draws");
        }
    });
}

#[test]
fn a_moment_can_be_walked_around() {
    run_on_all(|device| {
        let mut studio = Studio::new(device);
        for _ in 0..8 {
            studio.render(Strategy::ANTUMBRA);
        }
        let camera = studio.path.camera(7);
        let view = studio.renderer.view_of(&camera);
        let snapshot = studio.renderer.snapshot(&mut studio.history, view).unwrap();
        let mut seen = |camera| {
            studio.renderer.render_snapshot(&snapshot, camera, Some(&studio.image), None).unwrap();
            studio.renderer.wait_idle(&mut studio.history).unwrap();
            studio.image.rgba8().unwrap().to_vec()
        };
        let same = seen(camera);
        let elsewhere = seen(cull::Camera { eye: camera.eye + glam::Vec3::Y * 30.0, ..camera });
        assert!(same != elsewhere);
        assert!(same == seen(camera), "the moment stands still");
    });
}
