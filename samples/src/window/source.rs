//! Where what is shown comes from.

use std::path::PathBuf;

use bench::options::{MadeScene, PathChoice};

/// Where it comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// It is made.
    Made {
        /// From these numbers.
        made: MadeScene,
        /// Where the camera goes by itself.
        path: Option<PathChoice>,
    },
    /// Out of a glTF file.
    File {
        /// The file.
        file: PathBuf,
        /// How it is shown.
        settings: FileSource,
    },
    /// Nowhere, until a file is dropped into the window.
    Nothing {
        /// How that is shown then.
        settings: FileSource,
    },
}

impl Source {
    /// Returns the recorded path that is walked again.
    pub fn recorded_path(&self) -> Option<&PathBuf> {
        match self {
            Self::Made { path: Some(PathChoice::Recorded(file)), .. } => Some(file),
            Self::Made { .. } | Self::Nothing { .. } => None,
            Self::File { settings, .. } => settings.recorded.as_ref(),
        }
    }

    /// Returns the file, if it comes out of one.
    pub fn file(&self) -> Option<&PathBuf> {
        match self {
            Self::File { file, .. } => Some(file),
            Self::Made { .. } | Self::Nothing { .. } => None,
        }
    }

    /// Returns its name, for people.
    pub fn name(&self) -> String {
        match self {
            Self::Made { made, .. } => made.scene.to_string(),
            Self::File { file, .. } => {
                file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned()
            }
            Self::Nothing { .. } => "nothing".to_owned(),
        }
    }

    /// Returns the same settings for another file, which has other cameras.
    pub fn settings_for_another(&self) -> FileSource {
        match self {
            Self::Made { .. } => FileSource::default(),
            Self::File { settings, .. } | Self::Nothing { settings } => {
                FileSource { camera: None, recorded: None, ..settings.clone() }
            }
        }
    }
}

/// How a file is shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileSource {
    /// The camera to begin with; the first one if none is named.
    pub camera: Option<String>,
    /// The recorded path along which the camera goes.
    pub recorded: Option<PathBuf>,
    /// What all light is multiplied with; `None` is 1, with lights dimmed that are too bright for
    /// that.
    pub exposure: Option<f32>,
    /// By how many pixels surfaces may be off where objects take coarser forms; `None` has the
    /// finest.
    pub detail_pixels: Option<f32>,
}
