//! The command line of `workshop`.

use std::path::PathBuf;

use antumbra::gpu::SampleCount;
use antumbra::render::TransparencyOptions;
use bench::choices::{DeviceChoice, ValidationChoice};
use bench::options::{FrameSize, UsageError, parse_samples};
use bench::transparency::TransparencyChoice;
use clap::{Parser, value_parser};

use crate::viewport::ViewportOptions;

/// Shows a CAD model: its parts are picked, hidden, taken apart, measured and exported. The lid of
/// the waffle maker is dragged until it touches something.
///
/// In a window by hand, with a page of its keys (F1); without one by a script, a command per line.
/// The report has the outcomes.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "workshop",
    version,
    args_override_self = true,
    after_help = "\
Commands of a script, one per line:
  pick X Y                the part under a pixel, from the upper left
  select NAME, deselect   a part or a group
  hide, show, ghost, isolate   what is selected, or (but isolate) a NAME; show alone shows all
  lid DEGREES             drags the lid until it touches; 0 is closed
  explode MM, assemble    parts at least so far apart, and back
  distance X Y X Y        between the points under two pixels
  edge X Y                the length of the model's edge near the point under a pixel
  section X,Y,Z,D[;...], section union ..., section off   what planes keep; in metres
  whole, cut              leaves what is selected, or a NAME, whole; cuts it again
  edges off|visible|hidden|shaded|shaded-hidden
  depth-complexity on|off how many surfaces are drawn at each pixel
  tessellate PIXELS       curved parts anew, of triangles as large as that in the image
  view front, top-left, ..., iso; projection perspective|orthographic; fit
  play FRAMES             the model's camera path
  image FILE.png, export FILE.glb

Exit codes: 0 all was done; 2 the command line or the script is wrong; 1 a command was refused, the \
machine cannot do it, or a file cannot be written."
)]
pub struct WorkshopArguments {
    /// The model: waffle, assembly, or a file, whose name has a dot or a slash
    #[arg(value_name = "waffle|assembly|FILE", default_value = "waffle")]
    pub model: String,
    /// Number of parts of the assembly [default: 1000]
    #[arg(long, value_name = "N")]
    #[arg(value_parser = value_parser!(u32).range(1..=i64::from(scenes::MAX_OBJECTS)))]
    pub parts: Option<u32>,
    /// The number that the assembly is made from [default: 1]
    #[arg(long, value_name = "SEED")]
    pub seed: Option<u64>,
    /// The script to carry out, without a window
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Write what each command did, as JSON
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Open no window: a script is carried out
    #[arg(long, requires = "script")]
    pub headless: bool,
    /// Size of the image in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub size: FrameSize,
    /// Samples per pixel, 1 or 4: with 4, edges are smooth
    #[arg(long, value_name = "1|4", default_value = "1")]
    #[arg(value_parser = parse_samples)]
    pub msaa: SampleCount,
    /// Order of transparent parts: by parts, or by the fragments of each pixel, which is exact
    /// where parts pass through each other
    #[arg(long, value_name = "objects|fragments", default_value = "objects")]
    pub transparency: TransparencyChoice,
    /// Room for the fragments of transparent parts, as many per pixel of the image on average, 1
    /// to 64 [default: 4]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=64))]
    pub fragments_per_pixel: Option<u32>,
    /// Vulkan device: a part of its name, or its number
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<DeviceChoice>,
    /// Validation layers: off, on (core checks), or sync (synchronization, too)
    #[arg(long, value_name = "off|on|sync", default_value = "off")]
    pub validation: ValidationChoice,
}

impl WorkshopArguments {
    /// Checks that no option is about something that is not shown.
    ///
    /// # Errors
    /// The option, and what it is about.
    pub fn check(&self) -> Result<(), UsageError> {
        let is_assembly = self.model == "assembly";
        let is_sorted = self.transparency == TransparencyChoice::Fragments;
        let idle = [
            ("--parts", self.parts.is_some() && !is_assembly, "the model assembly"),
            ("--seed", self.seed.is_some() && !is_assembly, "the model assembly"),
            (
                "--fragments-per-pixel",
                self.fragments_per_pixel.is_some() && !is_sorted,
                "--transparency fragments",
            ),
        ];
        match idle.iter().find(|(_, is_idle, _)| *is_idle) {
            Some((option, _, about)) => Err(UsageError(format!(
                "{option} is about {about} alone: leave the option out, or ask for that"
            ))),
            None => Ok(()),
        }
    }

    /// Returns the options of a viewport with images of this size.
    pub fn viewport_options(&self, size: FrameSize) -> ViewportOptions {
        let options = self.transparency.options();
        let fragments_per_pixel = self.fragments_per_pixel.unwrap_or(options.fragments_per_pixel);
        let transparency = TransparencyOptions { fragments_per_pixel, ..options };
        ViewportOptions { size, samples: self.msaa, transparency, keeps_scene: false }
    }
}
