//! The memory, objects, files and threads of the process after some of the frames.

use tests::every_call::{LiveObjects, live_objects};
use tests::long_run::LongRun;

/// The most bytes of ours by which a thousand frames may grow the process.
const LEAK_BYTES: i64 = 2_048;

/// The bytes by which two samples differ anyway: lists keep the room that they once needed.
const SPREAD_BYTES: i64 = 256 << 10;

/// The frames after which resident memory is level: by then the heap of the C library is
/// fragmented.
const SETTLED_FRAMES: u64 = 200_000;

/// The share by which resident memory may grow after these frames.
const SETTLED_GROWTH: f64 = 0.03;

/// The state of the process, when the scene is the first one again.
pub struct Sample {
    frames: u64,
    losses: u64,
    compared: u64,
    objects: LiveObjects,
    /// The bytes that Rust code has allocated.
    bytes: i64,
    resident_kib: i64,
    files: usize,
    threads: usize,
}

/// Writes the head of a table of Markdown.
pub fn print_head() {
    println!(
        "| frames | per second | losses | images compared | live objects | bytes of ours | resident memory (KiB) | files | threads |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
}

impl Sample {
    /// Returns what the process holds now.
    pub fn now(run: &LongRun) -> Self {
        let count = |folder| std::fs::read_dir(folder).expect("Linux").count();
        Self {
            frames: run.frames,
            losses: run.losses,
            compared: run.compared,
            objects: live_objects(),
            bytes: crate::ALLOCATED.allocated() as i64,
            resident_kib: resident_kib(),
            files: count("/proc/self/fd"),
            threads: count("/proc/self/task"),
        }
    }

    /// Writes a row of the table.
    pub fn print(&self, frames_per_second: f64) {
        println!(
            "| {} | {frames_per_second:.0} | {} | {} | {} | {} | {} | {} | {} |",
            self.frames,
            self.losses,
            self.compared,
            self.objects.values().sum::<i64>(),
            self.bytes,
            self.resident_kib,
            self.files,
            self.threads
        );
    }
}

/// Returns what grew between the first sample and the last.
pub fn growth(samples: &[Sample]) -> Vec<String> {
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else { return Vec::new() };
    let mut problems = Vec::new();
    for sample in &samples[1..] {
        for (kind, count) in &sample.objects {
            let before = first.objects.get(kind).copied().unwrap_or_default();
            if *count != before {
                problems.push(format!("{before} {kind}s became {count}, frame {}", sample.frames));
            }
        }
        if (sample.files, sample.threads) != (first.files, first.threads) {
            problems.push(format!("{} files and {} threads", sample.files, sample.threads));
        }
    }
    let frames = (last.frames - first.frames) as i64;
    let bytes = last.bytes - first.bytes;
    if bytes > SPREAD_BYTES + LEAK_BYTES * frames / 1_000 {
        problems.push(format!("{frames} frames left {bytes} bytes of ours behind"));
    }
    let share = last.resident_kib as f64 / first.resident_kib as f64 - 1.0;
    println!("resident memory grew by {:.2} % after the first sample", share * 100.0);
    let settled = samples.iter().find(|sample| sample.frames >= SETTLED_FRAMES);
    if let Some(settled) = settled.filter(|settled| settled.frames < last.frames) {
        let share = last.resident_kib as f64 / settled.resident_kib as f64 - 1.0;
        println!("and by {:.2} % after {} frames", share * 100.0, settled.frames);
        if share > SETTLED_GROWTH {
            problems.push(format!("resident memory grew after {} frames", settled.frames));
        }
    }
    problems
}

fn resident_kib() -> i64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("a line");
    line.trim().trim_end_matches(" kB").parse().expect("a number")
}
