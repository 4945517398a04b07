//! The scene, the path and the frames of a walk: [`crate::args`] makes them from the command line.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use antumbra::gpu::SampleCount;
use scenes::{GeneratedScene, GeneratorError};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::choices::{CameraPathChoice, GeneratorChoice};
use crate::terminal::shown;

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
/// The most eyes of a walk.
pub const MAX_VIEWS: u32 = 2;
/// The number of images that a walk writes without `--images`.
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
    /// The camera of this name in the scene's file; without a name the first camera, or a turn
    /// around the scene if there is none. A name that no camera has may be a recorded path.
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

/// Reads a number of samples per pixel.
///
/// # Errors
/// A number that is neither 1 nor 4.
pub fn parse_samples(text: &str) -> Result<SampleCount, String> {
    let count = text.parse::<u32>().map_err(|_| "it takes 1 or 4".to_owned())?;
    SampleCount::try_from(count).map_err(|error| error.to_string())
}
