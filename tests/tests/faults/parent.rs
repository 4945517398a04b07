//! The parent: chooses the runs, lets children execute them, and counts what became of them.

use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Instant;

use clap::ValueEnum;
use tests::Driver;

use crate::coverage::Coverage;
use crate::plans::Taken;
use crate::programs::ProgramKind;
use crate::table::{Row, print_head};
use crate::worker::Worker;
use crate::{Arguments, DriverName, plans};

/// The number of runs with faults before the program runs without a fault in the same process.
const RUNS_BEFORE_A_CHECK: usize = 8;

/// The most runs per wanted pair: many programs end by the first fault, before the second one.
const TRIES_PER_PAIR: usize = 4;

/// Executes all runs, and prints the table. Fails if any run failed.
pub fn run(arguments: &Arguments) -> ExitCode {
    if let Some(count) = arguments.losses {
        return crate::losses::lose(count, arguments.driver);
    }
    let mut benches = Vec::new();
    for program in ProgramKind::value_variants() {
        for driver in DriverName::value_variants() {
            let is_wanted = arguments.program.is_none_or(|wanted| wanted == *program)
                && arguments.driver.is_none_or(|wanted| wanted == *driver);
            if is_wanted && program.runs_on(Driver::from(*driver)) {
                benches.push((*program, *driver));
            }
        }
    }
    let next = AtomicUsize::new(0);
    let rows = Mutex::new(Vec::new());
    let taken = Mutex::new(Taken::new());
    print_head();
    let work = || {
        while let Some((program, driver)) = benches.get(next.fetch_add(1, Relaxed)) {
            let number = benches.iter().filter(|(_, other)| other == driver).count();
            let row = measure(*program, *driver, arguments, number, &taken);
            row.print();
            rows.lock().expect("no thread panics").push(row);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    let rows = rows.into_inner().expect("no thread panics");
    let injected: usize = rows.iter().map(|row| row.runs() - row.unreached).sum();
    let pairs: usize = rows.iter().map(|row| row.pairs).sum();
    let failed: usize = rows.iter().map(|row| row.failed).sum();
    let degrading: Vec<&String> = rows.iter().flat_map(|row| &row.degrading).collect();
    println!(
        "{injected} runs with faults, {pairs} of them with two, {failed} failed; degraded by: {degrading:?}"
    );
    let coverage = Coverage::of(&rows);
    let is_covered = !arguments.coverage || coverage.print();
    // A run without its fault shows nothing, nor does a program that the driver cannot run.
    if failed == 0 && injected > 0 && is_covered { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Executes the runs of one of `number` programs on a driver.
fn measure(
    program: ProgramKind,
    driver: DriverName,
    arguments: &Arguments,
    number: usize,
    taken: &Mutex<Taken>,
) -> Row {
    // SwiftShader compiles what it draws with for each device anew, which takes it a second.
    let part = if driver == DriverName::Swiftshader { 5 } else { 1 };
    let share = |count: usize| count.div_ceil(part * number);
    let mut worker = Worker::new(program, driver);
    let trace = worker.trace();
    let trace = trace.unwrap_or_else(|error| panic!("{program:?} on {driver:?}: {error}"));
    let given = vec![arguments.fault.clone(); arguments.times].concat();
    let mut row =
        Row::new(format!("{} on {:?}", worker.name(), Driver::from(worker.driver)), &trace);
    let began = Instant::now();
    if given.is_empty() {
        let singles = plans::single(&trace, share(arguments.runs), arguments.seed, taken);
        execute(&mut worker, &mut row, &singles, usize::MAX);
        let wanted = share(arguments.pairs);
        let pairs = plans::pairs(&trace, wanted * TRIES_PER_PAIR, arguments.seed);
        execute(&mut worker, &mut row, &pairs, wanted);
    } else {
        execute(&mut worker, &mut row, &given, usize::MAX);
    }
    row.seconds = began.elapsed().as_secs_f64();
    row.check_memory();
    row
}

/// Executes runs, until all are over or so many had two faults.
fn execute(worker: &mut Worker, row: &mut Row, plans: &[String], wanted_pairs: usize) {
    for batch in plans.chunks(RUNS_BEFORE_A_CHECK) {
        if row.pairs >= wanted_pairs {
            break;
        }
        for plan in batch {
            let became = worker.run(plan);
            let is_degraded = row.add(plan, became);
            // What is degraded ends with its renderer.
            if is_degraded && let Err(problem) = worker.check() {
                row.fail(plan, &problem);
            }
        }
        if let Err(problem) = worker.check() {
            find_culprit(worker, row, batch, &problem);
        }
        row.remember(worker.memory());
    }
}

/// Finds the fault after which the program does not run any more without a fault.
fn find_culprit(worker: &mut Worker, row: &mut Row, batch: &[String], problem: &str) {
    let failed = row.failed;
    for plan in batch {
        let _counted_before = worker.run(plan);
        if let Err(problem) = worker.check() {
            row.fail(plan, &problem);
        }
    }
    if row.failed == failed {
        row.fail(&batch.join(", "), problem);
    }
}
