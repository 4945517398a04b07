//! The command line of `walkthrough`: its declaration, its help, and the checks that make it
//! [`Options`].

mod values;

use std::path::PathBuf;

use antumbra::cull::SectionPlanes;
use antumbra::gpu::SampleCount;
use antumbra::methods;
use clap::{Args, Parser, value_parser};

pub use self::values::SceneArgument;
use self::values::{StrategyList, TopDown};
use crate::choices::{
    CostModelChoice, DeviceChoice, EdgesChoice, GeneratorChoice, PredicatesChoice,
    ProjectionChoice, QuirksChoice, ValidationChoice, Verify, enumerate, parse_path,
};
use crate::file_args::FileArguments;
use crate::light_args::LightArguments;
use crate::options::{
    DEFAULT_IMAGES, FrameSize, LeftOut, MAX_FRAMES, MAX_FRAMES_IN_FLIGHT, MAX_OBJECTS, MAX_VIEWS,
    MadeScene, PathChoice, SceneChoice, UsageError, parse_samples,
};
use crate::section_args::SectionArguments;
use crate::shadow_choice::ShadowChoice;
use crate::strategy::{self, Strategy};
use crate::terminal::shown;
use crate::transparency::TransparencyChoice;

/// The arguments of files that only a walk writes.
const FILES: [&str; 2] = ["out", "report"];

/// Walks a camera through a scene without a window and measures strategies of visibility culling
/// against each other.
///
/// Each strategy draws the same frames with a history of its own. They take turns in short rounds
/// of consecutive frames; the first frames of a round warm it up and do not count. A table at the
/// end shows the times, and the number of pixels that differ from plain frustum culling.
#[derive(Clone, Debug, PartialEq, Parser)]
#[command(
    name = "walkthrough",
    version,
    // The last value of an option counts, so callers of a script can override its options.
    args_override_self = true,
    allow_negative_numbers = true,
    after_help = "\
Examples:
  walkthrough
      Down the streets of a city: plain frustum culling, ours, the ideal.
  walkthrough --path cut --verify every --out images
      Jumps about, compares every frame with frustum culling, leaves images.
  walkthrough --objects 1000000 --frames 10 --report million.json
      A large city: how long it takes to build and how much memory it needs.
  walkthrough --moving-percent 10 --verify every
      Every tenth object moves or comes and goes; each frame is compared.
  walkthrough --scene rooms.glb --path walk
      With the camera \"walk\" of a glTF file, all of whose clips play.
  walkthrough --lights 16 --shadows maps,maps_uncached --filter pcf3,adaptive --verify every
      At night under 16 street lamps: each way to make shadows with each filter.
  walkthrough --list-devices
      Lists the devices that --device can choose from.
  walkthrough --self-test --device NAME
      Asks if its driver can be trusted.

