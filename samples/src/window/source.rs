//! The source of a scene.

use std::path::PathBuf;

use bench::options::{MadeScene, PathChoice};
use scenes::Hour;

/// The source of a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneSource {
    /// A scene that is generated.
    Made {
        /// The values from which it is generated.
        made: MadeScene,
        /// The path of the camera.
        path: Option<PathChoice>,
        /// The hour of its sun and lamps; with `None`, it has no surfaces that cast shadows.
        hour: Option<Hour>,
    },
    /// The courtyard at an hour.
    Courtyard {
        /// The hour of its sun.
        hour: Hour,
    },
    /// A scene in a file.
    File {
        /// The path of the file.
        file: PathBuf,
        /// The options of showing it.
        settings: FileSource,
    },
    /// No scene until a file is dropped into the window.
    Nothing {
        /// The options of showing that file.
        settings: FileSource,
    },
}

impl SceneSource {
    /// Returns the recorded path to replay, if there is one.
    pub fn recorded_path(&self) -> Option<&PathBuf> {
        match self {
            Self::Made { path: Some(PathChoice::Recorded(file)), .. } => Some(file),
            Self::Made { .. } | Self::Courtyard { .. } | Self::Nothing { .. } => None,
            Self::File { settings, .. } => settings.recorded.as_ref(),
        }
    }

    /// Returns the file, if the source is a file.
    pub fn file(&self) -> Option<&PathBuf> {
        match self {
            Self::File { file, .. } => Some(file),
            Self::Made { .. } | Self::Courtyard { .. } | Self::Nothing { .. } => None,
        }
    }

    /// Returns the name of the source.
    pub fn name(&self) -> String {
        match self {
            Self::Made { made, .. } => made.scene.to_string(),
            Self::Courtyard { .. } => "courtyard".to_owned(),
            Self::File { file, .. } => {
                file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned()
            }
            Self::Nothing { .. } => "nothing".to_owned(),
        }
    }

    /// Returns the settings for another file, without the choice of a camera.
    pub fn settings_for_another(&self) -> FileSource {
        match self {
            Self::Made { .. } | Self::Courtyard { .. } => FileSource::default(),
            Self::File { settings, .. } | Self::Nothing { settings } => {
                FileSource { camera: None, recorded: None, ..settings.clone() }
            }
        }
    }
}

/// The options of showing a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileSource {
    /// The name of the first camera; with `None`, the file's first camera.
    pub camera: Option<String>,
    /// The recorded path of the camera.
    pub recorded: Option<PathBuf>,
    /// The factor of all light; `None` is 1, with lights dimmed that are too bright.
    pub exposure: Option<f32>,
    /// The largest error of surfaces in pixels for coarser levels of detail; `None` uses the finest
    /// level.
    pub detail_pixels: Option<f32>,
    /// True if objects with few visible samples use coarser levels than their distance allows.
    pub has_detail_by_samples: bool,
}
