//! `report.json`: the measurements of a walk, in a form that other programs read.
//!
//! Its keys are a contract: they may grow, they do not change. Missing numbers are `null`; all
//! others are finite. Times are milliseconds, memory is MiB. `compare` reads reports back: unknown
//! keys are ignored there, and newer keys may be missing.

use std::collections::BTreeMap;
use std::path::Path;

use antumbra::cull::{Corrections, SectionMode, SectionPlane, SectionPlanes};
use serde::{Deserialize, Serialize};

use crate::options::LeftOut;
use crate::outputs::{WriteError, write_file};
use crate::provenance::Provenance;
use crate::statistics::{TimeSummary, kept, paired_ratio, ratio};
use crate::strategy::{Strategy, named};
use crate::transparency::{FragmentsReport, TransparencyReport};

/// The measurements of a walk.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Report {
    /// The name without its folder of the file that it was read from; empty after a walk.
    #[serde(skip)]
    pub file: String,
    /// The device that drew.
    pub device: DeviceReport,
    /// The scene that was drawn.
    pub scene: SceneReport,
    /// The lights on the scene, as on the command line; absent where none were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lights: Option<String>,
    /// The section planes; absent where nothing is cut.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub section: Option<SectionReport>,
    /// The name of the camera's path.
    pub path: String,
    /// The number of eyes, side by side in one frame; counts are of all together.
    pub views: u32,
    /// The projection of the cameras, as on the command line.
    pub projection: String,
    /// The percentage of objects that were asked to move.
    pub moving_percent: u32,
    /// The number of objects that moved, came or went.
    pub moving_objects: u64,
    /// Timed frames of each strategy.
    pub frames: u32,
    /// Width and height of the frames in pixels.
    pub size: [u32; 2],
    /// Samples per pixel.
    pub samples_per_pixel: u32,
    /// True if a signal ended the walk: a run may then have fewer frames than `frames`.
    pub cut_short: bool,
    /// The number of frames that the CPU was allowed to be ahead.
    pub frames_in_flight: u32,
    /// The way in which hidden draws were skipped: the one that `--predicates` chose, or the one
    /// that costs least.
    pub predicates: String,
    /// The expected time of skipping in a frame by each way, in nanoseconds; empty where none was
    /// measured.
    pub skip_ns: BTreeMap<String, Option<f64>>,
    /// The tester with the lowest expected cost before the first frame.
    pub tester: String,
    /// The times of the reset of a query in nanoseconds: by a command, and by the CPU.
    pub reset_ns: BTreeMap<String, Option<f64>>,
    /// The largest number of visible pixels that counted as hidden; 0 where all was exact.
    pub threshold_pixels: u32,
    /// The costs on this device in nanoseconds of GPU time, measured before the walk.
    pub costs_ns: BTreeMap<String, Option<f64>>,
    /// Messages of the validation layer, 0 where it was off.
    pub validation_messages: u64,
    /// Memory at the end of the walk.
    pub memory: MemoryReport,
    /// The times of the preparations.
    pub build_ms: BuildReport,
    /// Strategies that could not run, and the reasons.
    pub left_out: Vec<LeftOut>,
    /// The assumptions about the driver that do not hold, a sentence each; only `--quirks tested`
    /// finds any.
    pub driver_quirks: Vec<String>,
    /// The order of transparent objects; absent where fragments were not asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transparency: Option<TransparencyReport>,
    /// The runs, in the order asked for: one per strategy, and per way to draw shadows.
    pub runs: Vec<RunReport>,
    /// "A/B": the median frame time of A over the median of B, for every ordered pair.
    pub ratios: BTreeMap<String, Option<f64>>,
    /// "A/B": the median of the ratios of A's and B's times, frame by frame.
    pub paired_ratios: BTreeMap<String, Option<f64>>,
    /// The command line and the time of the measurement.
    pub provenance: Provenance,
}

/// The device that drew.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DeviceReport {
    /// Its name, as the driver reports it.
    pub name: String,
    /// Name and version of the driver.
    pub driver: String,
    /// The Vulkan version that it implements, as "1.3.230".
    pub api: String,
    /// True if it has `VK_EXT_conditional_rendering`.
    pub conditional_rendering: bool,
}

/// The section planes of a walk.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SectionReport {
    /// The part that the planes keep: "intersection" or "union".
    pub mode: String,
    /// Unit normal and offset in metres of each plane: it keeps x*X + y*Y + z*Z + D >= 0.
    pub planes: Vec<[f64; 4]>,
}

impl SectionReport {
    /// Returns the report of these planes; `None` where there are none.
    pub fn of(section: &SectionPlanes) -> Option<Self> {
        let plane = |plane: &SectionPlane| plane.normal().extend(plane.offset_m()).to_array();
        let planes: Vec<[f64; 4]> = section.planes().iter().map(plane).collect();
        let mode = match section.mode() {
            SectionMode::Intersection => "intersection".to_owned(),
            SectionMode::Union => "union".to_owned(),
        };
        (!planes.is_empty()).then_some(Self { mode, planes })
    }
}

