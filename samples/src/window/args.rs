//! The command line of `city`, and the checks that make it [`CityOptions`].

use std::path::PathBuf;

use clap::Parser;
use gpu::PresentMode;

use super::deeds::present_mode;
use crate::args::{
    named, parse_device, parse_in_range, parse_path, parse_scene, parse_size, usage,
};
use crate::choices::{Costs, DeviceChoice, Scene, Validation};
use crate::options::{
    FrameSize, MAX_FRAMES, MAX_FRAMES_IN_FLIGHT, MAX_OBJECTS, PathChoice, UsageError,
};
use crate::strategy::Strategy;

/// Flies through a city in a window, and shows what the engine thinks.
///
/// The keys are listed on the screen. The same program runs without a window: --headless.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "city",
    version,
    allow_negative_numbers = true,
    args_override_self = true,
    after_help = "\
Examples:
  city
      Fly: W A S D, Q and E, look with a mouse button held.
  city --path street --strategy frustum
      Walks down the streets until you take over.
  city --headless --frames 60 --path street --out pictures
      The same frames as pictures, without a window.
  city --path my-path.txt --trace trace.json
      A path recorded with the key R, and a trace for ui.perfetto.dev.

Ends with 0 when all went well, 2 when something in the command line is wrong, 1 when the machine
cannot do it or a file cannot be written, 130 or 143 when Ctrl-C or SIGTERM ended it: that writes what
there is, and a second one ends it at once."
)]
pub struct CityArguments {
    /// What to fly through: city or field
    #[arg(long, value_name = "city|field", default_value = "city", help_heading = "World")]
    pub scene: String,
    /// About how many objects the scene has, 1 to 2000000
    #[arg(long, value_name = "N", default_value = "10000", help_heading = "World")]
    pub objects: String,
    /// Seed of the scene: the same one builds the same scene
    #[arg(long, value_name = "S", default_value = "1", help_heading = "World")]
    pub seed: String,
    /// The camera goes along a path, until you take over: street, fly, cut, or a file that was
    /// recorded, whose name ends in .txt or has a slash [default: it stands where street begins]
    #[arg(
        long,
        visible_alias = "replay",
        value_name = "street|fly|cut|FILE",
        help_heading = "World"
    )]
    pub path: Option<String>,
    /// What is to be done before which frame: a file of lines such as `60 strategy pyramid`
    #[arg(long, value_name = "FILE", help_heading = "World")]
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
    /// Whether there is text over the picture at the start [default: on in a window]
    #[arg(long, value_name = "on|off", help_heading = "Frames")]
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

/// A flight, fully described. Every value is in its range.
#[derive(Clone, Debug, PartialEq)]
pub struct CityOptions {
    /// What is flown through.
    pub scene: Scene,
    /// About how many objects it has.
    pub objects: u32,
    /// The same seed builds the same scene.
    pub seed: u64,
    /// Where the camera goes by itself.
    pub path: Option<PathChoice>,
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
    /// Whether there is text at the start.
    pub has_hud: bool,
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

impl CityArguments {
    /// Checks every argument. Looks at nothing but the arguments: files and devices come later.
    ///
    /// # Errors
    /// The first argument that cannot be.
    pub fn options(&self) -> Result<CityOptions, UsageError> {
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
        Ok(CityOptions {
            scene: parse_scene(&self.scene)?,
            objects: parse_in_range("--objects", &self.objects, 1, MAX_OBJECTS)?,
            seed: parse_in_range("--seed", &self.seed, 0, u64::MAX)?,
            path: self.path.as_deref().map(parse_path).transpose()?,
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
            has_hud: match self.hud.as_deref() {
                None => !self.headless,
                Some("on") => true,
                Some("off") => false,
                Some(text) => return usage(format!("--hud takes on or off, not '{text}'")),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choices::CameraPath;

    fn parse(line: &[&str]) -> Result<CityOptions, UsageError> {
        CityArguments::try_parse_from([&["city"], line].concat()).unwrap().options()
    }

    #[test]
    fn nothing_said_opens_a_window() {
        let options = parse(&[]).unwrap();
        assert_eq!((options.is_headless, options.has_hud, options.frames), (false, true, None));
        assert_eq!((options.strategy, options.path), (Strategy::Antumbra, None));
        let options = parse(&["--headless"]).unwrap();
        assert_eq!((options.has_hud, options.frames), (false, Some(HEADLESS_FRAMES)));
    }

    #[test]
    fn paths_are_named_or_files() {
        let street = PathChoice::Made(CameraPath::Street);
        assert_eq!(parse(&["--path", "street"]).unwrap().path, Some(street));
        for file in ["path.txt", "./path", "/a/b"] {
            let path = parse(&["--replay", file]).unwrap().path;
            assert_eq!(path, Some(PathChoice::Recorded(PathBuf::from(file))));
        }
    }

    #[test]
    fn of_an_option_said_twice_the_last_counts() {
        let options = parse(&["--frames=1", "--headless", "--frames", "2", "--headless"]).unwrap();
        assert_eq!((options.frames, options.is_headless), (Some(2), true));
    }

    #[test]
    fn what_only_a_window_heeds_is_refused_without_one() {
        for option in [["--present-mode", "fifo"], ["--frame-limit", "60"]] {
            assert!(parse(&option).is_ok());
            let refused = parse(&[&option[..], &["--headless"]].concat()).unwrap_err().to_string();
            let expected = format!("{} changes nothing with --headless", option[0]);
            assert!(refused.starts_with(&expected), "{refused}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for (line, reason) in [
            (["--strategy", "ideal"], "see walkthrough"),
            (["--strategy", "antumbar"], "did you mean 'antumbra'?"),
            (["--present-mode", "vsync"], "fifo_relaxed, mailbox"),
            (["--frame-limit", "0"], "0.1 to 10000"),
            (["--frame-limit", "NaN"], "not 'NaN'"),
            (["--hud", "maybe"], "on or off"),
            (["--costs", "ignore"], "did you mean 'ignored'?"),
            (["--path", "stret"], "did you mean 'street'?"),
            (["--frames", "0"], "from 1 to"),
            (["--capture", "-1"], "not '-1'"),
            (["--size", "1x0"], "1280x720"),
        ] {
            let refused = parse(&line).unwrap_err().to_string();
            assert!(refused.contains(reason), "{line:?}: {refused}");
        }
    }
}
