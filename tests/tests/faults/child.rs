//! The child: executes the runs that its parent writes, and answers with what became of each.

use std::io::{BufRead, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use gpu::{Instance, InstanceOptions, PresentSkipped, Validation, vk};
use tests::Driver;
use tests::captured_log::CapturedLog;
use tests::every_call::{self, CallNumber, FaultPlan, Lasts, LiveObjects, name_of, number_of};

use crate::plans::parse;
use crate::programs::{Outcome, Program, ProgramKind, Stage, Unshown};

/// The time after which a run hangs, in addition to three times that of a run without a fault.
const HANG: Duration = Duration::from_secs(5);

/// At most one in so many values of a degraded image may be darker than in the right one: at the
/// edges of coarser shadows. Half as many are.
const DARKER_SHARE: usize = 100;

/// A warning after which shadows may differ, and the calls whose failure leads to it.
struct Degradation {
    words: &'static str,
    calls: &'static [&'static str],
}

const COARSER_MAPS: Degradation = Degradation {
    words: "no room for more shadow maps, some get smaller: ",
    calls: &[
        "vkCreateImage",
        "vkCreateImageView",
        "vkAllocateMemory",
        "vkBindImageMemory",
        "vkCreateSampler",
    ],
};

const SMALLER_MASK: Degradation = Degradation {
    words: "no room for a larger shadow mask: ",
    calls: &["vkCreateBuffer", "vkAllocateMemory", "vkBindBufferMemory"],
};

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
            "memory" => {
                every_call::install(FaultPlan::default());
                format!("ok {} {}", resident_kib(), crate::ALLOCATED.allocated())
            }
            losses if losses.starts_with("losses ") => bench.lose(&losses["losses ".len()..]),
            "check" => bench.check(),
            plan => bench.answer(parse(plan)),
        };
        println!("{}", answer.replace('\n', " | "));
        std::io::stdout().flush().expect("the parent reads");
    }
}