/// The scene as built.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SceneReport {
    /// Its name on the command line.
    pub name: String,
    /// The exact number of its objects.
    pub objects: u64,
    /// Triangles of all objects together.
    pub triangles: u64,
    /// The seed it was built from; 0 where it comes out of a file.
    pub seed: u64,
    /// The file that it comes from; absent where it was generated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<FileReport>,
}

/// A file that a scene was loaded from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FileReport {
    /// The path of the file, as it was given.
    pub path: String,
    /// The time of reading it and of making a scene of it.
    pub load_ms: Option<f64>,
    /// Meshes of the scene: each is counted once, for any number of objects that have it.
    pub meshes: u64,
    /// Materials of the meshes.
    pub materials: u64,
    /// Textures of the materials.
    pub textures: u64,
    /// Images of the textures.
    pub images: u64,
    /// Lights beside the ambient one.
    pub lights: u64,
    /// Transparent objects; they are not among the scene's objects.
    pub transparent_objects: u64,
    /// Meshes that are skinned or morphed.
    pub skinned_meshes: u64,
    /// Cameras of the shown scene.
    pub cameras: u64,
    /// Animation clips of the file.
    pub clips: u64,
    /// The number of clips that played.
    pub playing: u64,
    /// The parts of the file that are not shown.
    pub notes: Vec<String>,
}

/// Memory at the end of a walk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MemoryReport {
    /// The largest resident memory of the process.
    pub peak_resident_mib: Option<f64>,
    /// The memory allocated from the device.
    pub gpu_allocated_mib: Option<f64>,
}

/// Times of the preparations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BuildReport {
    /// Generating or loading the objects and their meshes.
    pub scene: Option<f64>,
    /// Building the bounding-volume hierarchy.
    pub hierarchy: Option<f64>,
    /// Uploading everything to the device.
    pub upload: Option<f64>,
}

/// Median and maximum of the age of query results, in frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct AgeReport {
    /// The median; absent where no result was read back.
    pub median: Option<u64>,
    /// The largest age; absent where no result was read back.
    pub max: Option<u64>,
}

/// The corrections of the costs that the cost model learned from frames, as multiples of the costs
/// measured before the walk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CorrectionsReport {
    /// The estimated factor of the cost of draws.
    pub draws: Option<f64>,
    /// The estimated factor of the cost of tests.
    pub tests: Option<f64>,
    /// The factor applied to the costs of tests at the end: `tests` over `draws`, as far as that
    /// was certain.
    pub proportion: Option<f64>,
    /// The number of frames that these estimates are based on; 0 where the device reports no times.
    pub frames: u64,
}

impl From<Corrections> for CorrectionsReport {
    fn from(learned: Corrections) -> Self {
        let factor = |value: f32| value.is_finite().then(|| kept(value.into()));
        Self {
            draws: factor(learned.draws),
            tests: factor(learned.tests),
            proportion: factor(learned.proportion),
            frames: learned.frames,
        }
    }
}

/// One strategy's walk. Counts are medians per frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RunReport {
    /// The name of the strategy.
    pub strategy: String,
    /// The way to make shadows; absent without options about lights, as are the five fields below.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shadows: Option<String>,
    /// The filter of shadow maps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub filter: Option<String>,
    /// The remedy of shadow maps against surfaces that shadow themselves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bias: Option<String>,
    /// Shadow maps that were drawn, wholly or in part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shadow_faces: Option<u64>,
    /// Casters in the shadow maps that were drawn, culled or not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shadow_casters: Option<u64>,
    /// Triangles of casters that were drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shadow_triangles: Option<u64>,
    /// The mean difference of a channel from the same images with the filter `fixed64`, of 255;
    /// absent if that filter was not compared, or no frame was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fixed64_difference_mean: Option<f64>,
    /// The greatest such difference of a channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fixed64_difference_max: Option<u64>,
    /// The time from one submit to the next: in a full pipeline, the time of a frame.
    pub frame_ms: TimeSummary,
    /// The times that `frame_ms` sums up, in the order of the path.
    pub frame_times_ms: Vec<Option<f64>>,
    /// The CPU time of the engine per frame.
    pub cpu_ms: TimeSummary,
    /// Draws submitted, predicated ones included.
    pub draws: Option<u64>,
    /// Triangles submitted, including predicated draws.
    pub triangles: Option<u64>,
    /// Proxies tested, by queries or otherwise.
    pub tests: Option<u64>,
    /// Occlusion queries issued.
    pub queries: Option<u64>,
    /// Draws that a predicate decided.
    pub predicated_draws: Option<u64>,
    /// Nodes of the hierarchy that the culler visited.
    pub nodes_visited: Option<u64>,
    /// Objects drawn because testing them would have cost more than it saved.
    pub untested_by_cost: Option<u64>,
    /// Rounds of tests that `antumbra` gave to a compute shader, as the cheapest tester.
    pub rounds_by_compute: Option<u64>,
    /// The number of frames after which the draw of a stable visible object was tested again; 0
    /// without a cost model.
    pub retest_interval_frames: Option<u64>,
    /// The expected saving of the tests per frame, in nanoseconds of GPU time.
    pub expected_saving_ns: Option<u64>,
    /// The corrections that the cost model had learned at the end; absent without one.
    pub corrections: Option<CorrectionsReport>,
    /// The GPU time of each pass by its label, with `--time-passes`; 0 in frames without the pass.
    pub passes_ms: BTreeMap<String, TimeSummary>,
    /// The age of the results that were read back.
    pub result_age_frames: AgeReport,
    /// Waits for results within a frame.
    pub waits: Option<u64>,
    /// Waits of the frame loop, in all frames together, other than for a frame's own slot.
    pub blocking_waits: u64,
    /// The number of frames in the times and counts.
    pub frames_timed: u64,
    /// The number of them that were compared with plain frustum culling.
    pub frames_verified: u64,
    /// The number of compared warm-up frames; the first of them begins with an empty history.
    pub warm_up_frames_verified: u64,
    /// Pixels that differed in all compared frames; absent where none was compared.
    pub pixels_wrong: Option<u64>,
    /// The most of them that the threshold can explain: the visible samples that were left out. 0
    /// without a threshold; absent where none was compared, or the strategy promises no bound.
    pub pixels_wrong_at_most: Option<u64>,
    /// Visible samples that were left out because of the threshold, in all timed frames.
    pub samples_below_threshold: u64,
    /// The most fragments of transparent objects in a frame; absent where none were sorted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fragments: Option<FragmentsReport>,
}

