//! The table of what became of the runs.

use std::collections::BTreeSet;

/// The counts of a program on a driver.
#[derive(Default)]
pub struct Row {
    /// The program and the driver.
    pub name: String,
    /// The number of calls of the program without faults.
    pub calls: usize,
    /// The pairs of a function and a code that were injected.
    pub injected: BTreeSet<String>,
    /// The runs whose image was right all the same.
    pub survived: usize,
    /// The runs whose image had coarser shadows, with a warning that names the call and the code.
    pub degraded: usize,
    /// The runs that ended with an error that names the call and the code.
    pub named: usize,
    /// The runs that did not come to their fault.
    pub unreached: usize,
    /// The runs in which something was lost.
    pub failed: usize,
    /// The seconds of all runs.
    pub seconds: f64,
    /// The growth of the resident memory between the first tenth of the runs and the end, in KiB.
    pub growth_kib: i64,
}

/// Writes the head of a table of Markdown.
pub fn print_head() {
    println!(
        "| program | calls | codes of calls | runs | right image | coarser shadows | named error | not reached | failed | ms per run | growth (KiB) |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
}

impl Row {
    /// Returns the number of runs.
    pub fn runs(&self) -> usize {
        self.survived + self.degraded + self.named + self.unreached + self.failed
    }

    /// Writes the row.
    pub fn print(&self) {
        let runs = self.runs();
        println!(
            "| {} | {} | {} | {runs} | {} | {} | {} | {} | {} | {:.0} | {} |",
            self.name,
            self.calls,
            self.injected.len(),
            self.survived,
            self.degraded,
            self.named,
            self.unreached,
            self.failed,
            self.seconds * 1e3 / runs.max(1) as f64,
            self.growth_kib,
        );
    }
}
