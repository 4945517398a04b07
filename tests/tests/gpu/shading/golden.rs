//! Real scenes look like the committed images, and are exact while they move.
//!
//! The scenes are not part of the project. ANTUMBRA_ASSETS names their folder; without it these
//! tests report that they were skipped. With ANTUMBRA_GOLDEN=write the tests write the images
//! again, to be checked and committed.

use std::fs;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use cull::{Camera, Strategy};
use gpu::{Device, Readback};
use import::{GltfScene, LoadOptions, SceneAnimator};
use render::{CostModel, FrameRequest, RenderView, Renderer, RendererOptions};
use tests::walk::{images_that_differ, pixels_that_differ};
use tests::{Driver, run};

/// The size of a golden image in pixels.
pub(crate) const SIZE: [u32; 2] = [256, 144];

/// The files and their cameras. Without a camera, the view shows the whole scene.
const SCENES: [(&str, &[Option<&str>]); 5] = [
    ("fox.glb", &[None]),
    ("morphstresstest.gltf", &[None]),
    ("kaykit_city.glb", &[Some("street"), Some("fly")]),
    ("kaykit_dungeon.glb", &[Some("walk"), Some("fly")]),
    ("rooms.glb", &[Some("walk"), Some("fly")]),
];

/// The times of the images, in seconds.
const MOMENTS_S: [f64; 2] = [0.4, 5.0];

fn assets() -> Option<PathBuf> {
    let folder = std::env::var_os("ANTUMBRA_ASSETS").map(PathBuf::from);
    if folder.is_none() {
        // Not by `eprintln!`, whose output is hidden if the test passes.
        let _told = writeln!(
            std::io::stderr(),
            "SKIPPED: ANTUMBRA_ASSETS does not name the folder of the test scenes"
        );
    }
    folder
}

/// A scene of a file on a device, with its animation.
struct Stage {
    renderer: Renderer,
    animator: SceneAnimator,
    camera: Option<import::SceneCamera>,
    still: Camera,
}

impl Stage {
    fn open(device: &Device, file: &Path, camera: Option<&str>) -> Self {
        let imported: GltfScene =
            import::load(file, &LoadOptions::default(), &mut |_| ControlFlow::Continue(()))
                .unwrap();
        let still = imported.default_camera(SIZE);
        let (scene, mut animator, cameras, _) = SceneAnimator::of(imported);
        let options =
            RendererOptions { size: SIZE, cost_model: CostModel::Off, ..Default::default() };
        let renderer = Renderer::new(device, &scene, &options).unwrap();
        let find = |name: &str| cameras.iter().find(|camera| camera.name == name).cloned();
        let camera = camera.map(|name| find(name).expect("the camera"));
        let first = camera.as_ref().and_then(|camera| animator.clip_of(camera));
        let clips = animator.compatible(first);
        animator.play(&clips, 0.0, 0.0);
        Self { renderer, animator, camera, still }
    }

    fn image(&mut self, view: &mut RenderView, strategy: Strategy, seconds: f64) -> Readback {
        self.renderer.apply(self.animator.changes(seconds)).unwrap();
        let seen = self.camera.as_ref().map(|camera| self.animator.seen_by(camera, SIZE));
        let image = Readback::new(self.renderer.device(), SIZE).unwrap();
        let request = FrameRequest {
            image: Some(&image),
            ..FrameRequest::new(strategy, seen.unwrap_or(self.still))
        };
        self.renderer.render(view, request).unwrap();
        image
    }
}

fn each(test: impl Fn(&Device, &Path, Option<&str>)) {
    let Some(folder) = assets() else { return };
    run(Driver::Lavapipe, |device| {
        for (file, cameras) in SCENES {
            for camera in cameras {
                test(device, &folder.join(file), *camera);
            }
        }
    });
}