struct Bench {
    /// An instance with the layer, so that no run loads the libraries of drivers and layers anew.
    _loaded: Instance,
    kind: ProgramKind,
    program: Program,
    driver: Driver,
    /// The warnings and errors of the engine.
    log: CapturedLog,
    reference: Vec<u8>,
    /// The image without shadows, of a program that has some.
    unshadowed: Option<Vec<u8>>,
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
        let options = InstanceOptions { validation: Validation::Core, ..Default::default() };
        let loaded = gpu::load_entry().and_then(|entry| Instance::new(entry, &options));
        let mut bench = Self {
            _loaded: loaded.unwrap_or_else(|error| panic!("{error}")),
            kind,
            program: Program::new(kind),
            driver,
            log,
            reference: Vec::new(),
            unshadowed: None,
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
            assert_eq!(every_call::take_unnamed(), LiveObjects::new(), "objects without a name");
            bench.kept = Resources::now().beyond(before);
        }
        let lit = bench.program.unshadowed(&Stage::new(driver, Validation::Off));
        bench.unshadowed = lit.transpose().unwrap_or_else(|error| panic!("{error}"));
        assert_ne!(bench.unshadowed.as_ref(), Some(&bench.reference), "no shadow");
        let mut pixels = bench.reference.as_chunks::<4>().0.iter();
        let first = pixels.next();
        assert!(pixels.any(|pixel| Some(pixel) != first), "one colour");
        bench
    }

    fn trace(&self) -> String {
        let names: Vec<&str> = self.trace.iter().map(|call| name_of(*call)).collect();
        format!("ok {}", names.join(" "))
    }

    /// Loses a number of devices in one run. Answers with the resident memory (KiB) after the first
    /// tenth of the losses and after the last.
    fn lose(&self, count: &str) -> String {
        let count: usize = count.parse().expect("a number");
        let mut memory_kib = Vec::new();
        let note = |number| {
            if number + 1 == count / 10 || number + 1 == count {
                memory_kib.push(resident_kib().to_string());
            }
        };
        let before = Resources::now();
        let stage = Stage::new(self.driver, Validation::Off);
        let lost = self.program.lose(&stage, count, note);
        drop(stage);
        every_call::stop();
        let more = Resources::now().beyond(before);
        match lost {
            Ok(_) if more.files > self.kept.files || more.threads > self.kept.threads => {
                format!("bad left behind: {more:?}")
            }
            Ok(_) => format!("ok {}", memory_kib.join(" ")),
            Err(error) => format!("bad {}", text_of(error.as_ref())),
        }
    }

    /// Runs the program with faults, and returns what became of it.
    fn answer(&self, plan: FaultPlan) -> String {
        let began = Instant::now();
        let mut found = self.once(plan, Validation::Core);
        let took = began.elapsed();
        let fired = every_call::fired();
        let has_both = every_call::second_fired();
        let calls_after = every_call::calls_after_first();
        let kind = match &found.outcome {
            Ok(image) if *image == self.reference => {
                if fired.is_empty() { "unreached" } else { "survived" }.to_owned()
            }
            Ok(image) if self.is_degraded(&found.log, &fired) => {
                found.faults.extend(self.worse_than_degraded(image));
                "degraded".to_owned()
            }
            Ok(_) => {
                found.faults.push(format!("a wrong image: {}", found.log));
                String::new()
            }
            Err(error) => {
                let text = text_of(error.as_ref());
                if found.must_recover && plan.is_one_loss() {
                    found.faults.push(format!("not recovered: {text}"));
                }
                let unshown = error.downcast_ref::<Unshown>();
                // A window says that its device is lost by a value, and by which call in the log.
                let is_logged = unshown
                    .is_some_and(|Unshown(reason)| *reason == PresentSkipped::DeviceLost)
                    && found.log.lines().any(|line| names(line, &fired));
                let is_unshown = unshown.is_some_and(|unshown| is_expected(*unshown, plan, &fired));
                if !is_logged && !is_unshown && !names(&text, &fired) {
                    found.faults.push(format!("the error names no call and code: {text}"));
                }
                format!("{} {text}", if is_unshown { "unshown" } else { "named" })
            }
        };
        // Other programs may have stopped this one for a while, but not twice.
        if took > HANG && self.hangs(plan) {
            found.faults.push(format!("hangs for {} s", took.as_secs()));
        }
        if found.faults.is_empty() {
            let verdict = if has_both { "pair" } else { "ok" };
            return format!("{verdict} {calls_after} {kind}");
        }
        // A fault that lasts is injected thousands of times.
        let fired: Vec<_> = fired
            .iter()
            .take(16)
            .map(|(call, code)| format!("{}={code:?}", name_of(*call)))
            .collect();
        format!("bad {} [{}]", found.faults.join("; "), fired.join(", "))
    }

    /// Returns true if the run takes much longer than one without a fault.
    fn hangs(&self, plan: FaultPlan) -> bool {
        let time_of = |plan| {
            let began = Instant::now();
            self.once(plan, Validation::Core);
            began.elapsed()
        };
        time_of(plan) > HANG + 3 * time_of(FaultPlan::default())
    }

    /// Returns true if a line of the log says what is degraded, by which call and code.
    fn is_degraded(&self, log: &str, fired: &[(CallNumber, vk::Result)]) -> bool {
        let Degradation { words, calls } = match self.kind {
            ProgramKind::Shadows => COARSER_MAPS,
            ProgramKind::Volumes => SMALLER_MASK,
            _ => return false,
        };
        let leads_to_it = |(call, _): &&(CallNumber, vk::Result)| calls.contains(&name_of(*call));
        let fired: Vec<_> = fired.iter().filter(leads_to_it).copied().collect();
        log.lines().any(|line| line.contains(words) && names(line, &fired))
    }

    /// Returns why an image is worse than one with coarser or missing shadows, if it is: lighter
    /// than without shadows, or darker than with all of them, but for the edges of coarser ones.
    fn worse_than_degraded(&self, image: &[u8]) -> Option<String> {
        let lit = self.unshadowed.as_ref()?;
        let values = || image.iter().copied().zip(self.reference.iter().zip(lit));
        let lighter = values().filter(|(found, (_, lit))| *found > lit.saturating_add(1)).count();
        let darker = values().filter(|(found, (right, _))| *found < right.saturating_sub(1));
        let darker = darker.count();
        let is_worse = lighter > 0 || darker > image.len() / DARKER_SHARE;
        is_worse.then(|| format!("degraded: {lighter} values too light, {darker} too dark"))
    }

    /// Runs the program without a fault.
    fn check(&self) -> String {
        let mut found = self.once(FaultPlan::default(), Validation::Off);
        match found.outcome {
            Ok(image) if image == self.reference => {}
            Ok(_) => found.faults.push("a wrong image".to_owned()),
            Err(error) => found.faults.push(error.to_string()),
        }
        if found.faults.is_empty() {
            return "ok".to_owned();
        }
        format!("bad afterwards: {}", found.faults.join("; "))
    }

    fn once(&self, plan: FaultPlan, validation: Validation) -> Found {
        let before = Resources::now();
        let alive_before = every_call::live_objects();
        let stage = Stage::new(self.driver, validation);
        every_call::install(plan);
        let run = catch_unwind(AssertUnwindSafe(|| self.program.run(&stage)));
        every_call::stop();
        let more = self.kept_since(before);
        let mut faults = Vec::new();
        let panic = PANIC.lock().unwrap().take();
        let outcome = run.unwrap_or_else(|_| Err("a panic".into()));
        faults.extend(panic);
        let messages = stage.messages();
        faults.extend(
            messages.iter().take(3).map(|message| format!("{}: {}", message.id, message.text)),
        );
        if self.is_beyond_kept(more) {
            faults.push(format!("left behind: {more:?}"));
        }
        let mut left = every_call::live_objects();
        left.retain(|kind, count| *count != alive_before.get(kind).copied().unwrap_or_default());
        if !left.is_empty() {
            faults.push(format!("objects that are alive: {left:?}"));
        }
        let must_recover = stage.has_begun();
        Found { outcome, log: self.log.take(), faults, must_recover }
    }
}

