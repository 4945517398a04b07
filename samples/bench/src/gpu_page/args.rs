//! The command line of `gpu_page`.

use std::path::PathBuf;

use clap::{Parser, value_parser};

use crate::args::DeviceArguments;
use crate::options::FrameSize;

/// Makes the page of a device: its costs, measured now, what its driver is trusted with, and the
/// walks of a folder of reports. `ci/gpu` calls it.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "gpu_page",
    version,
    args_override_self = true,
    after_help = "\
Examples:
  gpu_page --out docs/gpu
      Costs and self-test of the best device, as docs/gpu/NAME.md with a plot.
  gpu_page --device llvmpipe --reports out/gpu/reports --out docs/gpu
      With the walks of ci/gpu.

Exit codes: 0 all was written; 2 the command line is wrong; 1 the machine cannot do it, a file \
cannot be written, or the driver cannot be trusted."
)]
pub struct Arguments {
    /// The device that is measured.
    #[command(flatten)]
    pub device: DeviceArguments,
    /// Folder for the page NAME.md and its plot NAME.svg, NAME being the device's; made if it is
    /// missing
    #[arg(long, value_name = "DIR", default_value = "docs/gpu")]
    pub out: PathBuf,
    /// Folder with reports (*.json) that walkthrough wrote on this device [default: none]
    #[arg(long, value_name = "DIR")]
    pub reports: Option<PathBuf>,
    /// Text file with a line for each walk that this device cannot do [default: none]
    #[arg(long, value_name = "FILE")]
    pub left_out: Option<PathBuf>,
    /// Commit of the code, for the page [default: none]
    #[arg(long, value_name = "HASH")]
    pub commit: Option<String>,
    /// The code has changes that are not in that commit
    #[arg(long, requires = "commit")]
    pub uncommitted: bool,
    /// Size of the image that costs are measured with
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub size: FrameSize,
    /// The most of a thing that are measured together, a power of ten
    #[arg(long, value_name = "N", default_value = "10000")]
    #[arg(value_parser = value_parser!(u32).range(1..=10_000))]
    pub most: u32,
    /// Times that each cost is measured
    #[arg(long, value_name = "N", default_value = "5")]
    #[arg(value_parser = value_parser!(u32).range(1..=1_000))]
    pub rounds: u32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_declaration_is_consistent() {
        Arguments::command().debug_assert();
        assert!(Arguments::try_parse_from(["gpu_page", "--most=0"]).is_err());
        let arguments = Arguments::try_parse_from(["gpu_page", "--size=64x32"]).unwrap();
        assert_eq!((arguments.size.width, arguments.most), (64, 10_000));
    }
}
