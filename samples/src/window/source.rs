//! Where what is shown comes from.

use std::path::PathBuf;

use crate::options::{MadeScene, PathChoice};

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
    /// The recorded path that is walked again.
    pub fn recorded_path(&self) -> Option<&PathBuf> {
        match self {
            Self::Made { path: Some(PathChoice::Recorded(file)), .. } => Some(file),
            Self::Made { .. } | Self::Nothing { .. } => None,
            Self::File { settings, .. } => settings.recorded.as_ref(),
        }
    }

    /// The same settings for another file, which has other cameras.
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
#[derive(Clone, Debug, PartialEq)]
pub struct FileSource {
    /// The camera to begin with; the first one if none is named.
    pub camera: Option<String>,
    /// The recorded path along which the camera goes.
    pub recorded: Option<PathBuf>,
    /// What all light is multiplied with.
    pub exposure: f32,
    /// By how many pixels surfaces may be off where objects take coarser forms; `None` has the finest.
    pub detail_pixels: Option<f32>,
}

impl Default for FileSource {
    fn default() -> Self {
        Self { camera: None, recorded: None, exposure: 1.0, detail_pixels: None }
    }
}
