//! The options that `city` and `viewer` share: the ways to show any scene.

use std::path::PathBuf;
use std::sync::OnceLock;

use antumbra::gpu::{PresentMode, SampleCount};
use antumbra::import::BrokenParts;
use antumbra::pacing;
use antumbra::render::DriverAssumption;
use antumbra::shadows::{ShadowBias, ShadowFilter};
use bench::args::DeviceArguments;
use bench::choices::{
    CostModelChoice, DeviceChoice, QuirksChoice, ValidationChoice, parse_strategy,
};
use bench::file_args::FileArguments;
use bench::options::{FrameSize, MAX_FRAMES, MAX_FRAMES_IN_FLIGHT, parse_samples};
use bench::shadow_choice::{ShadowChoice, ShadowWay, parse_bias, parse_filter};
use bench::strategy::Strategy;
use bench::transparency::TransparencyChoice;
use clap::{Args, ValueEnum, value_parser};

use super::actions::present_mode;
use super::screen::ScreenOptions;
use crate::hud::HudLevel;

/// The options of showing a scene, as the command line has them.
#[derive(Clone, Debug, Args)]
pub struct ShowArguments {
    /// File of actions before frames: lines such as `60 strategy hzb`
    #[arg(long, value_name = "FILE", help_heading = "Frames")]
    pub script: Option<PathBuf>,
    /// Size of the window, or of the frames, in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", help_heading = "Frames")]
    pub size: FrameSize,
    /// Samples per pixel, 1 or 4: with 4, edges are smooth
    #[arg(long, value_name = "1|4", default_value = "1", help_heading = "Frames")]
    #[arg(value_parser = parse_samples)]
    pub msaa: SampleCount,
    /// Order of transparent objects: by objects, or by the fragments of each pixel, which is exact
    /// where objects pass through each other
    #[arg(long, value_name = "objects|fragments", default_value = "objects")]
    #[arg(help_heading = "Frames")]
    pub transparency: TransparencyChoice,
    /// Strategy that decides about draws; `walkthrough --list-strategies` has the names
    #[arg(long, value_name = "NAME", default_value = "antumbra", help_heading = "Frames")]
    #[arg(value_parser = parse_product)]
    pub strategy: Strategy,
    /// Cost model. measured: costs are measured on the device at the start and corrected by the
    /// times of the frames; tests that cost more than they save are left out. off: everything is
    /// tested
    #[arg(long, alias = "costs", value_name = "MODEL", default_value = "measured")]
    #[arg(help_heading = "Frames")]
    pub cost_model: CostModelChoice,
    /// Number of frames that the CPU may be ahead of the GPU
    #[arg(long, value_name = "1..4", default_value = "2", help_heading = "Frames")]
    #[arg(value_parser = value_parser!(u32).range(1..=i64::from(MAX_FRAMES_IN_FLIGHT)))]
    pub frames_in_flight: u32,
    /// Present mode of the window [default: fifo]
    #[arg(long, value_name = "fifo|fifo_relaxed|mailbox|immediate", help_heading = "Frames")]
    #[arg(value_parser = present_mode, conflicts_with = "headless")]
    pub present_mode: Option<PresentMode>,
    /// Most frames per second in the window [default: the rate of the screen]
    #[arg(long, value_name = "HZ", help_heading = "Frames")]
    #[arg(value_parser = frame_limit, conflicts_with = "headless")]
    pub frame_limit: Option<f64>,
    /// Number of frames after which the program ends [default: 120 without a window, never with
    /// one]
    #[arg(long, value_name = "N", help_heading = "Frames")]
    #[arg(value_parser = value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    pub frames: Option<u32>,
    /// Open no window
    #[arg(long, help_heading = "Frames")]
    pub headless: bool,
    /// Amount of text over the image at the start [default: on in a window]
    #[arg(long, value_name = "LEVEL", help_heading = "Frames")]
    pub hud: Option<HudLevel>,
    /// Way to make shadows: off, maps, volumes; maps_uncached, which are drawn afresh in each
    /// frame; maps_unculled, volumes_unculled, with all casters [default: off; in `shadows` maps]
    #[arg(long, value_name = "WAY", help_heading = "Lights")]
    pub shadows: Option<ShadowWay>,
    /// Filter of shadow maps: single, pcf3, adaptive, pcss, fixed64, pcss64
    #[arg(long, value_name = "NAME", default_value = "adaptive", help_heading = "Lights")]
    #[arg(value_parser = parse_filter)]
    pub filter: ShadowFilter,
    /// Remedy of shadow maps against surfaces that shadow themselves: plane, back_faces, midpoint
    #[arg(long, value_name = "NAME", default_value = "plane", help_heading = "Lights")]
    #[arg(value_parser = parse_bias)]
    pub bias: ShadowBias,
    /// Lens flares of the sun and of lamps, in scenes with an hour [default: off; in `shadows` on]
    #[arg(long, value_name = "off|on", help_heading = "Lights")]
    pub flares: Option<FlareChoice>,
    /// Measure the GPU time of every pass from the start
    #[arg(long, help_heading = "Frames")]
    pub time_passes: bool,

    /// The reading of a file.
    #[command(flatten)]
    pub file: FileArguments,

    /// Quirks of the driver: none, or tested first, and what is found broken is not used
    #[arg(long, alias = "trust", value_name = "HOW", default_value = "none")]
    #[arg(help_heading = "Device")]
    pub quirks: QuirksChoice,
    /// The device that draws.
    #[command(flatten)]
    pub device: DeviceArguments,

