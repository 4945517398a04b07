//! The child: executes the runs that its parent writes, and answers with what became of each.

use std::io::{BufRead, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use gpu::Validation;
use tests::Driver;
use tests::captured_log::CapturedLog;
use tests::every_call::{self, CallNumber, FaultPlan, name_of};

use crate::plans::parse;
use crate::programs::{Outcome, Program, ProgramKind, Stage};

/// The time after which a run hangs, in addition to three times that of a run without a fault.
const HANG: Duration = Duration::from_secs(5);

/// The last panic of any thread.
static PANIC: Mutex<Option<String>> = Mutex::new(None);

/// Executes runs until the input ends.
pub fn run(kind: ProgramKind, driver: Driver) {
    let log = CapturedLog::default();
    let writer = log.clone();
    let subscriber = tracing_subscriber::fmt().with_ansi(false);
    let subscriber = subscriber.with_writer(move || writer.clone());
    subscriber.with_max_level(tracing_subscriber::filter::LevelFilter::WARN).init();
    let bench = Bench::new(kind, driver, log);
    std::panic::set_hook(Box::new(|panic| {
        *PANIC.lock().unwrap() = Some(panic.to_string());
    }));
    for line in std::io::stdin().lock().lines() {
        let line = line.expect("a line of the parent");
        let answer = match line.as_str() {
            "trace" => bench.trace(),
            "memory" => format!("ok {}", resident_kib()),
            plan => bench.answer(parse(plan)),
        };
        println!("{}", answer.replace('\n', " | "));
        std::io::stdout().flush().expect("the parent reads");
    }
}

struct Bench {
    kind: ProgramKind,
    program: Program,
    driver: Driver,
    /// The warnings and errors of the engine.
    log: CapturedLog,
    reference: Vec<u8>,
    trace: Vec<usize>,
    /// The files and threads that a run without a fault leaves behind: SwiftShader keeps a file
    /// of each instance.
    kept: Resources,
}

/// The open files and the threads of the process.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Resources {
    files: usize,
    threads: usize,
}

impl Bench {
    fn new(kind: ProgramKind, driver: Driver, log: CapturedLog) -> Self {
        let mut bench = Self {
            kind,
            program: Program::new(kind),
            driver,
            log,
            reference: Vec::new(),
            trace: Vec::new(),
            kept: Resources { files: usize::MAX / 2, threads: usize::MAX / 2 },
        };
        // The first run loads libraries that stay loaded.
        for _ in 0..2 {
            let before = Resources::now();
            let found = bench.once(FaultPlan::default(), Validation::Synchronization);
            bench.trace = every_call::trace();
            bench.reference = found.outcome.unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(found.faults, Vec::<String>::new(), "without a fault");
            bench.kept = Resources::now().beyond(before);
        }
        let mut pixels = bench.reference.as_chunks::<4>().0.iter();
        let first = pixels.next();
        assert!(pixels.any(|pixel| Some(pixel) != first), "one colour");
        bench
    }

    fn trace(&self) -> String {
        let names: Vec<&str> = self.trace.iter().map(|call| name_of(*call)).collect();
        format!("ok {}", names.join(" "))
    }

    /// Runs the program with faults, and again without, and returns what became of it.
    fn answer(&self, plan: FaultPlan) -> String {
        let began = Instant::now();
        let mut found = self.once(plan, Validation::Core);
        let took = began.elapsed();
        let fired = every_call::fired();
        let kind = match &found.outcome {
            Ok(_) if fired.is_empty() => "unreached".to_owned(),
            Ok(image) if *image == self.reference => "survived".to_owned(),
            // Shadows become coarser, with a warning.
            Ok(_) if self.kind == ProgramKind::Shadows && names(&found.log, &fired) => {
                "degraded".to_owned()
            }
            Ok(_) => {
                found.faults.push(format!("a wrong image: {}", found.log));
                String::new()
            }
            Err(error) => {
                let text = text_of(error.as_ref());
                // A window says that its device is lost by a value, and by which call in the log.
                let is_logged = self.kind == ProgramKind::Window && names(&found.log, &fired);
                if !is_logged && !names(&text, &fired) {
                    found.faults.push(format!("the error names no call and code: {text}"));
                }
                format!("named {text}")
            }
        };
        let began = Instant::now();
        let after = self.once(FaultPlan::default(), Validation::Off);
        if took > HANG + 3 * began.elapsed() {
            found.faults.push(format!("hangs for {} s", took.as_secs()));
        }
        found.faults.extend(after.faults.into_iter().map(|fault| format!("afterwards: {fault}")));
        match after.outcome {
            Ok(image) if image == self.reference => {}
            Ok(_) => found.faults.push("afterwards: a wrong image".to_owned()),
            Err(error) => found.faults.push(format!("afterwards: {error}")),
        }
        if found.faults.is_empty() {
            format!("ok {kind}")
        } else {
            let fired: Vec<_> =
                fired.iter().map(|(call, code)| format!("{}={code:?}", name_of(*call))).collect();
            format!("bad {} [{}]", found.faults.join("; "), fired.join(", "))
        }
    }

    fn once(&self, plan: FaultPlan, validation: Validation) -> Found {
        let before = Resources::now();
        let stage = Stage::new(self.driver, validation);
        every_call::install(plan);
        let run = catch_unwind(AssertUnwindSafe(|| self.program.run(&stage)));
        every_call::stop();
        let mut faults = Vec::new();
        let panic = PANIC.lock().unwrap().take();
        let outcome = run.unwrap_or_else(|_| Err("a panic".into()));
        faults.extend(panic);
        let messages = stage.messages();
        faults.extend(
            messages.iter().take(3).map(|message| format!("{}: {}", message.id, message.text)),
        );
        let more = Resources::now().beyond(before);
        if more.files > self.kept.files || more.threads > self.kept.threads {
            faults.push(format!("left behind: {more:?}"));
        }
        Found { outcome, log: self.log.take(), faults }
    }
}

/// Returns true if a text names the call and the code of a fault.
fn names(text: &str, fired: &[(CallNumber, gpu::vk::Result)]) -> bool {
    let is_named = |(call, code): &(CallNumber, gpu::vk::Result)| {
        text.contains(name_of(*call)) && text.contains(&format!("{code:?}"))
    };
    fired.iter().any(is_named)
}

struct Found {
    outcome: Outcome,
    log: String,
    faults: Vec<String>,
}

/// Returns the sentences of an error and its causes.
fn text_of(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(error.source(), |cause| cause.source());
    causes.fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}

impl Resources {
    fn now() -> Self {
        let count = |folder| std::fs::read_dir(folder).expect("Linux").count();
        Self { files: count("/proc/self/fd"), threads: count("/proc/self/task") }
    }

    fn beyond(self, before: Self) -> Self {
        Self {
            files: self.files.saturating_sub(before.files),
            threads: self.threads.saturating_sub(before.threads),
        }
    }
}

fn resident_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("a line");
    line.trim().trim_end_matches(" kB").parse().expect("a number")
}
