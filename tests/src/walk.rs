//! Walks through scenes with two strategies and compares every image bit for bit.

use cull::{Aabb, Camera, Projection, Strategy};
use glam::Vec3;
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

/// Returns cameras in the middle and at two corners of every `step`th object, that look in all
/// directions.
pub fn eyes_in_boxes(scene: &Scene, step: usize) -> Vec<Camera> {
    let boxes = render::object_bounds(scene).expect("bounds");
    let eyes = boxes.iter().step_by(step).flat_map(|bounds| {
        let Aabb { min, max } = *bounds;
        [bounds.centre(), min, max]
    });
    let camera = |(number, eye): (usize, Vec3)| {
        let angle = number as f32 * 2.4;
        let forward = Vec3::new(angle.cos(), (number % 5) as f32 * 0.3 - 0.6, angle.sin());
        Camera { eye, forward, up: Vec3::Y, projection: Projection::perspective(1.2), near: 0.05 }
    };
    eyes.enumerate().map(camera).collect()
}

/// Returns cameras over a city of one object, in whose view is the object or nothing.
pub fn up_and_down() -> [Camera; 5] {
    let down = Vec3::new(0.1, -1.0, 0.2);
    [Vec3::NEG_Y, Vec3::Y, down, down, Vec3::Y].map(|forward| Camera {
        eye: Vec3::new(1.0, 30.0, 2.0),
        forward,
        up: Vec3::X,
        projection: Projection::perspective(1.0),
        near: 0.1,
    })
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

/// Walks `frames` frames of `path` without a wait in between, as in a user's loop, and compares
/// each image with plain frustum culling.
pub fn walk_with(
    device: &Device,
    scene: &GeneratedScene,
    path: PathKind,
    frames: u32,
    options: &RendererOptions,
    strategy: Strategy,
) -> Found {
    walk_cameras_with(device, &scene.scene, &cameras_along(scene, path, frames), options, strategy)
}

/// Returns the cameras of the first frames of a path.
pub fn cameras_along(scene: &GeneratedScene, path: PathKind, frames: u32) -> Vec<Camera> {
    let path = CameraPath::new(path, &scene.routes).expect("a path");
    (0..frames).map(|frame| path.camera(frame)).collect()
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
    ComparedWalk::new(device, scene, cameras, options).with(strategy)
}

/// A renderer and the frames of plain frustum culling, with which walks of several strategies are
/// compared.
pub struct ComparedWalk<'a, T> {
    renderer: Renderer,
    cameras: &'a [T],
    expected: Loop,
}

impl<'a, T: Copy + Into<Viewpoint>> ComparedWalk<'a, T> {
    /// Walks with plain frustum culling.
    pub fn new(
        device: &Device,
        scene: &Scene,
        cameras: &'a [T],
        options: &RendererOptions,
    ) -> Self {
        assert!(!cameras.is_empty(), "nothing to compare");
        let mut renderer = Renderer::new(device, scene, options).expect("a renderer");
        let expected = Self::frames(&mut renderer, cameras, Strategy::FRUSTUM);
        Self { renderer, cameras, expected }
    }

    /// Returns true if the device supports a strategy.
    pub fn supports(&self, strategy: Strategy) -> bool {
        self.renderer.supports(strategy).is_ok()
    }

    /// Walks with a strategy from an empty history, and compares each image.
    pub fn with(&mut self, strategy: Strategy) -> Found {
        let found = Self::frames(&mut self.renderer, self.cameras, strategy);
        let pairs = self.expected.images.iter().zip(&found.images);
        let ages = found.reports.iter().filter_map(|report| report.oldest_answer_frames);
        Found {
            frames: self.cameras.len() as u32,
            pixels_wrong: pairs.map(|(expected, found)| images_that_differ(expected, found)).sum(),
            blocking_waits: self.expected.blocking_waits + found.blocking_waits,
            oldest_answer_frames: ages.max().unwrap_or(0),
            draws: [&self.expected, &found].map(Loop::draws),
        }
    }

    fn frames(renderer: &mut Renderer, cameras: &[T], strategy: Strategy) -> Loop {
        let mut view = renderer.new_view().expect("a view");
        let walked = frame_loop(renderer, &mut view, strategy, cameras);
        assert_eq!(walked.outcomes.len(), cameras.len(), "every frame has an outcome");
        walked
    }
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

impl Loop {
    /// Returns the number of drawn objects, over all frames.
    pub fn draws(&self) -> u64 {
        self.outcomes.iter().map(|outcome| outcome.draws).sum()
    }
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

/// Returns the number of pixels whose bits differ in the images of two frames that are over.
pub fn images_that_differ(a: &Readback, b: &Readback) -> usize {
    pixels_that_differ(&pixels(a), &pixels(b))
}

/// Returns the number of pixels whose bits differ.
pub fn pixels_that_differ(a: &[u8], b: &[u8]) -> usize {
    assert!(!a.is_empty() && a.len() == b.len(), "nothing to compare");
    a.chunks_exact(4).zip(b.chunks_exact(4)).filter(|(a, b)| a != b).count()
}