    /// Folder for screenshots and recorded paths, and without a window for an image of every
    /// frame; made if it is missing [default: this one, and no images]
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub out: Option<PathBuf>,
    /// File for a trace of CPU and GPU, in a folder that exists, for ui.perfetto.dev or
    /// chrome://tracing
    #[arg(long, value_name = "FILE.json", help_heading = "Output")]
    pub trace: Option<PathBuf>,
    /// Have RenderDoc capture this frame, where its library is loaded
    #[arg(long, value_name = "FRAME", help_heading = "Output")]
    #[arg(value_parser = value_parser!(u32).range(0..=i64::from(MAX_FRAMES)))]
    pub capture: Option<u32>,
}

/// The lens flares of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum FlareChoice {
    /// None.
    #[default]
    Off,
    /// Those of the sun and of lamps.
    On,
}

/// The options of showing a scene. Every value is valid.
#[derive(Clone, Debug, PartialEq)]
pub struct ShowOptions {
    /// The script of actions.
    pub script: Option<PathBuf>,
    /// The size at the start.
    pub size: FrameSize,
    /// Samples per pixel.
    pub samples: SampleCount,
    /// The order of transparent objects.
    pub transparency: TransparencyChoice,
    /// The strategy at the start.
    pub strategy: Strategy,
    /// The cost model.
    pub cost_model: CostModelChoice,
    /// The number of frames in flight at the start.
    pub frames_in_flight: u32,
    /// The present mode at the start.
    pub present_mode: PresentMode,
    /// The most frames per second.
    pub frame_limit_hz: Option<f64>,
    /// The number of frames after which the program ends.
    pub frames: Option<u32>,
    /// True if there is no window.
    pub is_headless: bool,
    /// The amount of text at the start.
    pub hud: HudLevel,
    /// The shadows at the start.
    pub shadows: ShadowChoice,
    /// The lens flares at the start.
    pub flares: FlareChoice,
    /// True if passes are timed at the start.
    pub times_passes: bool,
    /// The treatment of broken parts of files.
    pub broken_parts: BrokenParts,
    /// The number of triangles above which a mesh of a file is cut into pieces; `None` cuts no
    /// mesh.
    pub cut_above_triangles: Option<usize>,
    /// The driver quirks that are tested.
    pub quirks: QuirksChoice,
    /// The assumptions that the self-test found broken, once it has run.
    pub disabled: OnceLock<Vec<DriverAssumption>>,
    /// The device that draws.
    pub device: DeviceChoice,
    /// The checks of the validation layer.
    pub validation: ValidationChoice,
    /// The folder of GLSL sources that is watched.
    pub shaders: Option<PathBuf>,
    /// The folder for written files.
    pub out: Option<PathBuf>,
    /// The file for a trace.
    pub trace: Option<PathBuf>,
    /// The file for an animation of the culling, drawn in place of the frames.
    pub fly_out: Option<PathBuf>,
    /// The frame that RenderDoc captures.
    pub capture: Option<u32>,
}

impl ShowOptions {
    /// Returns the options of showing images.
    pub fn screen(&self) -> ScreenOptions {
        ScreenOptions {
            present_mode: self.present_mode,
            frames_in_flight: self.frames_in_flight,
            frame_limit_hz: self.frame_limit_hz,
        }
    }
}

const HEADLESS_FRAMES: u32 = 120;

impl ShowArguments {
    /// Returns the options with their defaults.
    pub fn options(&self) -> ShowOptions {
        let hud = if self.headless { HudLevel::Off } else { HudLevel::Compact };
        ShowOptions {
            script: self.script.clone(),
            size: self.size,
            samples: self.msaa,
            transparency: self.transparency,
            strategy: self.strategy,
            cost_model: self.cost_model,
            frames_in_flight: self.frames_in_flight,
            present_mode: self.present_mode.unwrap_or(PresentMode::Fifo),
            frame_limit_hz: self.frame_limit,
            frames: self.frames.or(self.headless.then_some(HEADLESS_FRAMES)),
            is_headless: self.headless,
            hud: self.hud.unwrap_or(hud),
            shadows: ShadowChoice {
                way: self.shadows.unwrap_or(ShadowWay::Off),
                filter: self.filter,
                bias: self.bias,
            },
            flares: self.flares.unwrap_or_default(),
            times_passes: self.time_passes || self.trace.is_some(),
            broken_parts: self.file.broken_parts(),
            cut_above_triangles: self.file.cut_above_triangles(),
            quirks: self.quirks,
            disabled: OnceLock::new(),
            device: self.device.choice(),
            validation: self.device.validation,
            shaders: self.device.shaders.clone(),
            out: self.out.clone(),
            trace: self.trace.clone(),
            fly_out: None,
            capture: self.capture,
        }
    }
}

/// Parses the name of a strategy that needs no prior knowledge.
fn parse_product(text: &str) -> Result<Strategy, String> {
    let strategy = parse_strategy(text)?;
    if strategy.needs_still_scene() {
        let reason = "it draws visible sets found in advance, on a known path; see walkthrough";
        return Err(reason.to_owned());
    }
    Ok(strategy)
}

fn frame_limit(text: &str) -> Result<f64, String> {
    let [least, most] = pacing::FRAME_LIMIT_HZ;
    let limit = text.parse().ok().filter(|hz| (least..=most).contains(hz));
    limit.ok_or_else(|| format!("it takes {least} to {most} frames per second"))
}