impl Bench {
    /// Returns the files and threads that a run has left. Waits a while for what another thread
    /// closes, as that of a window on Wayland does when its last present ends.
    fn kept_since(&self, before: Resources) -> Resources {
        let began = Instant::now();
        loop {
            let more = Resources::now().beyond(before);
            if !self.is_beyond_kept(more) || began.elapsed() > HANG {
                return more;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn is_beyond_kept(&self, more: Resources) -> bool {
        more.files > self.kept.files || more.threads > self.kept.threads
    }
}

/// Returns true if a text names the call, by any of its names, and the code of a fault.
fn names(text: &str, fired: &[(CallNumber, vk::Result)]) -> bool {
    let calls: Vec<CallNumber> =
        text.split(|letter: char| !letter.is_alphanumeric()).filter_map(number_of).collect();
    let is_named = |(call, code): &(CallNumber, vk::Result)| {
        calls.contains(call) && text.contains(&format!("{code:?}"))
    };
    fired.iter().any(is_named)
}

/// Returns true if a window that shows no frame is what the faults stand for: those of the window
/// that last, and a surface that is lost.
fn is_expected(
    Unshown(reason): Unshown,
    plan: FaultPlan,
    fired: &[(CallNumber, vk::Result)],
) -> bool {
    let codes: &[vk::Result] = match reason {
        PresentSkipped::Hidden => &[vk::Result::TIMEOUT, vk::Result::NOT_READY],
        PresentSkipped::OutOfDate => &[
            vk::Result::ERROR_OUT_OF_DATE_KHR,
            vk::Result::ERROR_NATIVE_WINDOW_IN_USE_KHR,
            vk::Result::ERROR_FULL_SCREEN_EXCLUSIVE_MODE_LOST_EXT,
        ],
        PresentSkipped::SurfaceLost | PresentSkipped::WindowGone => {
            &[vk::Result::ERROR_SURFACE_LOST_KHR]
        }
        _ => &[],
    };
    let lasts = plan.first.is_some_and(|first| first.lasts == Lasts::Forever);
    (lasts || reason == PresentSkipped::WindowGone)
        && fired.iter().any(|(_, code)| codes.contains(code))
}

struct Found {
    outcome: Outcome,
    log: String,
    faults: Vec<String>,
    /// True if the program was far enough to recover from a loss.
    must_recover: bool,
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
