//! Walks through a scene without a window, measures strategies against each other, prints a table.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use bench::args::Arguments;
use bench::outputs::Outputs;
use bench::run::{self, Walked};
use bench::run_error::{Blame, RunError};
use bench::signals::Signals;
use bench::terminal::{
    self, Ending,
    output::{say, say_wrote},
    print, style,
};
use bench::{exit_status, progress, self_test_table, strategy, table};

fn main() -> ExitCode {
    terminal::run_program("warn", walk)
}

/// Runs the walk that the arguments describe.
fn walk(arguments: &Arguments) -> Result<Ending, RunError> {
    let mut ending = Ending::default();
    if arguments.list_strategies {
        ending.attempt(print(&strategy::list()));
        return Ok(ending);
    }
    let options = arguments.options()?;
    if arguments.list_devices {
        let text: String = run::list_devices()?.iter().map(|line| format!("{line}\n")).collect();
        ending.attempt(print(&text));
        return Ok(ending);
    }
    if arguments.self_test {
        let (device, found) = run::self_test(&options)?;
        ending.attempt(print(&self_test_table::render(&device, &found)));
        self_test_table::complaint(&found).into_iter().for_each(|complaint| ending.fail(complaint));
        return Ok(ending);
    }
    let _outputs = Outputs::of_walk(&options)?;
    let signals = Signals::watch()?;
    let progress = progress::for_terminal(arguments.quiet);
    let result = run::run(&options, progress.as_ref(), &signals);
    progress.finish();
    ending.interrupted(signals.received());
    let Walked { report, images } = match result {
        Err(error) if error.blame == Blame::Nobody => {
            say("ended before anything was measured");
            return Ok(ending);
        }
        result => result?,
    };
    // The table comes first, so it is shown even if a file cannot be written.
    ending.attempt(print(&table::render(&report, style::width())));
    let mut written = images.written;
    images.failures.into_iter().for_each(|failure| ending.fail(failure));
    if let Some(path) = &options.asked.report
        && ending.attempt(report.write(path)).is_some()
    {
        written.push(path.clone());
    }
    if !arguments.quiet {
        written.iter().for_each(|path| say_wrote(path));
    }
    exit_status::complaint(&report).into_iter().for_each(|complaint| ending.fail(complaint));
    Ok(ending)
}
