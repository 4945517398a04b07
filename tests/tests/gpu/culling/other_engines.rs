//! Small scenes from public reports, in which other engines leave out visible objects
//! (`docs/lab/other_engines.md`). Here every frame equals plain frustum culling.

use std::path::Path;

use cull::{Camera, ObjectId, Strategy};
use gpu::{Device, PredicationMode};
use render::{CostModel, Rect, RenderView, Renderer, RendererOptions};
use tests::regressions::{Provocation, Reported};
use tests::walk::{Loop, frame_loop, pixels_that_differ, walk_cameras_with};
use tests::{Driver, run, run_on_all};

use crate::shading::golden;

#[cfg(feature = "shader-compiler")]
mod faults;

/// The size of the walks' images, with odd sides.
const SIZE: [u32; 2] = [167, 109];

/// The sizes of the jumps' images, which change while the history is kept.
const SIZES: [[u32; 2]; 8] =
    [[333, 217], [1, 1], [333, 7], [3, 200], [97, 53], [127, 255], [64, 32], [65, 33]];

fn options(predication: Option<PredicationMode>) -> RendererOptions {
    // Without costs everything is tested.
    RendererOptions {
        methods: methods::all(),
        size: SIZE,
        predication,
        cost_model: CostModel::Off,
        ..Default::default()
    }
}

/// Returns sizes of images, each with the cameras of consecutive frames: the walk, then the jumps.
fn takes(provocation: &Provocation) -> Vec<([u32; 2], &[Camera])> {
    let jumps = provocation.jumps.chunks(provocation.jumps.len() / SIZES.len());
    [(SIZE, &*provocation.walk)].into_iter().chain(SIZES.into_iter().zip(jumps)).collect()
}

/// Compares each frame of the strategies with a frame in which everything is drawn.
fn check(device: &Device, kind: Reported, options: &RendererOptions, with: &[Strategy]) {
    let provocation = kind.build();
    let mut whole = Renderer::new(device, &provocation.drawn_whole(), options).unwrap();
    let mut renderer = Renderer::new(device, &provocation.scene, options).unwrap();
    let mut all = whole.new_view().unwrap();
    let strategies = [Strategy::FRUSTUM].into_iter().chain(with.iter().copied());
    let mut views: Vec<(Strategy, RenderView, [u64; 2])> =
        strategies.map(|strategy| (strategy, renderer.new_view().unwrap(), [0; 2])).collect();
    for (size, cameras) in takes(&provocation) {
        whole.resize(size).unwrap();
        renderer.resize(size).unwrap();
        let expected = frame_loop(&mut whole, &mut all, Strategy::FRUSTUM, cameras);
        let objects = provocation.scene.objects.len() as u64;
        assert!(expected.outcomes.iter().all(|outcome| outcome.draws == objects), "{kind:?}");
        for (strategy, view, [tests, draws]) in &mut views {
            let found = frame_loop(&mut renderer, view, *strategy, cameras);
            let wrong = first_wrong(&expected, &found);
            assert_eq!(wrong, None, "{kind:?}, {strategy}, {size:?}: frame and pixels");
            *tests += found.reports.iter().map(|report| u64::from(report.tests)).sum::<u64>();
            *draws += found.draws();
        }
    }
    let [_, in_frustum] = views[0].2;
    for (strategy, _, [tests, draws]) in &views[1..] {
        // To test nothing and draw everything would be exact and useless.
        let is_tested = *tests > 0 || strategy.is_gpu_driven();
        assert!(is_tested && *draws < in_frustum, "{kind:?}, {strategy}: {tests}, {draws}");
    }
}

/// Returns the first differing frame and the number of its differing pixels.
fn first_wrong(expected: &Loop, found: &Loop) -> Option<(usize, usize)> {
    let pairs = expected.images.iter().zip(&found.images).enumerate();
    let mut wrong = pairs.filter_map(|(frame, (expected, found))| {
        let expected = expected.rgba8().unwrap();
        let found = found.rgba8().unwrap();
        (*expected != *found).then(|| (frame, pixels_that_differ(&expected, &found)))
    });
    wrong.next()
}

