//! The command line of `walkthrough`: its declaration, its help, and the checks that make it
//! [`Options`].

use std::num::NonZeroU32;
use std::path::PathBuf;
use std::str::FromStr;

use clap::Parser;

use crate::Options;
use crate::choices::{
    Costs, DeviceChoice, Named, Predicates, Scene, Verify, enumerate, parse_named,
};
use crate::options::{
    DEFAULT_PICTURES, FrameSize, LeftOut, MAX_FRAMES, MAX_FRAMES_IN_FLIGHT, MAX_OBJECTS, MAX_VIEWS,
    MadeScene, PathChoice, SceneChoice, UsageError,
};
use crate::strategy::Strategy;
use crate::terminal::shown;

/// Walks a camera through a scene without a window and measures strategies of visibility culling
/// against each other.
///
/// Each strategy draws the same frames with a history of its own. They take turns in short rounds
/// of consecutive frames; the first frames of a round warm it up and do not count. A table at the
/// end tells the times, and how many pixels differ from plain frustum culling.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "walkthrough",
    version,
    // The last word counts, so that scripts can have options that their callers change.
    args_override_self = true,
    allow_negative_numbers = true,
    after_help = "\
Examples:
  walkthrough
      Down the streets of a city: plain frustum culling, ours, the ideal.
  walkthrough --path cut --verify every --out pictures
      Jumps about, compares every frame with frustum culling, leaves pictures.
  walkthrough --objects 1000000 --frames 10 --report million.json
      A large city: how long it takes to build and how much memory it needs.
  walkthrough --moving 10 --verify every
      Every tenth object moves or comes and goes; each frame is compared.
  walkthrough --scene rooms.glb --path walk
      With the camera \"walk\" of a glTF file, all of whose clips play.
  walkthrough --list-devices
      What --device can choose from.

Exit codes: 0 all went well; 2 the command line is wrong; 1 the machine cannot do it, pixels are \
wrong, or a file cannot be written; 129, 130 or 143 a closed terminal, Ctrl-C or SIGTERM cut the \
walk short: the table and the report then have what was measured until then."
)]
pub struct Arguments {
    /// What to walk through: city (nearly all hidden at street level), field (objects side by side:
    /// from above nothing hides anything), or a glTF file, whose name has a dot or a slash
    #[arg(long, value_name = "city|field|FILE", default_value = "city", help_heading = "Walk")]
    pub scene: String,
    /// About how many objects city or field has, 1 to 2000000 [default: 10000]
    #[arg(long, value_name = "N", help_heading = "Walk")]
    pub objects: Option<String>,
    /// Seed of city or field: the same one builds the same scene [default: 1]
    #[arg(long, value_name = "S", help_heading = "Walk")]
    pub seed: Option<String>,
    /// How the camera moves: street (eye level), fly (from above), cut (every tenth frame jumps), or
    /// as in a file that city or viewer recorded, whose name ends in .txt or has a slash. In a glTF
    /// file: a camera of that name, whose whole clip is walked once from end to end
    /// [default: street; in a file its first camera, or a turn around the scene if it has none]
    #[arg(long, value_name = "street|fly|cut|CAMERA|FILE", help_heading = "Walk")]
    pub path: Option<String>,
    /// How many eyes look: 1, or 2 for a stereo pair side by side in one frame, half of it each
    #[arg(long, value_name = "1..2", default_value = "1", help_heading = "Walk")]
    pub views: String,
    /// How many objects of a hundred of city or field move, come and go, 0 to 100. In a file its clips
    /// play
    #[arg(long, value_name = "PERCENT", default_value = "0", help_heading = "Walk")]
    pub moving: String,
    /// Timed frames of each strategy, 1 to 1000000
    #[arg(long, value_name = "N", default_value = "120", help_heading = "Walk")]
    pub frames: String,
    /// Size of the frames in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", help_heading = "Walk")]
    pub size: String,

