//! The parent: chooses the runs, lets children execute them, and counts what became of them.

use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Instant;

use clap::ValueEnum;
use tests::Driver;
use tests::every_call::CallNumber;
use tests::window_fixture::Random;

use crate::coverage::Coverage;
use crate::plans::Taken;
use crate::programs::ProgramKind;
use crate::table::{Row, print_head};
use crate::worker::Worker;
use crate::{Arguments, DriverName, plans};

/// The number of runs with faults before the program runs without a fault in the same process.
const RUNS_BEFORE_A_CHECK: usize = 8;

/// The most second faults that follow the same first one.
const SECONDS_PER_FIRST: usize = RUNS_BEFORE_A_CHECK - 1;

/// The least first faults of a program's pairs.
const LEAST_FIRSTS: usize = 4;

/// The most first faults per wanted pair: no call follows those that end a program at once.
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
        execute(&mut worker, &mut row, &singles);
        let wanted = share(arguments.pairs);
        execute_pairs(&mut worker, &mut row, &trace, wanted, arguments.seed);
    } else {
        execute(&mut worker, &mut row, &given);
    }
    row.seconds = began.elapsed().as_secs_f64();
    row.check_memory();
    row
}

/// Executes runs with one fault each.
fn execute(worker: &mut Worker, row: &mut Row, plans: &[String]) {
    for plans in plans.chunks(RUNS_BEFORE_A_CHECK) {
        let mut batch = Batch::new(worker, row);
        for plan in plans {
            batch.run(plan);
        }
        batch.finish();
    }
}

/// Executes runs with two faults, until so many were injected. A run with the first fault alone
/// tells how many calls can be the second one: mostly those of a clean-up or a recovery.
fn execute_pairs(
    worker: &mut Worker,
    row: &mut Row,
    trace: &[CallNumber],
    wanted: usize,
    seed: u64,
) {
    let mut random = Random::new(!seed);
    let per_first = SECONDS_PER_FIRST.min(wanted.div_ceil(LEAST_FIRSTS));
    for _ in 0..TRIES_PER_PAIR * wanted {
        let missing = wanted.saturating_sub(row.pairs);
        if missing == 0 {
            break;
        }
        let first = plans::first_of_pair(trace, &mut random);
        let mut batch = Batch::new(worker, row);
        let calls_after = batch.run(&plans::write(&first, None));
        let count = missing.min(per_first);
        for plan in plans::seconds(&first, calls_after, count, &mut random) {
            batch.run(&plan);
        }
        batch.finish();
    }
}

/// Runs with faults, after which the program runs once without a fault in the same process.
struct Batch<'a> {
    worker: &'a mut Worker,
    row: &'a mut Row,
    plans: Vec<String>,
}

impl<'a> Batch<'a> {
    fn new(worker: &'a mut Worker, row: &'a mut Row) -> Self {
        Self { worker, row, plans: Vec::new() }
    }

    /// Runs the program with faults, and returns the number of calls after the first one.
    fn run(&mut self, plan: &str) -> usize {
        self.plans.push(plan.to_owned());
        let became = self.worker.run(plan);
        let calls_after = became.as_ref().map_or(0, |became| became.calls_after);
        let is_degraded = self.row.add(plan, became);
        // What is degraded ends with its renderer.
        if is_degraded && let Err(problem) = self.worker.check() {
            self.row.fail(plan, &problem);
        }
        calls_after
    }

    /// Runs the program without a fault, and notes the memory of the process.
    fn finish(self) {
        if let Err(problem) = self.worker.check() {
            find_culprit(self.worker, self.row, &self.plans, &problem);
        }
        self.row.remember(self.worker.memory());
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
