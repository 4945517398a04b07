//! The parent: chooses the runs, lets children execute them, and watches the children.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, ExitCode, Stdio};
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use tests::Driver;
use tests::every_call::number_of;

use crate::programs::ProgramKind;
use crate::table::{Row, print_head};
use crate::{Arguments, DriverName, plans};

/// The time after which a child is ended. It measures its runs itself, on a busy machine, too.
const RUN_BOUND: Duration = Duration::from_secs(60);
/// The time for one of many losses.
const LOSS_BOUND: Duration = Duration::from_secs(5);
/// The time for the start of a child, which runs its program twice.
const START_BOUND: Duration = Duration::from_secs(60);

/// The most growth of the memory over many losses, as a share of it.
const MOST_GROWTH: f64 = 0.01;

/// Loses `count` devices on each wanted driver, and prints a table. Fails if an image was wrong, or
/// if memory grew by more than [`MOST_GROWTH`] after the first tenth.
fn lose(count: usize, wanted: Option<DriverName>) -> ExitCode {
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
        let answer = worker.ask(&format!("losses {count}"), RUN_BOUND + LOSS_BOUND * count as u32);
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

/// Executes all runs, and prints the table. Fails if any run failed.
pub fn run(arguments: &Arguments) -> ExitCode {
    if let Some(count) = arguments.losses {
        return lose(count, arguments.driver);
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
    let injected = AtomicUsize::new(0);
    let failed = AtomicUsize::new(0);
    print_head();
    let work = || {
        while let Some((program, driver)) = benches.get(next.fetch_add(1, Relaxed)) {
            let number = benches.iter().filter(|(_, other)| other == driver).count();
            let row = measure(*program, *driver, arguments, number);
            row.print();
            injected.fetch_add(row.runs() - row.unreached, Relaxed);
            failed.fetch_add(row.failed, Relaxed);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    let failed = failed.into_inner();
    let injected = injected.into_inner();
    println!("{injected} runs with faults, {failed} failed");
    // A run without its fault shows nothing, nor does a program that the driver cannot run.
    if failed == 0 && injected > 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Executes the runs of one of `number` programs on a driver.
fn measure(program: ProgramKind, driver: DriverName, arguments: &Arguments, number: usize) -> Row {
    // SwiftShader compiles what it draws with for each device anew, which takes it a second.
    let part = if driver == DriverName::Swiftshader { 5 } else { 1 };
    let share = |count: usize| count.div_ceil(part * number);
    let mut worker = Worker::new(program, driver);
    let trace = worker.ask("trace", START_BOUND);
    let trace = trace.unwrap_or_else(|error| panic!("{program:?} on {driver:?}: {error}"));
    let trace: Vec<_> = trace.split(' ').skip(1).filter_map(number_of).collect();
    let plans = match &arguments.fault {
        Some(fault) => vec![fault.clone()],
        None => {
            let mut plans = plans::single(&trace, share(arguments.runs), arguments.seed);
            plans.extend(plans::pairs(&trace, share(arguments.pairs), arguments.seed));
            plans
        }
    };
    execute(&mut worker, &trace, &plans)
}

fn execute(worker: &mut Worker, trace: &[usize], plans: &[String]) -> Row {
    let name = format!("{} on {:?}", worker.name(), Driver::from(worker.driver));
    let mut row = Row { name, calls: trace.len(), ..Row::default() };
    let began = Instant::now();
    let mut memory_kib = 0;
    for (number, plan) in plans.iter().enumerate() {
        let answer = worker.ask(plan, RUN_BOUND);
        let words: Vec<&str> = plan.split(' ').collect();
        match answer.as_deref().map_err(String::as_str) {
            Ok("ok unreached") => row.unreached += 1,
            Ok("ok survived") => row.survived += 1,
            Ok("ok degraded") => row.degraded += 1,
            Ok(text) if text.starts_with("ok named") => row.named += 1,
            Ok(text) | Err(text) => {
                row.failed += 1;
                println!("FAILED {}: --fault \"{plan}\": {text}", row.name);
            }
        }
        row.injected.insert(format!("{} {}", words[0], words[2]));
        if answer.is_err() {
            worker.restart();
            memory_kib = 0;
        }
        if memory_kib == 0 && number >= plans.len() / 10 {
            memory_kib = worker.memory_kib();
        }
    }
    row.seconds = began.elapsed().as_secs_f64();
    row.growth_kib = worker.memory_kib() - memory_kib;
    row
}

/// A child process that executes runs of one program on one driver.
struct Worker {
    program: ProgramKind,
    driver: DriverName,
    child: Child,
    input: ChildStdin,
    answers: Receiver<String>,
}

impl Worker {
    fn new(program: ProgramKind, driver: DriverName) -> Self {
        let (child, input, answers) = start(program, driver);
        Self { program, driver, child, input, answers }
    }

    fn name(&self) -> String {
        self.program.to_possible_value().expect("a name").get_name().to_owned()
    }

    /// Returns the child's answer to a line, or why there is none.
    fn ask(&mut self, line: &str, bound: Duration) -> Result<String, String> {
        let _a_dead_child_is_seen_below = writeln!(self.input, "{line}");
        match self.answers.recv_timeout(bound) {
            Ok(answer) => Ok(answer),
            Err(RecvTimeoutError::Timeout) => Err(format!("hangs for {} s", bound.as_secs())),
            Err(RecvTimeoutError::Disconnected) => {
                let status = self.child.wait();
                Err(format!("the process ended: {status:?}"))
            }
        }
    }

    fn memory_kib(&mut self) -> i64 {
        let answer = self.ask("memory", START_BOUND).unwrap_or_default();
        answer.strip_prefix("ok ").and_then(|kib| kib.parse().ok()).unwrap_or(0)
    }

    fn restart(&mut self) {
        let _it_may_be_dead = self.child.kill();
        let _it_may_be_dead = self.child.wait();
        (self.child, self.input, self.answers) = start(self.program, self.driver);
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        let _it_may_be_dead = self.child.kill();
        let _it_may_be_dead = self.child.wait();
    }
}

fn start(program: ProgramKind, driver: DriverName) -> (Child, ChildStdin, Receiver<String>) {
    let name =
        |value: Option<clap::builder::PossibleValue>| value.expect("a name").get_name().to_owned();
    let mut child = Command::new(std::env::current_exe().expect("this program"))
        .args(["--child", "--program", &name(program.to_possible_value())])
        .args(["--driver", &name(driver.to_possible_value())])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("a child process");
    let input = child.stdin.take().expect("its input");
    let output = BufReader::new(child.stdout.take().expect("its output"));
    let (sender, answers) = channel();
    std::thread::spawn(move || {
        for line in output.lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    (child, input, answers)
}