    /// What to compare: names from --list-strategies, or all that can be; `ideal` only where nothing
    /// moves [default: frustum,antumbra,ideal]
    #[arg(long, value_name = "NAME[,NAME]|all", help_heading = "Compare")]
    pub strategy: Option<String>,
    /// Print a line for each strategy: its name, whether it is exact, what it does; and end
    #[arg(long, help_heading = "Compare")]
    pub list_strategies: bool,
    /// Compare frames bit for bit with frustum culling: every one, every K-th, or none; those that warm
    /// up too, from an empty history on
    #[arg(long, value_name = "every|K|off", default_value = "off", help_heading = "Compare")]
    pub verify: String,
    /// How many frames the CPU may be ahead of the GPU
    #[arg(long, value_name = "1..4", default_value = "2", help_heading = "Compare")]
    pub frames_in_flight: String,
    /// How draws that turn out hidden are skipped; auto takes what the device does best
    #[arg(
        long,
        value_name = "auto|conditional|count|instances",
        default_value = "auto",
        help_heading = "Compare"
    )]
    pub predicates: String,

    /// What shows at most so many pixels counts as hidden, with antumbra, antumbra_queries and coherent:
    /// above 0 they are not exact, and the most pixels that can be wrong are counted
    #[arg(long, value_name = "PIXELS", default_value = "0", help_heading = "Compare")]
    pub threshold: String,
    /// What the governor does: leave out tests that cost more than they save, by costs that are measured
    /// on the device before the walk and corrected by what frames take; or nothing [default: measured]
    #[arg(long, value_name = "ignored|measured", help_heading = "Compare")]
    pub costs: Option<String>,

    /// Measure the GPU time of every pass too. It costs time, most of all on a software driver:
    /// leave it off for ratios
    #[arg(long, help_heading = "Compare")]
    pub time_passes: bool,

    /// The device that draws, by its place in --list-devices or a part of its name [default: best]
    #[arg(long, value_name = "INDEX|NAME", help_heading = "Device")]
    pub device: Option<String>,
    /// List the Vulkan devices and end
    #[arg(long, help_heading = "Device")]
    pub list_devices: bool,
    /// Load the Vulkan validation layer: core checks (on), or with synchronization (sync)
    #[arg(long, value_name = "off|on|sync", default_value = "off", help_heading = "Device")]
    pub validation: String,
    /// Compile the shaders from this folder instead of using the embedded ones (needs a build with
    /// `--features shader-compiler`)
    #[arg(long, value_name = "DIR", help_heading = "Device")]
    pub shaders: Option<PathBuf>,

    /// Folder for pictures; made if it is missing [default: no pictures]
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub out: Option<PathBuf>,
    /// How many frames become pictures in --out, spread over the walk [default: 4]
    #[arg(long, value_name = "N", help_heading = "Output")]
    pub pictures: Option<String>,
    /// The frame that --out also shows from above: what is drawn, what is hidden, the frustum; or off
    /// [default: the middle one]
    #[arg(long, value_name = "FRAME|off", help_heading = "Output")]
    pub birds_eye: Option<String>,
    /// File for the report as JSON [default: none]
    #[arg(long, value_name = "FILE.json", help_heading = "Output")]
    pub report: Option<PathBuf>,
    /// No progress, only the table
    #[arg(long, help_heading = "Output")]
    pub quiet: bool,
}

impl Arguments {
    /// Checks every argument. Looks at nothing but the arguments: files and devices come later.
    ///
    /// # Errors
    /// The first argument that cannot be.
    pub fn options(&self) -> Result<Options, UsageError> {
        let (scene, path) = self.parse_walk()?;
        let frames = parse_in_range("--frames", &self.frames, 1, MAX_FRAMES)?;
        let size = parse_size(&self.size)?;
        let views = parse_in_range("--views", &self.views, 1, MAX_VIEWS)?;
        if size.width < views {
            return usage(format!(
                "--views {views} needs a column of pixels for each eye: --size {size} is too narrow"
            ));
        }
        let moving_percent = parse_in_range("--moving", &self.moving, 0, 100)?;
        let (strategies, left_out) = self.parse_strategies(moving_percent)?;
        let predicates = named("--predicates", &self.predicates)?;
        let threshold_pixels = parse_in_range("--threshold", &self.threshold, 0, u32::MAX)?;
        if threshold_pixels > 0 && predicates == Predicates::Conditional {
            return usage(format!(
                "--threshold {threshold_pixels} and --predicates conditional do not go together: conditional rendering cannot compare; say auto, count or instances"
            ));
        }
        let costs = self.parse_costs(&strategies)?;
        if threshold_pixels > 0 {
            let option = format!("--threshold {threshold_pixels}");
            refuse_unheeded(&option, &strategies, Strategy::can_neglect)?;
        }
        Ok(Options {
            scene,
            path,
            moving_percent,
            frames,
            views,
            size,
            strategies,
            left_out,
            verify: parse_verify(&self.verify)?,
            frames_in_flight: parse_in_range(
                "--frames-in-flight",
                &self.frames_in_flight,
                1,
                MAX_FRAMES_IN_FLIGHT,
            )?,
            costs,
            time_passes: self.time_passes,
            device: parse_device(self.device.as_deref())?,
            validation: named("--validation", &self.validation)?,
            predicates,
            threshold_pixels,
            shaders: self.shaders.clone(),
            output: self.out.clone(),
            report: self.report.clone(),
            pictures: self.parse_pictures(frames)?,
            birds_eye: self.parse_birds_eye(frames)?,
        })
    }

