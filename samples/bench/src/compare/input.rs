//! Reads the reports of `walkthrough` back: a folder of JSON files, as much of each as a comparison
//! needs. Unknown keys are ignored, and newer keys may be missing.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;

use crate::input_file;
use crate::options::LeftOut;
use crate::provenance::Provenance;
use crate::statistics::TimeSummary;
use crate::terminal::shown;

/// The largest file that is read: a report of a million frames and a dozen strategies is smaller.
const MOST_BYTES: u64 = 512 << 20;

/// The reasons why there is nothing to compare.
#[derive(Debug, Error)]
pub enum InputError {
    /// The folder cannot be read.
    #[error(
        "cannot read the folder '{}': {reason}; name one that holds reports of walkthrough",
        shown(folder)
    )]
    Folder {
        /// The folder that was asked for.
        folder: PathBuf,
        /// The system's reason.
        reason: std::io::Error,
    },
    /// The folder has no report.
    #[error("there is no report in '{}': run ci/compare, or write some there with 'walkthrough --report {}/NAME.json'", shown(.0), shown(.0))]
    Empty(PathBuf),
    /// The notes cannot be read.
    #[error("cannot read the notes '{}': {reason}; name a text file", shown(file))]
    Notes {
        /// The file of notes.
        file: PathBuf,
        /// The system's reason.
        reason: std::io::Error,
    },
    /// A file that is no report.
    #[error(
        "'{}' is no report of walkthrough: {reason}; remove it or measure it again",
        shown(file)
    )]
    Broken {
        /// The path of the refused file.
        file: PathBuf,
        /// The error in it.
        reason: String,
    },
}

/// One report: a walk of some strategies.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Measured {
    /// The file's name without its folder.
    #[serde(skip)]
    pub file: String,
    /// The device that drew.
    pub device: MeasuredDevice,
    /// The scene that was drawn.
    pub scene: MeasuredScene,
    /// The lights on the scene, if any were asked for.
    pub lights: Option<String>,
    /// The section planes, if it was cut.
    pub section: Option<MeasuredSection>,
    /// The percentage of objects that were asked to move.
    pub moving_percent: u32,
    /// The name of the camera's path.
    pub path: String,
    /// The number of eyes.
    pub views: u32,
    /// True if a signal ended the walk.
    pub cut_short: bool,
    /// The timed frames of each strategy.
    pub frames: u32,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples per pixel.
    pub samples_per_pixel: u32,
    /// The number of frames that the CPU was allowed to be ahead.
    pub frames_in_flight: u32,
    /// The way in which hidden draws were skipped.
    pub predicates: String,
    /// The largest number of visible pixels that counted as hidden.
    pub threshold_pixels: u32,
    /// Strategies that could not run, and the reasons.
    pub left_out: Vec<LeftOut>,
    /// The runs, one per strategy.
    pub runs: Vec<MeasuredRun>,
    /// "A/B": ratio of the medians.
    pub ratios: BTreeMap<String, Option<f64>>,
    /// "A/B": median of the ratios frame by frame.
    pub paired_ratios: BTreeMap<String, Option<f64>>,
    /// The command line and the time.
    pub provenance: Provenance,
}

/// The section planes of a report.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct MeasuredSection {
    /// The part that the planes keep.
    pub mode: String,
    /// Normal and offset in metres of each plane.
    pub planes: Vec<[f64; 4]>,
}

/// The device of a report.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct MeasuredDevice {
    /// Its name, as the driver reports it.
    pub name: String,
    /// Name and version of the driver.
    pub driver: String,
    /// The Vulkan version that it implements.
    pub api: String,
}

/// The scene of a report.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct MeasuredScene {
    /// Its name on the command line.
    pub name: String,
    /// The exact number of its objects.
    pub objects: u64,
}

