//! The command line of `budget`.

use clap::{Parser, value_parser};

use crate::Options;
use crate::args::{Arguments, DeviceArguments, MadeArguments, SceneArgument};
use crate::choices::GeneratorChoice;
use crate::options::{FrameSize, MAX_FRAMES, MAX_FRAMES_IN_FLIGHT, UsageError};

/// Measures the time that each part of a frame of `antumbra` adds to the ideal, and prints a table
/// in Markdown.
///
/// A walk is recorded once. Then frames that lack parts of the recorded ones are drawn over it in
/// turns, each with one part more than the one before. The images of every eighth frame are
/// compared with plain frustum culling.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "budget",
    version,
    args_override_self = true,
    after_help = "\
Examples:
  budget --device llvmpipe --frames 24
      Down the streets of a city of 10,000 objects.
  budget --path cut --objects 40000 --rounds 7
      Jumps about in a larger one, measured less often.

Exit codes: 0 all went well; 2 the command line is wrong; 1 the machine cannot do it, or an image \
is wrong."
)]
pub struct BudgetArguments {
    /// The scene: city, field, assembly or waffle
    #[arg(long, value_name = "NAME", default_value = "city")]
    scene: GeneratorChoice,
    /// The numbers that the scene is made from.
    #[command(flatten)]
    made: MadeArguments,
    /// The camera's path: street, fly or cut, or a file that city or viewer recorded
    #[arg(long, value_name = "street|fly|cut|FILE", default_value = "street")]
    path: String,
    /// Frames of the walk
    #[arg(long, value_name = "N", default_value = "24")]
    #[arg(value_parser = value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    frames: u32,
    /// Size of the frames in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    size: FrameSize,
    /// Number of frames that the CPU may be ahead of the GPU
    #[arg(long, value_name = "1..4", default_value = "2")]
    #[arg(value_parser = value_parser!(u32).range(1..=i64::from(MAX_FRAMES_IN_FLIGHT)))]
    frames_in_flight: u32,
    /// Times that each part walks the path
    #[arg(long, value_name = "N", default_value = "15")]
    #[arg(value_parser = value_parser!(u32).range(1..=1_000))]
    pub rounds: u32,
    /// The device that draws.
    #[command(flatten)]
    device: DeviceArguments,
    /// No progress, only the table
    #[arg(long)]
    pub quiet: bool,
}

impl BudgetArguments {
    /// Returns the options of the walk. All other options of a walk have their defaults.
    ///
    /// # Errors
    /// Arguments that contradict each other.
    pub fn options(&self) -> Result<Options, UsageError> {
        let defaults = Arguments::try_parse_from(["walkthrough"]);
        let defaults = defaults.map_err(|error| UsageError(error.to_string()))?;
        let walk = Arguments {
            scene: SceneArgument::Made(self.scene),
            made: self.made.clone(),
            path: Some(self.path.clone()),
            frames: self.frames,
            size: self.size,
            frames_in_flight: self.frames_in_flight,
            device: self.device.clone(),
            ..defaults
        };
        walk.options()
    }
}
