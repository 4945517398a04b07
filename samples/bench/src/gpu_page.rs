//! The page of a device: its costs, its self-test and its walks, with the commands to repeat them.

pub mod args;
mod text;
mod walks;

use antumbra::gpu::{Device, DeviceOptions};
use antumbra::render::{self, CostListOptions, RendererOptions};

use self::args::Arguments;
use self::text::{DevicePage, file_stem};
use crate::compare::bar_chart::BarChart;
use crate::compare::input::{read_folder, read_notes};
use crate::compare::picture::picture;
use crate::outputs::{Outputs, write_file};
use crate::provenance::Provenance;
use crate::run::{open_instance, pick_adapter};
use crate::run_error::RunError;
use crate::self_test_table;
use crate::terminal::Ending;
use crate::terminal::output::{say, say_wrote};

/// The width of the plot in pixels.
const PLOT_WIDTH: u32 = 900;

/// Measures, and writes the page and its plot.
///
/// # Errors
/// A folder that takes no files; a device that is missing or fails; reports that cannot be read, or
/// of another device.
pub fn run(arguments: &Arguments) -> Result<Ending, RunError> {
    let _outputs = Outputs::prepare(Some(&arguments.out), None)?;
    let reports = match &arguments.reports {
        Some(folder) => read_folder(folder)?,
        None => Vec::new(),
    };
    let left_out = arguments.left_out.as_deref().map(read_notes).transpose();
    let left_out = left_out?.unwrap_or_default();
    let instance = open_instance(arguments.device.validation, None)?;
    let adapter = pick_adapter(&instance, &arguments.device.choice())?;
    if let Some(other) = reports.iter().find(|report| report.device.name != adapter.name) {
        let file = &other.file;
        let name = &other.device.name;
        return Err(RunError::user(format!(
            "{file} is a report of {name}, not of {}",
            adapter.name
        )));
    }
    let device = Device::new(&instance, &adapter, &DeviceOptions::default())?;
    let size = [arguments.size.width, arguments.size.height];
    RendererOptions { size, ..RendererOptions::default() }.check(&device)?;
    let quirks = render::self_test(&device, &RendererOptions::default())?;
    say("measuring costs");
    let options = CostListOptions {
        size,
        most: arguments.most,
        rounds: arguments.rounds as usize,
        ..CostListOptions::default()
    };
    let costs = render::cost_list(&device, &options)?;
    let stem = file_stem(&adapter.name);
    let page = DevicePage {
        adapter: &adapter,
        provenance: &Provenance::of_this_process(),
        commit: arguments.commit.as_deref(),
        has_changes: arguments.uncommitted,
        quirks: &quirks,
        options,
        device_costs: &costs,
        reports: &reports,
        left_out: &left_out,
        plot: format!("{stem}.svg"),
    };
    let chart = BarChart {
        title: "Time of one, in nanoseconds, where most are measured together".to_owned(),
        bars: page.bars(),
        names_px: 250,
    };
    let plot = picture((PLOT_WIDTH, chart.height()), &chart.title, |area| chart.draw(area))?;
    let mut ending = Ending::default();
    for (extension, text) in [("svg", plot), ("md", page.page().markdown().to_owned())] {
        let file = arguments.out.join(format!("{stem}.{extension}"));
        if ending.attempt(write_file(&file, text.as_bytes())).is_some() {
            say_wrote(&file);
        }
    }
    self_test_table::complaint(&quirks).into_iter().for_each(|complaint| ending.fail(complaint));
    drop(device);
    let messages = instance.validation_log().len();
    if messages > 0 {
        ending.fail(format!("the validation layer had {messages} messages (they are in the log)"));
    }
    Ok(ending)
}