/// Our strategies: with all testers, and with each tester alone.
const OURS: [Strategy; 4] = [
    Strategy::ANTUMBRA,
    Strategy::ANTUMBRA_QUERIES,
    Strategy::ANTUMBRA_FLAGS,
    Strategy::ANTUMBRA_COMPUTE,
];

/// The literature's methods that games use: coherent hierarchical culling and the depth pyramid.
const THEIRS: [Strategy; 2] = [methods::CHC, methods::HZB];

/// The ways to skip draws that are not the best one of a device with conditional rendering.
const OTHER_WAYS: [PredicationMode; 3] =
    [PredicationMode::Counts, PredicationMode::Instances, PredicationMode::Compacted];

fn check_everything(kind: Reported) {
    run_on_all(|device| {
        check(device, kind, &options(None), &[&OURS[..], &THEIRS].concat());
    });
}

#[test]
fn each_report_is_exact_with_other_ways_to_skip_draws() {
    run(Driver::Lavapipe, |device| {
        // Over all reports, each tester meets each way.
        for (number, kind) in Reported::ALL.into_iter().enumerate() {
            let ours = if number < 3 { &OURS[..2] } else { &OURS[2..] };
            check(device, kind, &options(Some(OTHER_WAYS[number % 3])), ours);
        }
    });
}

#[test]
#[ignore = "long walk"]
fn every_report_is_exact_with_every_way_to_skip_draws() {
    run(Driver::Lavapipe, |device| {
        for kind in Reported::ALL {
            for predication in OTHER_WAYS {
                check(device, kind, &options(Some(predication)), &OURS);
            }
        }
    });
}

#[test]
fn a_gap_between_two_occluders() {
    check_everything(Reported::Gap);
}

#[test]
fn an_opening_at_the_edge_of_the_image() {
    check_everything(Reported::Opening);
}

#[test]
fn a_large_box_almost_off_screen() {
    check_everything(Reported::Edge);
}

#[test]
fn touching_tiles_in_parallel_sight() {
    check_everything(Reported::Tiles);
}

#[test]
fn the_camera_inside_an_occluder() {
    check_everything(Reported::Inside);
}

#[test]
fn a_box_of_sky_around_the_camera() {
    check_everything(Reported::Sky);
}

#[test]
fn the_walks_provoke_what_was_reported() {
    run(Driver::Lavapipe, |device| {
        for kind in Reported::ALL {
            let Provocation { scene, subject, walk, jumps, .. } = kind.build();
            let mut renderer = Renderer::new(device, &scene, &options(None)).unwrap();
            let mut view = renderer.new_view().unwrap();
            let mut shows = |camera: &Camera| {
                let set = renderer.visible_set(&mut view, camera, Rect::whole(SIZE)).unwrap();
                let objects = renderer.hierarchy().leaf_objects();
                let subject = ObjectId(subject as u32);
                set.leaves().iter().any(|leaf| objects[leaf.0 as usize] == subject)
            };
            let shown = walk.iter().filter(|camera| shows(camera)).count();
            let hides = shown < walk.len();
            assert!(shown > 3 && (hides || kind == Reported::Sky), "{kind:?}: {shown}");
            // A method that draws the visible objects of an earlier frame loses objects here, and
            // the comparison detects it.
            let cameras: Vec<Camera> = walk.into_iter().chain(jumps).collect();
            let late =
                walk_cameras_with(device, &scene, &cameras, &options(None), methods::NEXT_FRAME);
            assert!(late.pixels_wrong > 0, "{kind:?}: {late:?}");
        }
    });
}

#[test]
fn the_scenes_look_as_in_the_page() {
    run(Driver::Lavapipe, |device| {
        for kind in Reported::ALL {
            let Provocation { scene, walk, portrait, .. } = kind.build();
            let options = RendererOptions { size: golden::SIZE, ..options(None) };
            let mut renderer = Renderer::new(device, &scene, &options).unwrap();
            let mut view = renderer.new_view().unwrap();
            let camera = &walk[portrait..=portrait];
            let frames = frame_loop(&mut renderer, &mut view, Strategy::ANTUMBRA, camera);
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/lab/other_engines");
            let file = folder.join(kind.name()).with_extension("png");
            golden::check(&file, &frames.images[0].rgba8().unwrap());
        }
    });
}
