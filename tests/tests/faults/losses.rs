//! Many losses of a device, one after the other in one process.

use std::process::ExitCode;
use std::time::Instant;

use clap::ValueEnum;
use tests::Driver;

use crate::DriverName;
use crate::programs::ProgramKind;
use crate::worker::Worker;

/// The most growth of the memory over many losses, as a share of it.
const MOST_GROWTH: f64 = 0.01;

/// Loses `count` devices on each wanted driver, and prints a table. Fails if an image was wrong, or
/// if memory grew by more than [`MOST_GROWTH`] after the first tenth.
pub fn lose(count: usize, wanted: Option<DriverName>) -> ExitCode {
    println!(
        "| driver | losses | ms per loss | memory after a tenth (KiB) | in the end | growth |"
    );
    println!("|---|---|---|---|---|---|");
    let mut is_good = true;
    for driver in DriverName::value_variants() {
        if wanted.is_some_and(|wanted| wanted != *driver) {
            continue;
        }
        let mut worker = Worker::new(ProgramKind::Recovering, *driver);
        let began = Instant::now();
        let answer = worker.lose(count);
        let numbers = answer.as_deref().ok().and_then(|answer| answer.strip_prefix("ok "));
        let numbers = numbers.unwrap_or_default().split(' ').map(str::parse::<f64>);
        let numbers: Vec<f64> = numbers.filter_map(Result::ok).collect();
        let [first, last] = numbers[..] else {
            println!("FAILED on {:?}: {answer:?}", Driver::from(*driver));
            is_good = false;
            continue;
        };
        let growth = last / first - 1.0;
        is_good &= growth < MOST_GROWTH;
        println!(
            "| {:?} | {count} | {:.0} | {first} | {last} | {:.2} % |",
            Driver::from(*driver),
            began.elapsed().as_secs_f64() * 1e3 / count as f64,
            growth * 100.0
        );
    }
    if is_good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