Exit codes: 0 all went well; 2 the command line is wrong; 1 the machine cannot do it, pixels are \
wrong, or a file cannot be written; 129, 130 or 143 a closed terminal, Ctrl-C or SIGTERM cut the \
walk short: the table and the report then have what was measured until then."
)]
pub struct Arguments {
    /// The scene: city (nearly all hidden at street level), field (objects side by side: from above
    /// nothing hides anything), assembly (machines of small parts in halls), waffle (a waffle
    /// maker), or a glTF, STL or OBJ file, whose name has a dot or a slash
    #[arg(
        long,
        value_name = "city|field|assembly|waffle|FILE",
        default_value = "city",
        help_heading = "Scene"
    )]
    pub scene: SceneArgument,
    /// The numbers that city, field and assembly are made from.
    #[command(flatten)]
    pub made: MadeArguments,
    /// The reading of a file.
    #[command(flatten)]
    pub file: FileArguments,
    /// Its lights and their shadows.
    #[command(flatten)]
    pub lighting: LightArguments,
    /// The planes that cut it.
    #[command(flatten)]
    pub section: SectionArguments,
    /// The camera's path: street (eye level), fly (from above), cut (every tenth frame jumps), or a
    /// file that city or viewer recorded (a name with .txt at its end or a slash). In a glTF file:
    /// a camera of that name, whose whole clip is walked once from end to end [default: street; in
    /// a file its first camera, or a turn around the scene if it has none]
    #[arg(long, value_name = "street|fly|cut|CAMERA|FILE", help_heading = "Walk")]
    pub path: Option<String>,
    /// Number of eyes: 1, or 2 for a stereo pair side by side in one frame, half of it each
    #[arg(long, value_name = "1..2", default_value = "1", help_heading = "Walk")]
    #[arg(value_parser = value_parser!(u32).range(1..=i64::from(MAX_VIEWS)))]
    pub views: u32,
    /// Projection of the cameras: perspective; orthographic, with a slice of the scene from the eye
    /// on; or jittered, in perspective and moved within the pixel from frame to frame
    #[arg(long, value_name = "KIND", default_value = "perspective", help_heading = "Walk")]
    pub projection: ProjectionChoice,
    /// Edges of objects, as a drawing shows them: off; visible ones on paper; hidden ones, too, in
    /// dashes; or both over the shaded surfaces
    #[arg(long, value_name = "off|visible|hidden|shaded", default_value = "off")]
    #[arg(help_heading = "Walk")]
    pub edges: EdgesChoice,
    /// Order of transparent objects: by objects, or by the fragments of each pixel, which is exact
    /// where objects pass through each other
    #[arg(
        long,
        value_name = "objects|fragments",
        default_value = "objects",
        help_heading = "Walk"
    )]
    pub transparency: TransparencyChoice,
    /// Share of the objects that move, come and go, 0 to 100, in scenes that are made. In a file
    /// its clips play
    #[arg(long, alias = "moving", value_name = "PERCENT", default_value = "0")]
    #[arg(help_heading = "Walk", value_parser = value_parser!(u32).range(0..=100))]
    pub moving_percent: u32,
    /// Timed frames of each strategy, 1 to 1000000
    #[arg(long, value_name = "N", default_value = "120", help_heading = "Walk")]
    #[arg(value_parser = value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    pub frames: u32,
    /// Size of the frames in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", help_heading = "Walk")]
    pub size: FrameSize,
    /// Samples per pixel, 1 or 4: with 4, edges are smooth
    #[arg(long, value_name = "1|4", default_value = "1", help_heading = "Walk")]
    #[arg(value_parser = parse_samples)]
    pub msaa: SampleCount,

    /// Strategies to compare: names from --list-strategies, or all that can run; `ideal` only where
    /// nothing moves [default: frustum,antumbra,ideal]
    #[arg(long, value_name = "NAME[,NAME]|all", help_heading = "Compare")]
    pub strategy: Option<StrategyList>,
    /// Print a line for each strategy, with its name, exact or not, and a summary; and end
    #[arg(long, help_heading = "Compare", conflicts_with_all = FILES)]
    #[arg(conflicts_with_all = ["list_devices", "self_test"])]
    pub list_strategies: bool,
    /// Compare frames bit for bit with frustum culling: every one, every K-th, or none; those that
    /// warm up too, from an empty history on
    #[arg(long, value_name = "every|K|off", default_value = "off", help_heading = "Compare")]
    pub verify: Verify,
    /// Number of frames that the CPU may be ahead of the GPU
    #[arg(long, value_name = "1..4", default_value = "2", help_heading = "Compare")]
    #[arg(value_parser = value_parser!(u32).range(1..=i64::from(MAX_FRAMES_IN_FLIGHT)))]
    pub frames_in_flight: u32,
    /// Way to skip draws that turn out hidden; auto takes what costs least by measured costs
    #[arg(long, value_name = "WAY", default_value = "auto", help_heading = "Compare")]
    pub predicates: PredicatesChoice,

    /// Largest number of visible pixels that counts as hidden, with antumbra, antumbra_queries and
    /// chc: above 0 they are not exact, and the most pixels that can be wrong are counted
    #[arg(long, value_name = "PIXELS", default_value = "0", help_heading = "Compare")]
    pub threshold: u32,
    /// Cost model. measured: costs are measured on the device before the walk and corrected by the
    /// times of the frames; tests that cost more than they save are left out. off: everything is
    /// tested [default: measured]
    #[arg(long, alias = "costs", value_name = "MODEL", help_heading = "Compare")]
    pub cost_model: Option<CostModelChoice>,

    /// Measure the GPU time of every pass too. It costs time, most of all on a software driver:
    /// leave it off for ratios
    #[arg(long, help_heading = "Compare")]
    pub time_passes: bool,

    /// The device that draws.
    #[command(flatten)]
    pub device: DeviceArguments,
    /// List the Vulkan devices and end
    #[arg(long, help_heading = "Device", conflicts_with_all = FILES)]
    #[arg(conflicts_with = "self_test")]
    pub list_devices: bool,
    /// Test what the driver is trusted with, print a line for each assumption, and end: with exit
    /// code 1 if no tester or no way to skip draws can be trusted
    #[arg(long, help_heading = "Device", conflicts_with_all = FILES)]
    pub self_test: bool,
    /// Quirks of the driver: none, or tested first, and what is found broken is not used
    #[arg(long, alias = "trust", value_name = "HOW", default_value = "none")]
    #[arg(help_heading = "Device")]
    pub quirks: QuirksChoice,

    /// Folder for images; made if it is missing [default: no images]
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub out: Option<PathBuf>,
    /// Number of frames that become images in --out, spread over the walk [default: 4]
    #[arg(long, value_name = "N", requires = "out", help_heading = "Output")]
    pub images: Option<u32>,
    /// The frame that --out also shows from above, with the draws, the hidden boxes and the
    /// frustum; or off [default: the middle one]
    #[arg(long, value_name = "FRAME|off", requires = "out", help_heading = "Output")]
    pub top_down: Option<TopDown>,
    /// Each image also as its depth complexity: how many surfaces are drawn at each pixel, those
    /// behind others included
    #[arg(long, requires = "out", help_heading = "Output")]
    pub depth_complexity: bool,
    /// File for the report as JSON, in a folder that exists [default: none]
    #[arg(long, value_name = "FILE.json", help_heading = "Output")]
    pub report: Option<PathBuf>,
    /// No progress, only the table
    #[arg(long, help_heading = "Output")]
    pub quiet: bool,
}

