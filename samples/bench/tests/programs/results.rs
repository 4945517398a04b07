//! Runs `walkthrough` in situations that endanger results: full disks, signals, taken names,
//! concurrent runs.

use std::fs;
use std::io::Read;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use harness::{Scratch, signalled_program, stderr};
use serde_json::Value;

use crate::{WALKTHROUGH, walkthrough};

const SMALL: [&str; 6] = [
    "--objects=200",
    "--frames=4",
    "--size=160x90",
    "--device=llvmpipe",
    "--strategy=frustum,antumbra",
    "--cost-model=off",
];

fn run(scratch: &Scratch, arguments: &[&str]) -> Output {
    let all = [&SMALL[..], arguments].concat();
    walkthrough(&scratch.0, &all).output().expect("it starts")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Checks that the table and each failure are printed, and that the exit code is 1.
fn assert_table_and_failures(output: &Output, failures: &[&str]) {
    let message = stderr(output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(stdout(output).contains("\u{2502} antumbra"), "the table is lost: {message}");
    let errors: Vec<&str> = message.lines().filter(|line| line.starts_with("error: ")).collect();
    assert_eq!(errors.len(), failures.len(), "{message}");
    for failure in failures {
        assert!(errors.iter().any(|error| error.contains(failure)), "{failure}: {message}");
    }
}

#[test]
fn a_report_that_finds_no_space_costs_nothing_else() {
    let scratch = Scratch::new("results-report");
    let output = run(&scratch, &["--report=/dev/full", "--out=out", "--images=2"]);
    assert_table_and_failures(&output, &["cannot write '/dev/full'"]);
    assert_eq!(scratch.names("out").len(), 4, "two frames, and one moment twice");
}

#[test]
fn a_pipe_that_nobody_reads_holds_no_walk() {
    let scratch = Scratch::new("results-pipe");
    let pipe = scratch.0.join("pipe");
    assert!(Command::new("mkfifo").arg(pipe).status().expect("it starts").success());
    let output = run(&scratch, &["--report=pipe"]);
    assert_table_and_failures(&output, &["this pipe has no reader"]);
}

#[test]
fn images_that_find_no_space_cost_nothing_else() {
    let scratch = Scratch::new("results-images");
    let walk = walkthrough(&scratch.0, &SMALL);
    // Files must not grow beyond 8 KiB, which is enough for the report but not for an image.
    let limited = "ulimit -f 16; exec \"$0\" \"$@\"";
    let outputs = ["--size=640x360", "--out=out", "--images=2", "--report=report.json"];
    let mut command = Command::new("sh");
    command.current_dir(&scratch.0).args(["-c", limited]).arg(walk.get_program());
    command.args(walk.get_args()).args(outputs).env("XDG_CACHE_HOME", "/proc/nowhere");
    let output = command.output().expect("it starts");
    let lost = ["frame_00000.png", "frame_00002.png", "00002_seen.png", "top_down_00002.png"];
    assert_table_and_failures(&output, &lost);
    assert_eq!(scratch.names("."), ["report.json"], "nothing is half there");
    let report = fs::read_to_string(scratch.0.join("report.json")).expect("the report");
    serde_json::from_str::<Value>(&report).expect("all of it");
}

#[test]
fn the_longest_name_is_written() {
    let scratch = Scratch::new("results-long");
    let name = "x".repeat(250) + ".json";
    let output = run(&scratch, &["--report", &name]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains(&format!("wrote {name}")), "{}", stderr(&output));
    assert_eq!(scratch.names("."), [name]);
}

#[test]
fn what_cannot_be_printed_is_no_success() {
    let scratch = Scratch::new("results-stdout");
    let full = || fs::File::create("/dev/full").expect("a device");
    for arguments in [&["--help"][..], &["--version"], &["--list-strategies"], &["--list-devices"]]
    {
        let mut command = walkthrough(&scratch.0, arguments);
        let output = command.stdout(full()).output().expect("it starts");
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
        assert!(message.contains("cannot write to standard output"), "{arguments:?}: {message}");
    }
    let mut command = walkthrough(&scratch.0, &[&SMALL[..], &["--report=report.json"]].concat());
    let output = command.stdout(full()).output().expect("it starts");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert_eq!(scratch.names("."), ["report.json"], "what can be written is");
    // Without any working output it still ends normally.
    let mut command = walkthrough(&scratch.0, &SMALL);
    assert_eq!(command.stderr(full()).output().expect("it starts").status.code(), Some(0));
}

#[test]
fn what_was_measured_before_a_signal_is_kept() {
    for (signal, code) in [
        (rustix::process::Signal::INT, 130),
        (rustix::process::Signal::TERM, 143),
        (rustix::process::Signal::HUP, 129),
    ] {
        let scratch = Scratch::new("results-signal");
        let more = ["--frames=600", "--verify=every", "--report=report.json", "--out=out"];
        let arguments = [&SMALL[..], &more].concat();
        let mut command = signalled_program(WALKTHROUGH, &scratch.0, &arguments);
        let mut child =
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        let mut said = String::new();
        let mut log = child.stderr.take().expect("piped");
        let began = Instant::now();
        // The first tenth is drawn.
        while !said.contains(" frames") {
            assert!(began.elapsed() < Duration::from_secs(120), "nothing is drawn: {said}");
            let mut byte = [0];
            log.read_exact(&mut byte).expect("it says how far it is");
            said.push(byte[0].into());
        }
        let process = rustix::process::Pid::from_child(&child);
        rustix::process::kill_process(process, signal).expect("it runs");
        log.read_to_string(&mut said).expect("text");
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(code), "{said}");
        let table = stdout(&output);
        assert!(table.contains("CUT SHORT") && table.contains("\u{2502} antumbra"), "{table}");
        let report = fs::read_to_string(scratch.0.join("report.json")).expect("the report");
        let report: Value = serde_json::from_str(&report).expect("JSON");
        assert_eq!(report["cut_short"], true);
        let frames = report["runs"][0]["frames_timed"].as_u64().expect("a number");
        assert!((1..600).contains(&frames), "{frames} frames");
        assert_eq!(report["runs"][0]["pixels_wrong"], 0);
    }
}

#[test]
fn before_anything_is_measured_a_signal_is_just_the_end() {
    let scratch = Scratch::new("results-early");
    let more = ["--objects=100000", "--out=out", "--report=report.json"];
    let arguments = [&SMALL[..], &more].concat();
    let mut command = signalled_program(WALKTHROUGH, &scratch.0, &arguments);
    let mut child = command.stderr(Stdio::piped()).spawn().expect("it starts");
    let mut said = [0; 8];
    child.stderr.as_mut().expect("piped").read_exact(&mut said).expect("it says what it does");
    let process = rustix::process::Pid::from_child(&child);
    rustix::process::kill_process(process, rustix::process::Signal::INT).expect("it runs");
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert!(stderr(&output).contains("ended before anything was measured"));
    assert!(scratch.names(".").is_empty(), "nothing is left behind");
}

#[test]
fn nothing_is_overwritten_that_another_run_wrote() {
    let scratch = Scratch::new("results-again");
    let more = ["--out=out", "--images=1", "--top-down=off"];
    assert_eq!(run(&scratch, &more).status.code(), Some(0));
    let image = scratch.0.join("out/frame_00000.png");
    fs::write(&image, "mine").expect("ours");
    let output = run(&scratch, &more);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("wrote out/frame_00000-2.png"), "{}", stderr(&output));
    assert_eq!(fs::read_to_string(&image).expect("it is there"), "mine");
    assert_eq!(scratch.names("out"), ["frame_00000-2.png", "frame_00000.png"]);
}