#[test]
fn every_frame_is_exact_while_the_scene_lives() {
    each(|device, file, camera| {
        let mut stage = Stage::open(device, file, camera);
        let strategies = [Strategy::FRUSTUM, Strategy::ANTUMBRA];
        let mut views = strategies.map(|_| stage.renderer.new_view().unwrap());
        // Plain frustum culling takes seconds per frame for 65 million triangles.
        let frames = if file.ends_with("rooms.glb") { 6 } else { 24 };
        let frames: Vec<[Readback; 2]> = (0..frames)
            .map(|frame| {
                let seconds = f64::from(frame) * 0.25;
                let images = strategies.iter().zip(&mut views);
                let images = images.map(|(strategy, view)| stage.image(view, *strategy, seconds));
                images.collect::<Vec<_>>().try_into().ok().unwrap()
            })
            .collect();
        views.iter_mut().for_each(|view| stage.renderer.wait_idle(view).unwrap());
        for (frame, [all, ours]) in frames.iter().enumerate() {
            let wrong = images_that_differ(all, ours);
            assert_eq!(wrong, 0, "{} {camera:?}, frame {frame}", file.display());
        }
        let first = frames[0][1].rgba8().unwrap();
        let lives =
            frames.iter().any(|[_, ours]| pixels_that_differ(&first, &ours.rgba8().unwrap()) > 0);
        assert!(lives, "{} {camera:?} does not live", file.display());
    });
}

#[test]
fn scenes_look_as_they_did() {
    each(|device, file, camera| {
        let mut stage = Stage::open(device, file, camera);
        let mut view = stage.renderer.new_view().unwrap();
        for (number, seconds) in MOMENTS_S.into_iter().enumerate() {
            let image = stage.image(&mut view, Strategy::ANTUMBRA, seconds);
            stage.renderer.wait_idle(&mut view).unwrap();
            let stem = file.file_stem().unwrap().to_str().unwrap();
            let name = format!("{stem}_{}_{number}.png", camera.unwrap_or("whole"));
            let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden").join(&name);
            check(&golden, &image.rgba8().unwrap());
        }
    });
}

/// Checks that an image of [`SIZE`] looks like its file, or writes the file with
/// ANTUMBRA_GOLDEN=write.
pub(crate) fn check(golden: &Path, found: &[u8]) {
    if std::env::var("ANTUMBRA_GOLDEN").is_ok_and(|what| what == "write") {
        return write(golden, found);
    }
    let (far, mean) = difference(&read(golden), found);
    let name = golden.display();
    assert!(far <= 0.002 && mean <= 0.25, "{name}: {far} of the pixels are far, mean {mean}");
}

/// Returns the share of pixels with a channel that is off by more than 8 of 255, and the mean
/// difference.
fn difference(golden: &[u8], found: &[u8]) -> (f64, f64) {
    assert_eq!(golden.len(), found.len());
    let far = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 8);
    let pixels = || golden.chunks_exact(4).zip(found.chunks_exact(4));
    let sum: u64 = golden.iter().zip(found).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    let count = pixels().count() as f64;
    (pixels().filter(far).count() as f64 / count, sum as f64 / golden.len() as f64)
}

fn read(path: &Path) -> Vec<u8> {
    let file = fs::File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    bytes.chunks_exact(3).flat_map(|pixel| [pixel[0], pixel[1], pixel[2], 255]).collect()
}

fn write(path: &Path, rgba8: &[u8]) {
    let mut encoder = png::Encoder::new(fs::File::create(path).unwrap(), SIZE[0], SIZE[1]);
    encoder.set_color(png::ColorType::Rgb);
    let pixels: Vec<u8> =
        rgba8.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
}

#[test]
fn the_comparison_sees_a_difference() {
    let black = vec![0; 4000];
    let mut other = vec![0; 4000];
    assert_eq!(difference(&black, &other), (0.0, 0.0));
    other[40] = 9;
    let (far, mean) = difference(&black, &other);
    assert!((far - 0.001).abs() < 1.0e-9 && mean > 0.0);
}
