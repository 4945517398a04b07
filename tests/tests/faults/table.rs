//! The table of what became of the runs.

use std::collections::BTreeSet;

use tests::every_call::{CallNumber, name_of, number_of};

use crate::plans::codes;
use crate::worker::{Became, Memory};

/// The most bytes of ours that a run may leave behind, on average over the last half of the runs,
/// beside [`LIST_BYTES`].
const LEAK_BYTES: i64 = 64;

/// The bytes by which lists that are kept may grow, whatever the number of runs.
const LIST_BYTES: i64 = 16 << 10;

/// The fewest runs whose growth is checked: those behind the first half of the sample in `ci/test`.
const LEAK_RUNS: usize = 4;

/// The counts of a program on a driver.
#[derive(Default)]
pub struct Row {
    /// The program and the driver.
    pub name: String,
    /// The number of calls of the program without faults.
    pub calls: usize,
    /// The functions and codes that could be injected.
    pub met: BTreeSet<(&'static str, String)>,
    /// The functions and codes that were injected.
    pub injected: BTreeSet<(&'static str, String)>,
    /// The functions and codes after which something was degraded.
    pub degrading: BTreeSet<String>,
    /// The runs whose image was right all the same.
    pub survived: usize,
    /// The runs whose image was degraded, with a warning that names what, the call and the code.
    pub degraded: usize,
    /// The runs that ended with an error that names the call and the code.
    pub named: usize,
    /// The runs whose window showed no frame, by faults of the window that last.
    pub unshown: usize,
    /// The runs that did not come to their fault.
    pub unreached: usize,
    /// The runs with two faults.
    pub pairs: usize,
    /// The runs in which something was lost.
    pub failed: usize,
    /// The seconds of all runs.
    pub seconds: f64,
    /// The memory of the process of the last run, after so many runs.
    memory: Vec<(usize, Memory)>,
}

/// Writes the head of a table of Markdown.
pub fn print_head() {
    println!(
        "| program | calls | codes of calls | runs | two faults | right image | coarser shadows | named error | window without frames | not reached | failed | ms per run | growth of all (KiB) | growth of ours (bytes per run) |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
}

impl Row {
    /// Returns the row of a program that makes these calls.
    pub fn new(name: String, trace: &[CallNumber]) -> Self {
        let calls: BTreeSet<CallNumber> = trace.iter().copied().collect();
        let of_call = |call: CallNumber| {
            codes(call).into_iter().map(move |code| (name_of(call), format!("{code:?}")))
        };
        let met = calls.into_iter().flat_map(of_call).collect();
        Self { name, calls: trace.len(), met, ..Self::default() }
    }

    /// Counts a run. Returns true if its image was degraded.
    pub fn add(&mut self, plan: &str, became: Result<Became, String>) -> bool {
        let words: Vec<&str> = plan.split(' ').collect();
        self.pairs += usize::from(became.as_ref().is_ok_and(|became| became.has_both));
        let kind = became.as_ref().map(|became| became.kind.as_str());
        match kind {
            Ok("unreached") => self.unreached += 1,
            Ok("survived") => self.survived += 1,
            Ok("degraded") => self.degraded += 1,
            Ok(unshown) if unshown.starts_with("unshown ") => self.unshown += 1,
            Ok(_) => self.named += 1,
            Err(problem) => self.fail(plan, problem),
        }
        if kind != Ok("unreached")
            && let Some(call) = number_of(words[0])
        {
            self.injected.insert((name_of(call), words[2].to_owned()));
        }
        let is_degraded = kind == Ok("degraded");
        if is_degraded {
            self.degrading.insert(format!("{} {}", words[0], words[2]));
        }
        is_degraded
    }

    /// Counts and writes a failure.
    pub fn fail(&mut self, plan: &str, problem: &str) {
        self.failed += 1;
        println!("FAILED {}: --fault \"{plan}\": {problem}", self.name);
    }

    /// Notes the memory of the process; `None` if it is a new process.
    pub fn remember(&mut self, memory: Option<Memory>) {
        match memory {
            Some(memory) => self.memory.push((self.runs(), memory)),
            None => self.memory.clear(),
        }
    }

    /// Fails if each run leaves memory of ours behind.
    pub fn check_memory(&mut self) {
        let (runs, _, bytes) = self.growth();
        if runs >= LEAK_RUNS as i64 && bytes > LEAK_BYTES * runs + LIST_BYTES {
            self.fail("any", &format!("{runs} runs left {bytes} bytes of ours behind"));
        }
    }

    /// Returns the number of runs in the last half of those in the last process, the growth of its
    /// resident memory in KiB, and of the memory of ours in bytes.
    fn growth(&self) -> (i64, i64, i64) {
        let (Some(last), Some(middle)) =
            (self.memory.last(), self.memory.get(self.memory.len() / 2))
        else {
            return (0, 0, 0);
        };
        let kib = last.1.resident_kib - middle.1.resident_kib;
        ((last.0 - middle.0) as i64, kib, last.1.live_bytes - middle.1.live_bytes)
    }

    /// Returns the number of runs.
    pub fn runs(&self) -> usize {
        self.survived + self.degraded + self.named + self.unshown + self.unreached + self.failed
    }

    /// Writes the row.
    pub fn print(&self) {
        let runs = self.runs();
        let (last_runs, kib, bytes) = self.growth();
        println!(
            "| {} | {} | {} | {runs} | {} | {} | {} | {} | {} | {} | {} | {:.0} | {kib} | {} |",
            self.name,
            self.calls,
            self.injected.len(),
            self.pairs,
            self.survived,
            self.degraded,
            self.named,
            self.unshown,
            self.unreached,
            self.failed,
            self.seconds * 1e3 / runs.max(1) as f64,
            bytes / last_runs.max(1),
        );
    }
}
