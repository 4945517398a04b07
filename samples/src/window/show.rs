//! What the command lines of `city` and `viewer` share: how something is shown, whatever it is.

use std::path::PathBuf;

use clap::Args;
use gpu::PresentMode;

use super::actions::present_mode;
use crate::hud::HudLevel;
use bench::args::{named, parse_device, parse_in_range, parse_size, usage};
use bench::choices::{Costs, DeviceChoice, Validation};
use bench::options::{FrameSize, MAX_FRAMES, MAX_FRAMES_IN_FLIGHT, UsageError};
use bench::strategy::Strategy;

/// How something is shown, as it was asked for.
#[derive(Clone, Debug, Args)]
pub struct ShowArguments {
    /// What is to be done before which frame: a file of lines such as `60 strategy pyramid`
    #[arg(long, value_name = "FILE", help_heading = "Frames")]
    pub script: Option<PathBuf>,
    /// Size of the window, or of the frames, in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", help_heading = "Frames")]
    pub size: String,
    /// Who decides what is drawn; `walkthrough --list-strategies` has the names
    #[arg(long, value_name = "NAME", default_value = "antumbra", help_heading = "Frames")]
    pub strategy: String,
    /// What the governor does: leave out tests that cost more than they save, by costs that are measured
    /// at the start and corrected by what frames take; or nothing
    #[arg(
        long,
        value_name = "ignored|measured",
        default_value = "measured",
        help_heading = "Frames"
    )]
    pub costs: String,
    /// How many frames the CPU may be ahead of the GPU
    #[arg(long, value_name = "1..4", default_value = "2", help_heading = "Frames")]
    pub frames_in_flight: String,
    /// How pictures follow each other in the window [default: fifo]
    #[arg(long, value_name = "fifo|fifo_relaxed|mailbox|immediate", help_heading = "Frames")]
    pub present_mode: Option<String>,
    /// At most so many frames a second in the window [default: as the screen goes]
    #[arg(long, value_name = "HZ", help_heading = "Frames")]
    pub frame_limit: Option<String>,
    /// End after so many frames [default: 120 without a window, never with one]
    #[arg(long, value_name = "N", help_heading = "Frames")]
    pub frames: Option<String>,
    /// Open no window
    #[arg(long, help_heading = "Frames")]
    pub headless: bool,
    /// How much text is over the picture at the start: the most important numbers, all that have room,
    /// or none [default: on in a window]
    #[arg(long, value_name = "on|details|off", help_heading = "Frames")]
    pub hud: Option<String>,
    /// Measure the GPU time of every pass from the start
    #[arg(long, help_heading = "Frames")]
    pub time_passes: bool,

    /// The device that draws, by its place in `walkthrough --list-devices` or a part of its name
    /// [default: best]
    #[arg(long, value_name = "INDEX|NAME", help_heading = "Device")]
    pub device: Option<String>,
    /// Load the Vulkan validation layer: core checks (on), or with synchronization (sync)
    #[arg(long, value_name = "off|on|sync", default_value = "off", help_heading = "Device")]
    pub validation: String,
    /// Compile the shaders from this folder, and again whenever they change (needs a build with
    /// `--features shader-compiler`)
    #[arg(long, value_name = "DIR", help_heading = "Device")]
    pub shaders: Option<PathBuf>,

    /// Folder for screenshots and recorded paths, and without a window for a picture of every frame;
    /// made if it is missing [default: this one, and no pictures]
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub out: Option<PathBuf>,
    /// File for a trace of CPU and GPU, for ui.perfetto.dev or chrome://tracing
    #[arg(long, value_name = "FILE.json", help_heading = "Output")]
    pub trace: Option<PathBuf>,
    /// Have RenderDoc capture this frame, where its library is loaded
    #[arg(long, value_name = "FRAME", help_heading = "Output")]
    pub capture: Option<String>,
}