/// A complete description of a walk: the arguments, checked together, and the values that follow
/// from them. Every value is in its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The arguments.
    pub asked: Arguments,
    /// The scene to walk through: generated, or out of a file.
    pub scene: SceneChoice,
    /// The camera's path.
    pub path: PathChoice,
    /// The triangles above which a mesh of a file is cut into pieces, if one is.
    pub cut_above_triangles: Option<usize>,
    /// The ways to draw shadows, each combined with each strategy. Empty without options about
    /// lights: there are no shadows then.
    pub shadows: Vec<ShadowChoice>,
    /// The strategies to compare: at least one, each once, in the order asked for.
    pub strategies: Vec<Strategy>,
    /// The strategies of `all` that cannot run here.
    pub left_out: Vec<LeftOut>,
    /// The cost model.
    pub cost_model: CostModelChoice,
    /// The planes that cut the scene.
    pub section: SectionPlanes,
    /// The number of frames that become images, spread over the walk; 0 without a folder.
    pub images: u32,
    /// The frame that is also drawn from above, with frontier and frustum; none without a folder.
    pub top_down: Option<u32>,
}

impl Options {
    /// Returns the frames that become images, spread evenly, the first one included.
    pub fn image_frames(&self) -> Vec<u32> {
        let frames = u64::from(self.asked.frames);
        let images = u64::from(self.images);
        (0..images).filter_map(|image| u32::try_from(image * frames / images).ok()).collect()
    }
}

/// The numbers that a scene is made from.
#[derive(Clone, Debug, PartialEq, Eq, Args)]
pub struct MadeArguments {
    /// Approximate number of objects in city, field or assembly, 1 to 33554432 [default: 10000]
    #[arg(long, value_name = "N", help_heading = "Scene")]
    #[arg(value_parser = value_parser!(u32).range(1..=i64::from(MAX_OBJECTS)))]
    pub objects: Option<u32>,
    /// Seed of city, field or assembly: the same one builds the same scene [default: 1]
    #[arg(long, value_name = "S", help_heading = "Scene")]
    pub seed: Option<u64>,
}