#[test]
fn many_programs_write_into_one_new_folder() {
    let scratch = Scratch::new("results-crowd");
    for round in 0..3 {
        let out = format!("--out=new-{round}/er/out");
        let arguments = [&SMALL[..], &["--quiet", "--images=1", "--top-down=off", &out]].concat();
        let start = |_| {
            let mut command = walkthrough(&scratch.0, &arguments);
            command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it starts")
        };
        let children: Vec<_> = (0..8).map(start).collect();
        for child in children {
            let output = child.wait_with_output().expect("it ends");
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        }
        assert_eq!(scratch.names(&format!("new-{round}/er/out")).len(), 8, "an image of each");
    }
}

#[test]
fn a_self_test_prints_a_line_for_each_assumption() {
    let scratch = Scratch::new("results-self-test");
    for device in ["llvmpipe", "swiftshader"] {
        let arguments = ["--self-test", "--device", device, "--validation=sync"];
        let output = walkthrough(&scratch.0, &arguments).output().expect("it starts");
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let table = stdout(&output);
        assert!(table.contains("query counts") && table.contains("walk with flags"), "{table}");
        assert!(table.ends_with("safest strategy: antumbra\n") && !table.contains("BROKEN"));
    }
    let output = run(&scratch, &["--quirks=tested", "--report=report.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = fs::read_to_string(scratch.0.join("report.json")).expect("the report");
    let report: Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["driver_quirks"], Value::Array(Vec::new()));
}