    /// What is walked through, and on which way.
    fn parse_walk(&self) -> Result<(SceneChoice, PathChoice), UsageError> {
        let Some(file) = scene_file(&self.scene) else {
            let scene = parse_scene(&self.scene)?;
            let made = parse_made(scene, self.objects.as_deref(), self.seed.as_deref())?;
            let path = parse_path(self.path.as_deref().unwrap_or("street"))?;
            return Ok((SceneChoice::Made(made), path));
        };
        let shown = shown(&file);
        let is_moving = self.moving != "0";
        for (option, is_there, why) in [
            ("--objects", self.objects.is_some(), "the file has those that it has"),
            ("--seed", self.seed.is_some(), "nothing in a file is left to chance"),
            ("--moving", is_moving, "what moves in a file is what its clips move"),
        ] {
            if is_there {
                return usage(format!(
                    "{option} is for city and field, not for --scene {shown}: {why}; leave it out"
                ));
            }
        }
        Ok((SceneChoice::File(file), PathChoice::OfFile(self.path.clone())))
    }

    /// The strategies, and those that were not asked for by name and cannot be.
    fn parse_strategies(
        &self,
        moving_percent: u32,
    ) -> Result<(Vec<Strategy>, Vec<LeftOut>), UsageError> {
        const STANDS_STILL: &str =
            "it draws what was found visible beforehand, in a scene that stands still";
        let mut strategies = match self.strategy.as_deref() {
            None => vec![Strategy::Frustum, Strategy::Antumbra, Strategy::Ideal],
            Some("all") => Strategy::ALL.to_vec(),
            Some(text) => parse_strategies(text)?,
        };
        let mut left_out = Vec::new();
        let is_refused = |strategy: &Strategy| moving_percent > 0 && strategy.needs_still_scene();
        for refused in strategies.extract_if(.., |strategy| is_refused(strategy)) {
            if self.strategy.as_deref().is_some_and(|text| text != "all") {
                return usage(format!(
                    "--strategy {refused} and --moving {moving_percent} do not go together: {STANDS_STILL}"
                ));
            }
            let reason = STANDS_STILL.to_owned();
            left_out.push(LeftOut { strategy: refused.name().to_owned(), reason });
        }
        Ok((strategies, left_out))
    }

    fn parse_pictures(&self, frames: u32) -> Result<u32, UsageError> {
        match (&self.out, &self.pictures) {
            (None, None) => Ok(0),
            (None, Some(_)) => usage("--pictures needs a folder: say --out DIR"),
            (Some(_), None) => Ok(DEFAULT_PICTURES.min(frames)),
            (Some(_), Some(text)) => parse_in_range("--pictures", text, 0, frames),
        }
    }

    /// Nobody measures what none of the strategies heeds, unless he is told to: then he says so.
    fn parse_costs(&self, strategies: &[Strategy]) -> Result<Costs, UsageError> {
        let Some(costs) = &self.costs else {
            let is_heeded = strategies.iter().any(|strategy| strategy.is_governed());
            return Ok(if is_heeded { Costs::Measured } else { Costs::Ignored });
        };
        let costs = named("--costs", costs)?;
        if costs == Costs::Measured {
            refuse_unheeded("--costs measured", strategies, Strategy::is_governed)?;
        }
        Ok(costs)
    }

    fn parse_birds_eye(&self, frames: u32) -> Result<Option<u32>, UsageError> {
        match (&self.out, &self.birds_eye) {
            (None, None) => Ok(None),
            (None, Some(_)) => usage("--birds-eye needs a folder: say --out DIR"),
            (Some(_), None) => Ok(Some(frames / 2)),
            (Some(_), Some(text)) if text == "off" => Ok(None),
            (Some(_), Some(text)) => {
                parse_in_range("--birds-eye", text, 0, frames.saturating_sub(1)).map(Some)
            }
        }
    }
}

/// Refuses with a sentence.
///
/// # Errors
/// Always.
pub fn usage<T>(message: impl Into<String>) -> Result<T, UsageError> {
    Err(UsageError(message.into()))
}

/// Refuses an option that none of the strategies heeds.
fn refuse_unheeded(
    option: &str,
    strategies: &[Strategy],
    heeds: fn(Strategy) -> bool,
) -> Result<(), UsageError> {
    if strategies.iter().any(|strategy| heeds(*strategy)) {
        return Ok(());
    }
    let names = |strategies: &mut dyn Iterator<Item = Strategy>| {
        enumerate(&strategies.map(Strategy::name).collect::<Vec<_>>())
    };
    let asked = names(&mut strategies.iter().copied());
    let heeding = names(&mut Strategy::ALL.into_iter().filter(|strategy| heeds(*strategy)));
    usage(format!(
        "{option} changes nothing for --strategy {asked}: leave it out, or name one that heeds it ({heeding})"
    ))
}