impl MadeArguments {
    /// Returns the scene of a kind with these numbers.
    pub fn of(&self, scene: GeneratorChoice) -> MadeScene {
        MadeScene { scene, objects: self.objects.unwrap_or(10_000), seed: self.seed.unwrap_or(1) }
    }
}

/// The device that draws, for all programs.
#[derive(Clone, Debug, PartialEq, Eq, Args)]
pub struct DeviceArguments {
    /// The device that draws, by its place in `walkthrough --list-devices` or a part of its name
    /// [default: best]
    #[arg(long = "device", value_name = "INDEX|NAME", help_heading = "Device")]
    pub choice: Option<DeviceChoice>,
    /// Load the Vulkan validation layer
    #[arg(long, value_name = "MODE", default_value = "off", help_heading = "Device")]
    pub validation: ValidationChoice,
    /// Compile the shaders from this folder instead of using the embedded ones; in a window again
    /// after every change (needs a build with `--features shader-compiler`)
    #[arg(long, value_name = "DIR", help_heading = "Device")]
    pub shaders: Option<PathBuf>,
}

impl DeviceArguments {
    /// Returns the device that is asked for.
    pub fn choice(&self) -> DeviceChoice {
        self.choice.clone().unwrap_or(DeviceChoice::Best)
    }
}

impl Arguments {
    /// Checks the arguments against each other and returns the options of the walk. Files and
    /// devices are not checked here.
    ///
    /// # Errors
    /// The first arguments that contradict each other.
    pub fn options(&self) -> Result<Options, UsageError> {
        let Self { size, views, predicates, threshold, .. } = *self;
        let (scene, path) = self.walk()?;
        if size.width < views {
            return usage(format!(
                "--views {views} needs a column of pixels for each eye: --size {size} is too narrow"
            ));
        }
        let (strategies, left_out) = self.strategies()?;
        if threshold > 0 && predicates == PredicatesChoice::Conditional {
            return usage(format!(
                "--threshold {threshold} and --predicates conditional do not go together: conditional rendering cannot compare; say auto, count, instances or compacted"
            ));
        }
        let cost_model = self.cost_model(&strategies)?;
        if threshold > 0 {
            refuse_unheeded(
                &format!("--threshold {threshold}"),
                &strategies,
                Strategy::has_sample_threshold,
            )?;
        }
        let shadows = self.lighting.choices(&self.scene)?;
        let section = self.section.planes()?;
        // A piece of a solid is not closed and would have no cap, and its border would be drawn as
        // edges of the model.
        let is_whole = section.is_empty() && self.edges == EdgesChoice::Off;
        let cut_above_triangles = self.file.cut_above_triangles().filter(|_| is_whole);
        Ok(Options {
            scene,
            path,
            cut_above_triangles,
            shadows,
            strategies,
            left_out,
            cost_model,
            section,
            images: self.images()?,
            top_down: self.top_down()?,
            asked: self.clone(),
        })
    }

    /// Returns the scene and the camera's path.
    fn walk(&self) -> Result<(SceneChoice, PathChoice), UsageError> {
        let file = match &self.scene {
            SceneArgument::File(file) => file,
            SceneArgument::Made(scene) if self.file.strict => {
                return usage(format!(
                    "--strict is about files, and --scene {scene} is none: leave it out"
                ));
            }
            SceneArgument::Made(scene) => {
                for (option, is_there) in [
                    ("--objects", self.made.objects.is_some()),
                    ("--seed", self.made.seed.is_some()),
                ] {
                    if is_there && !scene.takes_numbers() {
                        return usage(format!(
                            "{option} is not for --scene {scene}, which is always the same: leave \
                             it out"
                        ));
                    }
                }
                let path = self.path.clone().unwrap_or_else(|| scene.default_path().to_string());
                let path = parse_path(&path);
                let path = path.map_err(|message| UsageError(format!("--path: {message}")))?;
                return Ok((SceneChoice::Made(self.made.of(*scene)), path));
            }
        };
        let shown = shown(file);
        for (option, is_there, why) in [
            ("--objects", self.made.objects.is_some(), "the file has its own number of objects"),
            ("--seed", self.made.seed.is_some(), "nothing in a file is random"),
            (
                "--moving-percent",
                self.moving_percent > 0,
                "only its clips move the objects of a file",
            ),
        ] {
            if is_there {
                return usage(format!(
                    "{option} is for scenes that are made, not for --scene {shown}: {why}; leave it out"
                ));
            }
        }
        Ok((SceneChoice::File(file.clone()), PathChoice::OfFile(self.path.clone())))
    }

