//! The values of single arguments.

use std::path::PathBuf;
use std::str::FromStr;

use crate::choices::{GeneratorChoice, each_once, parse_named, parse_strategy};
use crate::strategy::Strategy;

/// A generated scene, or the file of a scene. A name with a dot or a slash names a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SceneArgument {
    /// A scene that is generated.
    Made(GeneratorChoice),
    /// A scene in this file.
    File(PathBuf),
}

impl FromStr for SceneArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.contains(['.', '/', std::path::MAIN_SEPARATOR]) {
            return Ok(Self::File(PathBuf::from(text)));
        }
        parse_named("scene", text)
            .map(Self::Made)
            .map_err(|message| format!("{message} (a file has a dot or a slash in its name)"))
    }
}

/// Strategies to compare.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StrategyList {
    /// All that can run.
    All,
    /// These, each of them once.
    These(Vec<Strategy>),
}

impl FromStr for StrategyList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "all" {
            return Ok(Self::All);
        }
        each_once(text, parse_strategy).map(Self::These)
    }
}

/// The frame that is shown from above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TopDown {
    /// No frame is shown from above.
    Off,
    /// The frame of this number.
    Frame(u32),
}

impl FromStr for TopDown {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "off" => Ok(Self::Off),
            _ => text.parse().map(Self::Frame).map_err(|_| "it takes a frame, or off".to_owned()),
        }
    }
}
