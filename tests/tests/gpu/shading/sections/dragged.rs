//! Planes that are dragged through a scene: every strategy draws the same bits as frustum culling.

use cull::{SectionMode, SectionPlane, SectionPlanes, Strategy};
use gpu::{Device, OptionalFeature, SampleCount};
use render::{DebugOverlay, Rect, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind, city, field};
use tests::run_on_all;
use tests::section::CutScene;

/// Returns the planes of a frame of a drag.
fn dragged(frame: u32, mode: SectionMode) -> SectionPlanes {
    let at = f64::from(frame);
    let plane = |x: f64, y: f64, z: f64, offset_m: f64| {
        SectionPlane::new(glam::DVec3::new(x, y, z), offset_m).unwrap()
    };
    let planes = [
        plane(0.0, -1.0, 0.05, 3.0 + at * 0.4),
        plane(1.0, 0.3, 0.2, 20.0 - at),
        plane(-0.2, 0.0, 1.0, 30.0 - 2.0 * at),
    ];
    SectionPlanes::new(&planes[..1 + frame as usize % 3], mode).unwrap()
}

fn drag(device: &Device, generated: &GeneratedScene, options: RendererOptions, frames: u32) {
    let path = CameraPath::new(PathKind::Fly, &generated.routes).unwrap();
    let mut shown = CutScene::new(device, &generated.scene, options);
    let strategies: Vec<Strategy> = [
        Strategy::ANTUMBRA,
        Strategy::ANTUMBRA_FLAGS,
        Strategy::ANTUMBRA_QUERIES,
        Strategy::ANTUMBRA_COMPUTE,
    ]
    .into_iter()
    .chain(
        methods::strategies()
            .into_iter()
            .filter(|strategy| strategy.is_exact() && !strategy.needs_still_scene()),
    )
    .filter(|strategy| shown.renderer.supports(*strategy).is_ok())
    .collect();
    assert!(!strategies.is_empty());
    let mut views: Vec<_> = strategies.iter().map(|_| shown.renderer.new_view().unwrap()).collect();
    let mut whole = 0;
    let mut culled = 0;
    for mode in [SectionMode::Intersection, SectionMode::Union] {
        for frame in 0..frames {
            let camera = path.camera(frame);
            shown.renderer.set_section(dragged(frame, mode)).unwrap();
            let truth = shown.pixels(camera, Strategy::FRUSTUM);
            for (strategy, view) in strategies.iter().zip(&mut views) {
                std::mem::swap(&mut shown.view, view);
                let pixels = shown.pixels(camera, *strategy);
                std::mem::swap(&mut shown.view, view);
                let wrong = pixels.iter().zip(&truth).filter(|(a, b)| a != b).count();
                assert_eq!(wrong, 0, "{strategy}, {mode:?}, frame {frame}");
            }
            let view = shown.renderer.view_of(&camera);
            culled += shown.renderer.hierarchy().objects_in_frustum(&view);
            let view = cull::CullView { section: SectionPlanes::default(), ..view };
            whole += shown.renderer.hierarchy().objects_in_frustum(&view);
        }
    }
    explain(&mut shown, path.camera(3));
    assert!(culled < whole, "nothing was cut away: {culled} of {whole}");
}

/// Draws wires, boxes and the view from above, all cut. Only the validation layer checks them.
fn explain(shown: &mut CutScene, camera: cull::Camera) {
    let has_wireframe = shown.renderer.device().capabilities().has(OptionalFeature::Wireframe);
    let top_down = Some(Rect { origin: [80, 45], size: [80, 45] });
    let overlay =
        DebugOverlay { has_wireframe, has_boxes: true, has_depth_complexity: true, top_down };
    shown.renderer.set_debug_overlay(overlay).unwrap();
    let explained = shown.pixels(camera, Strategy::FRUSTUM);
    shown.renderer.set_debug_overlay(DebugOverlay::default()).unwrap();
    assert!(explained != shown.pixels(camera, Strategy::FRUSTUM));
}

#[test]
fn every_strategy_is_exact_while_planes_are_dragged() {
    run_on_all(|device| {
        let options = RendererOptions { size: [160, 90], ..RendererOptions::default() };
        drag(device, &city(400, 3).unwrap(), options.clone(), 4);
        drag(device, &field(200, 3).unwrap(), options, 3);
    });
}

#[test]
fn several_samples_are_exact_while_planes_are_dragged() {
    run_on_all(|device| {
        let options = RendererOptions {
            size: [160, 90],
            samples: SampleCount::Four,
            ..RendererOptions::default()
        };
        drag(device, &city(200, 3).unwrap(), options, 3);
    });
}
