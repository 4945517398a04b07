//! A child process, and what its answers say.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use clap::ValueEnum;
use tests::every_call::{CallNumber, number_of};

use crate::DriverName;
use crate::programs::ProgramKind;

/// The time after which a child is ended. It measures its runs itself, on a busy machine, too.
const RUN_BOUND: Duration = Duration::from_secs(60);
/// The time for the start of a child, which runs its program twice.
const START_BOUND: Duration = Duration::from_secs(60);

/// The memory of a child.
#[derive(Clone, Copy, Debug, Default)]
pub struct Memory {
    /// The resident memory in KiB.
    pub resident_kib: i64,
    /// The bytes that Rust code has allocated: ours, and not the driver's.
    pub live_bytes: i64,
}

/// The end of a run in which nothing was lost.
#[derive(Debug)]
pub struct Became {
    /// The kind of the end: `unreached`, `survived`, `degraded`, or `named` or `unshown`, which an
    /// error follows.
    pub kind: String,
    /// True if both faults of a pair were injected.
    pub has_both: bool,
    /// The number of calls after the first fault.
    pub calls_after: usize,
}

/// A child process that executes runs of one program on one driver.
pub struct Worker {
    program: ProgramKind,
    /// The driver of all runs.
    pub driver: DriverName,
    child: Child,
    input: ChildStdin,
    answers: Receiver<String>,
    /// True if it has replaced another one.
    is_new: bool,
}

impl Worker {
    /// Starts a child.
    pub fn new(program: ProgramKind, driver: DriverName) -> Self {
        let (child, input, answers) = start(program, driver);
        Self { program, driver, child, input, answers, is_new: false }
    }

    /// Returns the name of the program.
    pub fn name(&self) -> String {
        self.program.to_possible_value().expect("a name").get_name().to_owned()
    }

    /// Loses `count` devices in the child, and returns its answer.
    pub fn lose(&mut self, count: usize) -> Result<String, String> {
        const LOSS_BOUND: Duration = Duration::from_secs(5);
        self.ask(&format!("losses {count}"), RUN_BOUND + LOSS_BOUND * count as u32)
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

    /// Returns the calls of the program without a fault.
    pub fn trace(&mut self) -> Result<Vec<CallNumber>, String> {
        let trace = self.ask("trace", START_BOUND)?;
        Ok(trace.split(' ').skip(1).filter_map(number_of).collect())
    }

    /// Runs the program with faults, and returns what became of it. A child that is lost is
    /// replaced.
    pub fn run(&mut self, plan: &str) -> Result<Became, String> {
        let answer = self.ask(plan, RUN_BOUND);
        if answer.is_err() {
            self.restart();
        }
        let text = answer?;
        let mut words = text.splitn(3, ' ');
        let has_both = match words.next() {
            Some("ok") => false,
            Some("pair") => true,
            _ => return Err(text),
        };
        let calls_after = words.next().and_then(|word| word.parse().ok()).expect("a number");
        let kind = words.next().expect("a kind").to_owned();
        Ok(Became { kind, has_both, calls_after })
    }

    /// Runs the program without a fault. A child that fails is replaced.
    pub fn check(&mut self) -> Result<(), String> {
        let answer = self.ask("check", RUN_BOUND);
        let checked = answer.and_then(|text| if text == "ok" { Ok(()) } else { Err(text) });
        if checked.is_err() {
            self.restart();
        }
        checked
    }

    /// Returns the memory of the child; `None` if it has been replaced since the last call.
    pub fn memory(&mut self) -> Option<Memory> {
        let answer = self.ask("memory", START_BOUND).ok()?;
        let mut words = answer.split(' ').skip(1).filter_map(|word| word.parse().ok());
        let memory = Memory { resident_kib: words.next()?, live_bytes: words.next()? };
        (!std::mem::take(&mut self.is_new)).then_some(memory)
    }

    fn restart(&mut self) {
        let _it_may_be_dead = self.child.kill();
        let _it_may_be_dead = self.child.wait();
        (self.child, self.input, self.answers) = start(self.program, self.driver);
        self.is_new = true;
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
        // Without one, libwayland complains whenever a driver looks for a compositor.
        .env("XDG_RUNTIME_DIR", std::env::temp_dir())
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