/// Finds a value by its name.
///
/// # Errors
/// A name that none has.
pub fn named<T: Named>(option: &str, text: &str) -> Result<T, UsageError> {
    parse_named(text).map_err(|message| UsageError(format!("{option}: {message}")))
}

/// Reads a whole number.
///
/// # Errors
/// What is none, or out of the range.
pub fn parse_in_range<T>(option: &str, text: &str, least: T, most: T) -> Result<T, UsageError>
where
    T: FromStr + PartialOrd + std::fmt::Display,
{
    match text.parse::<T>() {
        Ok(number) if number >= least && number <= most => Ok(number),
        _ => usage(format!("{option} takes a whole number from {least} to {most}, not '{text}'")),
    }
}

/// The file that a scene is in: what has a dot or a slash is no name of ours.
fn scene_file(text: &str) -> Option<PathBuf> {
    text.contains(['.', '/', std::path::MAIN_SEPARATOR]).then(|| PathBuf::from(text))
}

/// Reads the name of a scene that is made.
///
/// # Errors
/// A name that none has.
pub fn parse_scene(text: &str) -> Result<Scene, UsageError> {
    named("--scene", text).map_err(|UsageError(message)| {
        UsageError(format!("{message} (a glTF file has a dot or a slash in its name)"))
    })
}

/// Reads the numbers that a scene is made from.
///
/// # Errors
/// What is none, or out of its range.
pub fn parse_made(
    scene: Scene,
    objects: Option<&str>,
    seed: Option<&str>,
) -> Result<MadeScene, UsageError> {
    let objects = parse_in_range("--objects", objects.unwrap_or("10000"), 1, MAX_OBJECTS)?;
    let seed = parse_in_range("--seed", seed.unwrap_or("1"), 0, u64::MAX)?;
    Ok(MadeScene { scene, objects, seed })
}

/// The path file that is meant, if one is: its name ends in .txt, or has a slash.
pub fn path_file(text: &str) -> Option<PathBuf> {
    let is_file = text.ends_with(".txt") || text.contains(['/', std::path::MAIN_SEPARATOR]);
    is_file.then(|| PathBuf::from(text))
}

/// Reads a path of a made scene, or the name of a recorded one.
///
/// # Errors
/// What is neither.
pub fn parse_path(text: &str) -> Result<PathChoice, UsageError> {
    if let Some(file) = path_file(text) {
        return Ok(PathChoice::Recorded(file));
    }
    named("--path", text).map(PathChoice::Made).map_err(|UsageError(message)| {
        UsageError(format!(
            "{message}; a file ends in .txt, or has a slash in its name (cameras have names in glTF files only)"
        ))
    })
}

/// Reads a size such as 1280x720.
///
/// # Errors
/// What is none.
pub fn parse_size(text: &str) -> Result<FrameSize, UsageError> {
    let side = |text: &str| text.parse::<u32>().ok().filter(|&side| side > 0);
    let sides = text.split_once(['x', 'X']).map(|(width, height)| (side(width), side(height)));
    match sides {
        Some((Some(width), Some(height))) => Ok(FrameSize { width, height }),
        _ => usage(format!(
            "--size takes two whole numbers of pixels above 0, such as 1280x720, not '{text}'"
        )),
    }
}

fn parse_strategies(text: &str) -> Result<Vec<Strategy>, UsageError> {
    let mut strategies = Vec::new();
    for name in text.split(',') {
        let strategy: Strategy = named("--strategy", name.trim())?;
        if strategies.contains(&strategy) {
            return usage(format!("--strategy names '{}' twice: name each once", strategy.name()));
        }
        strategies.push(strategy);
    }
    Ok(strategies)
}

fn parse_verify(text: &str) -> Result<Verify, UsageError> {
    match text {
        "off" => Ok(Verify::Off),
        "every" => Ok(Verify::EveryNth(NonZeroU32::MIN)),
        _ => match text.parse::<NonZeroU32>() {
            Ok(interval) => Ok(Verify::EveryNth(interval)),
            Err(_) => usage(format!(
                "--verify takes 'every', 'off' or a whole number K above 0 (every K-th frame), not '{text}'"
            )),
        },
    }
}

/// Reads a place in the list of devices, or a part of a name.
///
/// # Errors
/// Nothing but blanks.
pub fn parse_device(text: Option<&str>) -> Result<DeviceChoice, UsageError> {
    match text.map(str::trim) {
        None => Ok(DeviceChoice::Best),
        Some("") => {
            usage("--device takes a place in --list-devices or a part of a name, not nothing")
        }
        Some(text) => Ok(match text.parse() {
            Ok(index) => DeviceChoice::Index(index),
            Err(_) => DeviceChoice::Name(text.to_owned()),
        }),
    }
}

#[cfg(test)]
mod tests;
