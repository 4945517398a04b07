//! Every Vulkan call fails: runs small programs again and again, each time with another fault, and
//! checks that nothing is lost (`docs/book/src/faults.md`).
//!
//! The runs happen in child processes, which this program watches: a crash or a hang of a child is
//! a failure of its run. Without arguments, as in the test suite, it takes a sample.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]
#![allow(unsafe_code, reason = "a host calls Vulkan itself")]

mod child;
mod coverage;
mod losses;
mod parent;
mod plans;
mod programs;
mod table;
mod worker;

use clap::Parser;
use programs::ProgramKind;
use tests::Driver;

/// Counts the memory of this program, without that of drivers.
#[global_allocator]
static ALLOCATED: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, usize::MAX);

/// Injects faults into every Vulkan call of small programs.
#[derive(Parser, Clone, Debug)]
struct Arguments {
    /// The number of runs with one fault on lavapipe, over all programs. SwiftShader gets a fifth.
    #[arg(long, default_value_t = 300)]
    runs: usize,
    /// The number of runs with two faults, the second during the clean-up after the first.
    #[arg(long, default_value_t = 100)]
    pairs: usize,
    /// The seed of the choice of runs.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The driver; both if there is none.
    #[arg(long, value_enum)]
    driver: Option<DriverName>,
    /// The program; all if there is none.
    #[arg(long, value_enum)]
    program: Option<ProgramKind>,
    /// A run with this fault, as a failed run is reported. There may be several.
    #[arg(long)]
    fault: Vec<String>,
    /// The number of runs with each fault, all in one process.
    #[arg(long, default_value_t = 1)]
    times: usize,
    /// Lists the codes that every function of the programs may return, and fails if one was not
    /// injected.
    #[arg(long)]
    coverage: bool,
    /// Loses this number of devices in one process, goes on after each, and prints the growth of
    /// its memory, in place of everything else.
    #[arg(long)]
    losses: Option<usize>,
    /// As other test programs have it: runs nothing if it is not a part of the word `faults`.
    #[arg(hide = true)]
    filter: Option<String>,
    /// Executes the runs that are written to the standard input.
    #[arg(long, hide = true)]
    child: bool,
}

#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum DriverName {
    Lavapipe,
    Swiftshader,
}

impl From<DriverName> for Driver {
    fn from(name: DriverName) -> Driver {
        match name {
            DriverName::Lavapipe => Driver::Lavapipe,
            DriverName::Swiftshader => Driver::SwiftShader,
        }
    }
}

fn main() -> std::process::ExitCode {
    let arguments = Arguments::parse();
    if arguments.filter.as_deref().is_some_and(|filter| !"faults".contains(filter)) {
        return std::process::ExitCode::SUCCESS;
    }
    if arguments.child {
        let program = arguments.program.expect("a program");
        let driver = arguments.driver.expect("a driver");
        child::run(program, driver.into());
        return std::process::ExitCode::SUCCESS;
    }
    parent::run(&arguments)
}
