//! Walks through scenes with two strategies and compares every image bit for bit.

use cull::{Camera, Strategy};
use gpu::{Device, Pixels, Readback};
use render::{
    Error, FrameReport, FrameRequest, FrameStats, RenderView, Renderer, RendererOptions,
    UpdateReport, Viewpoint,
};
use scene::Scene;
use scenes::{CameraPath, Cast, GeneratedScene, Motion, PathKind};

/// A scene by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SceneKind {
    /// The procedural city.
    City,
    /// The procedural field.
    Field,
}

impl SceneKind {
    /// Both kinds of scenes.
    pub const ALL: [SceneKind; 2] = [SceneKind::City, SceneKind::Field];

    /// Builds the scene.
    pub fn build(self, objects: u32) -> GeneratedScene {
        let scene = match self {
            SceneKind::City => scenes::city(objects, 7),
            SceneKind::Field => scenes::field(objects, 7),
        };
        scene.expect("a scene")
    }
}

/// Shows a motion at `frame`.
///
/// # Errors
/// As [`Renderer::update`]. After an error, the scene and `cast` are unchanged.
pub fn show_motion(
    renderer: &mut Renderer,
    motion: &Motion,
    cast: &mut Cast,
    frame: u32,
) -> Result<UpdateReport, Error> {
    let report = renderer.update(cast.changes(motion, frame))?;
    cast.came(&report.added);
    Ok(report)
}

/// The results of a walk.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Found {
    /// Frames compared with the reference, pixel by pixel.
    pub frames: u32,
    /// Pixels that differed, over all frames.
    pub pixels_wrong: usize,
    /// Waits in the frame loops, except waits for slots.
    pub blocking_waits: u64,
    /// The age of the oldest answer that was read back, in frames.
    pub oldest_answer_frames: u64,
    /// The number of objects drawn by frustum culling and by the strategy, over all frames.
    pub draws: [u64; 2],
}

/// Walks `frames` frames of `path` with `antumbra` without a wait in between, as in a user's loop,
/// and compares each image with plain frustum culling.
pub fn walk(
    device: &Device,
    scene: &GeneratedScene,
    path: PathKind,
    frames: u32,
    options: &RendererOptions,
) -> Found {
    walk_with(device, scene, path, frames, options, Strategy::ANTUMBRA)
}

/// Walks with any strategy, and compares each image with plain frustum culling.
pub fn walk_with(
    device: &Device,
    GeneratedScene { scene, routes }: &GeneratedScene,
    path: PathKind,
    frames: u32,
    options: &RendererOptions,
    strategy: Strategy,
) -> Found {
    let path = CameraPath::new(path, routes).expect("a path");
    let cameras: Vec<Camera> = (0..frames).map(|frame| path.camera(frame)).collect();
    walk_cameras_with(device, scene, &cameras, options, strategy)
}

/// Walks along any cameras or matrices with `antumbra`.
pub fn walk_cameras(
    device: &Device,
    scene: &Scene,
    cameras: &[impl Copy + Into<Viewpoint>],
    options: &RendererOptions,
) -> Found {
    walk_cameras_with(device, scene, cameras, options, Strategy::ANTUMBRA)
}

/// Walks along any cameras or matrices with any strategy.
pub fn walk_cameras_with(
    device: &Device,
    scene: &Scene,
    cameras: &[impl Copy + Into<Viewpoint>],
    options: &RendererOptions,
    strategy: Strategy,
) -> Found {
    let mut renderer = Renderer::new(device, scene, options).expect("a renderer");
    let mut found = Found { frames: cameras.len() as u32, ..Found::default() };
    let mut images = Vec::new();
    for (which, strategy) in [Strategy::FRUSTUM, strategy].into_iter().enumerate() {
        let mut view = renderer.new_view().expect("a view");
        let loops = frame_loop(&mut renderer, &mut view, strategy, cameras);
        found.blocking_waits += loops.blocking_waits;
        found.draws[which] = loops.outcomes.iter().map(|outcome| outcome.draws).sum();
        assert_eq!(loops.outcomes.len(), cameras.len(), "every frame has an outcome");
        let ages = loops.reports.iter().filter_map(|report| report.oldest_answer_frames);
        found.oldest_answer_frames = ages.max().unwrap_or(0);
        images.push(loops.images);
    }
    for (reference, image) in images[0].iter().zip(&images[1]) {
        found.pixels_wrong += pixels_that_differ(&pixels(reference), &pixels(image));
    }
    found
}

/// The results of a frame loop.
pub struct Loop {
    /// An image of every frame.
    pub images: Vec<Readback>,
    /// The report of every frame when it was submitted.
    pub reports: Vec<FrameReport>,
    /// The outcome of every frame.
    pub outcomes: Vec<FrameStats>,
    /// Waits, except waits for slots.
    pub blocking_waits: u64,
}

/// Renders `cameras` one after the other without reading results, then drains.
pub fn frame_loop(
    renderer: &mut Renderer,
    view: &mut RenderView,
    strategy: Strategy,
    cameras: &[impl Copy + Into<Viewpoint>],
) -> Loop {
    let new_image = || Readback::new(renderer.device(), renderer.size()).expect("memory");
    let images: Vec<Readback> = cameras.iter().map(|_| new_image()).collect();
    let waits = renderer.device().wait_counts().other;
    let mut reports = Vec::new();
    for (camera, image) in cameras.iter().zip(&images) {
        let request = FrameRequest { image: Some(image), ..FrameRequest::new(strategy, *camera) };
        reports.push(renderer.render(view, request).expect("a frame"));
    }
    let blocking_waits = renderer.device().wait_counts().other - waits;
    renderer.wait_idle(view).expect("the end");
    let outcomes: Vec<FrameStats> = view.drain_stats().collect();
    assert!(outcomes.is_sorted_by_key(|outcome| outcome.frame), "{outcomes:?}");
    Loop { images, reports, outcomes, blocking_waits }
}

fn pixels(image: &Readback) -> Pixels<'_> {
    image.rgba8().expect("a frame that is over")
}

/// Returns the number of pixels whose bits differ.
pub fn pixels_that_differ(a: &[u8], b: &[u8]) -> usize {
    assert!(!a.is_empty() && a.len() == b.len(), "nothing to compare");
    a.chunks_exact(4).zip(b.chunks_exact(4)).filter(|(a, b)| a != b).count()
}