    /// Returns the strategies, and those that cannot run and were not asked for by name.
    fn strategies(&self) -> Result<(Vec<Strategy>, Vec<LeftOut>), UsageError> {
        const STANDS_STILL: &str =
            "it draws visible sets found in advance, in a scene that stands still";
        let mut strategies = match &self.strategy {
            None => vec![Strategy::FRUSTUM, Strategy::ANTUMBRA, methods::IDEAL],
            Some(StrategyList::All) => strategy::strategies(),
            Some(StrategyList::These(strategies)) => strategies.clone(),
        };
        let mut left_out = Vec::new();
        let is_refused =
            |strategy: &Strategy| self.moving_percent > 0 && strategy.needs_still_scene();
        for refused in strategies.extract_if(.., |strategy| is_refused(strategy)) {
            if matches!(self.strategy, Some(StrategyList::These(_))) {
                return usage(format!(
                    "--strategy {refused} and --moving-percent {} do not go together: {STANDS_STILL}",
                    self.moving_percent
                ));
            }
            let reason = STANDS_STILL.to_owned();
            left_out.push(LeftOut { strategy: refused.name().to_owned(), reason });
        }
        Ok((strategies, left_out))
    }

    fn images(&self) -> Result<u32, UsageError> {
        match self.images {
            _ if self.out.is_none() => Ok(0),
            None => Ok(DEFAULT_IMAGES.min(self.frames)),
            Some(images) => at_most("--images", images, self.frames),
        }
    }

    /// Returns the cost model to use. Costs that none of the strategies uses are not measured;
    /// asking for them explicitly is an error.
    fn cost_model(&self, strategies: &[Strategy]) -> Result<CostModelChoice, UsageError> {
        let Some(cost_model) = self.cost_model else {
            let is_heeded = strategies.iter().any(|strategy| strategy.uses_cost_model());
            return Ok(if is_heeded { CostModelChoice::Measured } else { CostModelChoice::Off });
        };
        if cost_model == CostModelChoice::Measured {
            refuse_unheeded("--cost-model measured", strategies, Strategy::uses_cost_model)?;
        }
        Ok(cost_model)
    }

    fn top_down(&self) -> Result<Option<u32>, UsageError> {
        match self.top_down {
            _ if self.out.is_none() => Ok(None),
            None => Ok(Some(self.frames / 2)),
            Some(TopDown::Off) => Ok(None),
            Some(TopDown::Frame(frame)) => {
                at_most("--top-down", frame, self.frames.saturating_sub(1)).map(Some)
            }
        }
    }
}

/// Returns an error with this message.
///
/// # Errors
/// Always.
pub fn usage<T>(message: impl Into<String>) -> Result<T, UsageError> {
    Err(UsageError(message.into()))
}

fn at_most(option: &str, number: u32, most: u32) -> Result<u32, UsageError> {
    if number <= most {
        Ok(number)
    } else {
        usage(format!("{option} takes a whole number from 0 to {most}, not '{number}'"))
    }
}

/// Refuses an option that none of the strategies uses.
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
    let heeding =
        names(&mut strategy::strategies().into_iter().filter(|strategy| heeds(*strategy)));
    usage(format!(
        "{option} changes nothing for --strategy {asked}: leave it out, or name one that uses it ({heeding})"
    ))
}

#[cfg(test)]
mod tests;