/// How something is shown. Every value is in its range.
#[derive(Clone, Debug, PartialEq)]
pub struct ShowOptions {
    /// What is done by itself.
    pub script: Option<PathBuf>,
    /// Size at the start.
    pub size: FrameSize,
    /// Who decides at the start.
    pub strategy: Strategy,
    /// Whether tests must pay.
    pub costs: Costs,
    /// How many frames are in flight at the start.
    pub frames_in_flight: u32,
    /// How pictures follow each other at the start.
    pub present_mode: PresentMode,
    /// At most so many frames a second.
    pub frame_limit_hz: Option<f64>,
    /// The end, in frames.
    pub frames: Option<u32>,
    /// Whether there is no window.
    pub is_headless: bool,
    /// How much text there is at the start.
    pub hud: HudLevel,
    /// Whether passes are timed at the start.
    pub times_passes: bool,
    /// Which device draws.
    pub device: DeviceChoice,
    /// What the validation layer looks at.
    pub validation: Validation,
    /// Folder of GLSL that is watched.
    pub shaders: Option<PathBuf>,
    /// Folder for what is written.
    pub out: Option<PathBuf>,
    /// File for a trace.
    pub trace: Option<PathBuf>,
    /// The frame that RenderDoc captures.
    pub capture: Option<u32>,
}

const HEADLESS_FRAMES: u32 = 120;

impl ShowArguments {
    /// Checks every argument. Looks at nothing but the arguments: files and devices come later.
    ///
    /// # Errors
    /// The first argument that cannot be.
    pub fn options(&self) -> Result<ShowOptions, UsageError> {
        let strategy = named("--strategy", &self.strategy)?;
        if strategy == Strategy::Ideal {
            return usage(
                "--strategy: 'ideal' draws what was found visible beforehand, on a path that is known; see walkthrough",
            );
        }
        let present_mode = present_mode(self.present_mode.as_deref().unwrap_or("fifo"))
            .map_err(|message| UsageError(format!("--present-mode: {message}")))?;
        self.refuse_unheeded()?;
        let frames = self.frames.as_deref();
        let frames = frames.map(|text| parse_in_range("--frames", text, 1, MAX_FRAMES));
        let frames = frames.transpose()?;
        let capture = self.capture.as_deref();
        let capture = capture.map(|text| parse_in_range("--capture", text, 0, MAX_FRAMES));
        let [least, most] = pacing::FRAME_LIMIT_HZ;
        let limit = self.frame_limit.as_deref();
        let limit = limit.map(|text| match text.parse::<f64>() {
            Ok(hz) if (least..=most).contains(&hz) => Ok(hz),
            _ => usage(format!(
                "--frame-limit takes {least} to {most} frames a second, not '{text}'"
            )),
        });
        Ok(ShowOptions {
            script: self.script.clone(),
            size: parse_size(&self.size)?,
            strategy,
            costs: named("--costs", &self.costs)?,
            frames_in_flight: parse_in_range(
                "--frames-in-flight",
                &self.frames_in_flight,
                1,
                MAX_FRAMES_IN_FLIGHT,
            )?,
            present_mode,
            frame_limit_hz: limit.transpose()?,
            frames: frames.or(self.headless.then_some(HEADLESS_FRAMES)),
            is_headless: self.headless,
            hud: match self.hud.as_deref() {
                None if self.headless => HudLevel::Off,
                None | Some("on") => HudLevel::Compact,
                Some("details") => HudLevel::Detailed,
                Some("off") => HudLevel::Off,
                Some(text) => {
                    return usage(format!("--hud takes on, details or off, not '{text}'"));
                }
            },
            times_passes: self.time_passes || self.trace.is_some(),
            device: parse_device(self.device.as_deref())?,
            validation: named("--validation", &self.validation)?,
            shaders: self.shaders.clone(),
            out: self.out.clone(),
            trace: self.trace.clone(),
            capture: capture.transpose()?,
        })
    }

    /// Refuses what only a window heeds where there is none.
    fn refuse_unheeded(&self) -> Result<(), UsageError> {
        let of_windows =
            [("--present-mode", &self.present_mode), ("--frame-limit", &self.frame_limit)];
        match of_windows.into_iter().find(|(_, value)| self.headless && value.is_some()) {
            Some((option, _)) => usage(format!(
                "{option} changes nothing with --headless: leave it out, or open a window"
            )),
            None => Ok(()),
        }
    }
}
