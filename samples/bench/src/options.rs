//! The options of a walk, checked: [`crate::args`] makes them from the command line.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use antumbra::cull::SectionPlanes;
use antumbra::gpu::SampleCount;
use antumbra::import::BrokenParts;
use scenes::{GeneratedScene, GeneratorError, LightSet};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::choices::{
    CameraPathChoice, CostModelChoice, DeviceChoice, EdgesChoice, GeneratorChoice,
    PredicatesChoice, ProjectionChoice, QuirksChoice, ValidationChoice, Verify,
};
use crate::shadow_choice::ShadowChoice;
use crate::strategy::Strategy;
use crate::terminal::shown;
use crate::transparency::TransparencyChoice;

/// A strategy that does not run, and the reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeftOut {
    /// The name of the strategy.
    pub strategy: String,
    /// The reason why it cannot run here.
    pub reason: String,
}

/// The most objects a scene may have.
pub const MAX_OBJECTS: u32 = scenes::MAX_OBJECTS;
/// The most frames a walk may have.
pub const MAX_FRAMES: u32 = 1_000_000;
/// The most frames that may be in flight.
pub const MAX_FRAMES_IN_FLIGHT: u32 = 4;
/// The most eyes that may look.
pub const MAX_VIEWS: u32 = 2;
/// The number of images of frames that a walk leaves without `--images`.
pub const DEFAULT_IMAGES: u32 = 4;

/// A command line that cannot be carried out: one sentence that names the error and the remedy.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct UsageError(pub String);

/// Width and height of the rendered frames in pixels, neither of them 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameSize {
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
}

impl FromStr for FrameSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |text: &str| text.parse::<u32>().ok().filter(|&side| side > 0);
        let sides = text.split_once(['x', 'X']);
        let sides = sides.and_then(|(width, height)| side(width).zip(side(height)));
        let size = sides.map(|(width, height)| Self { width, height });
        size.ok_or_else(|| {
            "it takes two whole numbers of pixels above 0, such as 1280x720".to_owned()
        })
    }
}

impl fmt::Display for FrameSize {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}x{}", self.width, self.height)
    }
}

/// The scene of a walk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SceneChoice {
    /// A scene that is generated.
    Made(MadeScene),
    /// The scene in this file.
    File(PathBuf),
}

impl fmt::Display for SceneChoice {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Made(made) => made.scene.fmt(formatter),
            Self::File(file) => shown(file).fmt(formatter),
        }
    }
}

/// A scene that is generated from a few numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MadeScene {
    /// The kind of scene.
    pub scene: GeneratorChoice,
    /// The approximate number of its objects: 1 to [`MAX_OBJECTS`].
    pub objects: u32,
    /// The seed: the same one makes the same scene and the same paths.
    pub seed: u64,
}

impl MadeScene {
    /// Makes the scene.
    ///
    /// # Errors
    /// Numbers from which no scene can be made.
    pub fn make(&self) -> Result<GeneratedScene, GeneratorError> {
        match self.scene {
            GeneratorChoice::City => scenes::city(self.objects, self.seed),
            GeneratorChoice::Field => scenes::field(self.objects, self.seed),
            GeneratorChoice::Assembly => {
                scenes::assembly(self.objects, self.seed).map(|made| made.generated)
            }
            GeneratorChoice::Waffle => {
                let made = scenes::waffle_maker();
                Ok(GeneratedScene { scene: made.scene, routes: made.routes })
            }
        }
    }
}

/// The camera's path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PathChoice {
    /// A path made for the scene.
    Made(CameraPathChoice),
    /// The recorded path in this file.
    Recorded(PathBuf),
    /// The camera of this name in the scene's file; the first one, or a turn around the scene where
    /// there is none. A name that no camera has may be a recorded path.
    OfFile(Option<String>),
}