impl RunReport {
    /// Returns the wrong pixels of a strategy that promises none, if they are more than the
    /// threshold can explain.
    pub fn broken_promise(&self) -> Option<u64> {
        let is_exact = named(&self.strategy).is_some_and(Strategy::is_exact);
        let most = self.pixels_wrong_at_most.unwrap_or(0);
        self.pixels_wrong.filter(|pixels| is_exact && *pixels > most)
    }
}

/// Returns the names of runs: their strategies, and the shadows where these differ.
pub fn labels(runs: &[RunReport]) -> Vec<String> {
    let shadows = |run: &RunReport| (run.shadows.clone(), run.filter.clone());
    let is_one = runs.windows(2).all(|pair| shadows(&pair[0]) == shadows(&pair[1]));
    let label = |run: &RunReport| match shadows(run) {
        (Some(shadows), Some(filter)) if !is_one => {
            format!("{} {shadows} {filter}", run.strategy)
        }
        _ => run.strategy.clone(),
    };
    runs.iter().map(label).collect()
}

/// Returns "A/B" for every ordered pair of runs: median frame time of A over the median of B.
pub fn ratios(runs: &[RunReport]) -> BTreeMap<String, Option<f64>> {
    pairs(runs, |a, b| ratio(a.frame_ms.median, b.frame_ms.median))
}

/// Returns "A/B" for every ordered pair of runs: the median of the ratios frame by frame. Where
/// frames differ much over a path, it says more than the ratio of two medians that stem from
/// different frames.
pub fn paired_ratios(runs: &[RunReport]) -> BTreeMap<String, Option<f64>> {
    pairs(runs, |a, b| paired_ratio(&a.frame_times_ms, &b.frame_times_ms))
}

/// Returns frame times as reports keep them: absent where they are not finite.
pub fn kept_times(times_ms: impl Iterator<Item = f64>) -> Vec<Option<f64>> {
    times_ms.map(|time_ms| time_ms.is_finite().then(|| kept(time_ms))).collect()
}

fn pairs(
    runs: &[RunReport],
    ratio: impl Fn(&RunReport, &RunReport) -> Option<f64>,
) -> BTreeMap<String, Option<f64>> {
    let mut ratios = BTreeMap::new();
    let labels = labels(runs);
    for (a_place, (a, a_label)) in runs.iter().zip(&labels).enumerate() {
        for (b_place, (b, b_label)) in runs.iter().zip(&labels).enumerate() {
            if a_place != b_place {
                let name = format!("{a_label}/{b_label}");
                ratios.insert(name, ratio(a, b));
            }
        }
    }
    ratios
}

impl Report {
    /// Parses a report from JSON.
    ///
    /// # Errors
    /// The first error in it.
    pub fn parse(text: &str) -> Result<Self, String> {
        let report: Self = serde_json::from_str(text).map_err(|error| error.to_string())?;
        if report.scene.name.is_empty() || report.path.is_empty() || report.runs.is_empty() {
            return Err("it has no scene, no path or no runs".to_owned());
        }
        Ok(report)
    }

    /// Returns the run of a strategy.
    pub fn run(&self, strategy: &str) -> Option<&RunReport> {
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

    /// Returns the report as indented JSON with a final line break.
    ///
    /// # Errors
    /// A value that JSON cannot represent, which no report of this program has.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self).map(|json| json + "\n")
    }

    /// Writes the report. After a failure, the file has its old contents or all of the new ones.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), WriteError> {
        let json = self.to_json().map_err(|error| WriteError::new(path, error))?;
        write_file(path, json.as_bytes())
    }
}

#[cfg(test)]
pub(crate) mod tests;
