//! A soak: very many frames of a small scene that changes all the time, in one process. The images
//! are exact, and nothing grows (`docs/book/src/faults.md`).
//!
//! Without arguments, as in the test suite, it runs some thousand frames under the validation
//! layer. `ci/soak` runs a million without it.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod sample;

use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Parser;
use gpu::{Device, DeviceOptions, Instance, InstanceOptions, Validation};
use tests::long_run::{LongRun, Loss};
use tests::{Driver, every_call};

use sample::{Sample, print_head};

/// Counts the memory of this program, without that of drivers.
#[global_allocator]
static ALLOCATED: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, usize::MAX);

/// The number of frames between two comparisons of images.
const FRAMES_PER_COMPARISON: u64 = 500;

/// The bound of every wait.
const WAIT_BOUND: Duration = Duration::from_secs(60);

/// Draws very many frames of a scene that changes all the time.
#[derive(Parser, Clone, Debug)]
struct Arguments {
    /// The number of frames.
    #[arg(long, default_value_t = 2_000)]
    frames: u64,
    /// The number of samples of what the process holds.
    #[arg(long, default_value_t = 4)]
    samples: u64,
    /// The seed of the changes.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Draws without the validation layer, many times as fast.
    #[arg(long)]
    unvalidated: bool,
    /// As other test programs have it: runs nothing if it is not a part of the word `soak`.
    #[arg(hide = true)]
    filter: Option<String>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.filter.as_deref().is_some_and(|filter| !"soak".contains(filter)) {
        return ExitCode::SUCCESS;
    }
    let validation =
        if arguments.unvalidated { Validation::Off } else { Validation::Synchronization };
    let options = InstanceOptions { application: "soak".to_owned(), validation, windows: None };
    let instance = Instance::new(every_call::entry(), &options);
    let instance = instance.unwrap_or_else(|error| panic!("{error}"));
    let log = instance.validation_log().clone();
    let mut problems = soak(&arguments, &instance);
    drop(instance);
    let left = every_call::live_objects();
    if left.values().any(|count| *count != 0) {
        problems.push(format!("alive in the end: {left:?}"));
    }
    let unnamed = every_call::take_unnamed();
    if !unnamed.is_empty() {
        problems.push(format!("without a debug name: {unnamed:?}"));
    }
    problems.extend(log.drain().iter().map(|message| format!("{}: {}", message.id, message.text)));
    problems.iter().for_each(|problem| println!("FAILED: {problem}"));
    if problems.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Draws all frames, and returns what grew.
fn soak(arguments: &Arguments, instance: &Instance) -> Vec<String> {
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name()));
    let adapter = adapter.unwrap_or_else(|error| panic!("{error}"));
    let opener = instance.clone();
    let open = move || {
        let options = DeviceOptions { wait_bound: WAIT_BOUND, ..DeviceOptions::default() };
        Device::new(&opener, &adapter, &options).expect("a device")
    };
    let mut run = LongRun::new(arguments.seed, Loss::Injected, Box::new(open));
    let mut samples = Vec::new();
    let mut began = Instant::now();
    print_head();
    for number in 1..=arguments.samples {
        let until = arguments.frames * number / arguments.samples;
        let before = run.frames;
        let mut compared = run.frames;
        while run.frames < until {
            run.step();
            if run.frames >= compared + FRAMES_PER_COMPARISON {
                compared = run.frames;
                run.compare();
            }
        }
        // Equal states: at rest, on a device that has done nothing else.
        run.rest();
        run.lose_device();
        run.rest();
        every_call::install(every_call::FaultPlan::default());
        let rate = (run.frames - before) as f64 / began.elapsed().as_secs_f64();
        samples.push(Sample::now(&run));
        samples.last().unwrap().print(rate);
        began = Instant::now();
    }
    sample::growth(&samples)
}