impl fmt::Display for PathChoice {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Made(path) => path.fmt(formatter),
            Self::Recorded(file) => shown(file).fmt(formatter),
            Self::OfFile(name) => name.as_deref().unwrap_or("the first camera").fmt(formatter),
        }
    }
}

/// A walk, fully described. Every value is in its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The scene to walk through: generated, or out of a file.
    pub scene: SceneChoice,
    /// The treatment of broken parts of a file.
    pub broken_parts: BrokenParts,
    /// The triangles above which a mesh of a file is cut into pieces, if one is.
    pub cut_above_triangles: Option<usize>,
    /// The lights on it; none where it has its own, or no surfaces that they could shine on.
    pub lights: Option<LightSet>,
    /// The ways to draw shadows, each with each strategy; empty where nothing is said about
    /// lights: no shadows then.
    pub shadows: Vec<ShadowChoice>,
    /// The camera's path.
    pub path: PathChoice,
    /// The number of eyes: 1, or a pair side by side; the frame has at least a column for each.
    pub views: u32,
    /// The projection of the cameras.
    pub projection: ProjectionChoice,
    /// The edges of objects.
    pub edges: EdgesChoice,
    /// The order of transparent objects.
    pub transparency: TransparencyChoice,
    /// The percentage of objects that move: 0 to 100, and 0 in a scene out of a file.
    pub moving_percent: u32,
    /// Timed frames of each strategy: 1 to [`MAX_FRAMES`].
    pub frames: u32,
    /// Size of the frames; the device may have a lower limit.
    pub size: FrameSize,
    /// Samples per pixel.
    pub samples: SampleCount,
    /// The strategies to compare: at least one, each once, in the order asked for.
    pub strategies: Vec<Strategy>,
    /// Those of all strategies that cannot run here.
    pub left_out: Vec<LeftOut>,
    /// The frames that are compared with plain frustum culling.
    pub verify: Verify,
    /// The number of frames that the CPU may be ahead of the GPU: 1 to [`MAX_FRAMES_IN_FLIGHT`].
    pub frames_in_flight: u32,
    /// The cost model.
    pub cost_model: CostModelChoice,
    /// True if the GPU time of every pass is measured.
    pub time_passes: bool,
    /// The device that draws.
    pub device: DeviceChoice,
    /// The checks of the validation layer.
    pub validation: ValidationChoice,
    /// The quirks of the driver that are looked for.
    pub quirks: QuirksChoice,
    /// The way in which hidden draws are skipped.
    pub predicates: PredicatesChoice,
    /// The largest number of visible pixels that counts as hidden; 0 where all is exact.
    pub threshold_pixels: u32,
    /// The planes that cut the scene.
    pub section: SectionPlanes,
    /// Folder of GLSL that replaces the embedded shaders.
    pub shaders: Option<PathBuf>,
    /// Folder for images.
    pub output: Option<PathBuf>,
    /// File for the report, as JSON.
    pub report: Option<PathBuf>,
    /// The number of frames that become images in `output`, spread over the walk; 0 without a
    /// folder.
    pub images: u32,
    /// The frame that is also drawn from above, with frontier and frustum; none without a folder.
    pub top_down: Option<u32>,
    /// True if each of the images has a companion: how many surfaces are drawn at each pixel.
    pub has_depth_complexity: bool,
}

/// Reads a number of samples per pixel.
///
/// # Errors
/// A number that is neither 1 nor 4.
pub fn parse_samples(text: &str) -> Result<SampleCount, String> {
    let count = text.parse::<u32>().map_err(|_| "it takes 1 or 4".to_owned())?;
    SampleCount::try_from(count).map_err(|error| error.to_string())
}

impl Options {
    /// Returns the frames that become images: `images` of them, spread evenly, the first one
    /// included.
    pub fn image_frames(&self) -> Vec<u32> {
        let frames = u64::from(self.frames);
        let images = u64::from(self.images);
        (0..images).filter_map(|image| u32::try_from(image * frames / images).ok()).collect()
    }
}