/// One strategy of a report.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct MeasuredRun {
    /// The name of the strategy.
    pub strategy: String,
    /// The way to make shadows, where something is said about lights.
    pub shadows: Option<String>,
    /// The filter of shadow maps.
    pub filter: Option<String>,
    /// Shadow maps that were drawn per frame.
    pub shadow_faces: Option<u64>,
    /// Casters in them, culled or not.
    pub shadow_casters: Option<u64>,
    /// Triangles of casters that were drawn.
    pub shadow_triangles: Option<u64>,
    /// The mean difference of a channel from the same image with 64 samples everywhere, of 255.
    pub fixed64_difference_mean: Option<f64>,
    /// The greatest such difference.
    pub fixed64_difference_max: Option<u64>,
    /// The GPU time of each pass by its label, if it was measured.
    pub passes_ms: BTreeMap<String, TimeSummary>,
    /// The time of a frame in milliseconds.
    pub frame_ms: TimeSummary,
    /// The time of every frame, in the order of the path.
    pub frame_times_ms: Vec<Option<f64>>,
    /// The CPU time of the engine per frame, in milliseconds.
    pub cpu_ms: TimeSummary,
    /// The draws per frame.
    pub draws: Option<u64>,
    /// The boxes tested per frame, by all mechanisms.
    pub tests: Option<u64>,
    /// The occlusion queries per frame.
    pub queries: Option<u64>,
    /// The nodes of the hierarchy that the culler visited per frame.
    pub nodes_visited: Option<u64>,
    /// The timed frames that were compared with plain frustum culling.
    pub frames_verified: u64,
    /// The warm-up frames that were compared.
    pub warm_up_frames_verified: u64,
    /// The pixels that differed in them.
    pub pixels_wrong: Option<u64>,
}

impl Measured {
    /// Returns the run of a strategy.
    pub fn run(&self, strategy: &str) -> Option<&MeasuredRun> {
        self.runs.iter().find(|run| run.strategy == strategy)
    }

    /// Returns the value of an option in the command line that made the report, as `--option value`
    /// or `--option=value`; the last one of several, as in `walkthrough`.
    pub fn argument(&self, option: &str) -> Option<&str> {
        let words = &self.provenance.command;
        let with_sign = format!("{option}=");
        words.iter().enumerate().rev().find_map(|(place, word)| {
            match word.strip_prefix(&with_sign) {
                Some(value) => Some(value),
                None if word == option => words.get(place + 1).map(String::as_str),
                None => None,
            }
        })
    }

    /// Returns the lights that were asked for, in words.
    pub fn light_words(&self) -> Option<String> {
        let lights = self.lights.as_deref()?;
        Some(match lights.parse::<u32>() {
            Ok(lamps) => format!("{lamps} lamps"),
            Err(_) => lights.to_owned(),
        })
    }

    /// Returns true if frames were compared: their copies cost time, so their times mean less.
    pub fn is_verified(&self) -> bool {
        self.runs.iter().any(|run| run.frames_verified > 0)
    }
}

/// Reads every `.json` file of a folder, in the order of their names.
///
/// # Errors
/// When the folder cannot be read or has no report, or for a file that is none, with the reason.
pub fn read_folder(folder: &Path) -> Result<Vec<Measured>, InputError> {
    let failed = |reason| InputError::Folder { folder: folder.to_owned(), reason };
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let is_hidden =
            path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if path.extension().is_some_and(|extension| extension == "json") && !is_hidden {
            files.push(path);
        }
    }
    files.sort();
    if files.is_empty() {
        return Err(InputError::Empty(folder.to_owned()));
    }
    files.into_iter().map(read_report).collect()
}

/// Reads the lines of a file of notes, each once; full stops at the ends are removed.
///
/// # Errors
/// When the file cannot be read.
pub fn read_notes(file: &Path) -> Result<Vec<String>, InputError> {
    let text = input_file::read_text(file, MOST_BYTES)
        .map_err(|reason| InputError::Notes { file: file.to_owned(), reason })?;
    let mut notes = Vec::new();
    for line in text.lines().map(|line| line.trim().trim_end_matches('.').to_owned()) {
        if !line.is_empty() && !notes.contains(&line) {
            notes.push(line);
        }
    }
    Ok(notes)
}

fn read_report(file: PathBuf) -> Result<Measured, InputError> {
    let text = match input_file::read_text(&file, MOST_BYTES) {
        Ok(text) => text,
        Err(error) => return Err(InputError::Broken { file, reason: error.to_string() }),
    };
    let mut measured = match parse(&text) {
        Ok(measured) => measured,
        Err(reason) => return Err(InputError::Broken { file, reason }),
    };
    measured.file = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(measured)
}

/// Returns the report in this JSON.
///
/// # Errors
/// The first error in it.
pub fn parse(text: &str) -> Result<Measured, String> {
    let measured: Measured = serde_json::from_str(text).map_err(|error| error.to_string())?;
    if measured.scene.name.is_empty() || measured.path.is_empty() || measured.runs.is_empty() {
        return Err("it has no scene, no path or no runs".to_owned());
    }
    Ok(measured)
}
