//! Scripts of `city` without a window: comparing with no culling, identifying an object.

use std::fs;

use crate::running::of_colour;
use harness::{Scratch, pixels, program, stderr};

const MARK: [u8; 3] = [245, 130, 80];

/// Runs a script with frames of 320x180 pixels; returns the log.
fn run(scratch: &Scratch, script: &str, arguments: &[&str]) -> String {
    fs::write(scratch.0.join("script"), script).unwrap();
    let all = ["--headless", "--objects", "500", "--size", "320x180", "--script", "script"];
    let rest = ["--device", "llvmpipe", "--validation", "sync", "--cost-model", "off"];
    let all = [&all[..], &rest, arguments].concat();
    let mut command = program(crate::CITY, &scratch.0, &all);
    command.env("RUST_LOG", "samples=info");
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    stderr(&output)
}

/// Returns the number in front of a word of the log's last line that has it.
fn number_before(log: &str, words: &str) -> u64 {
    let line = log.lines().rev().find(|line| line.contains(words)).expect("a line that says it");
    let before = line.split(words).next().unwrap().trim_end();
    before.rsplit([' ', ':']).next().unwrap().parse().expect("a number")
}

#[test]
fn an_exact_strategy_differs_in_no_pixel() {
    let scratch = Scratch::new("script-compare");
    let rest = ["--path", "cut", "--frames", "70", "--out", "out"];
    for strategy in ["antumbra", "hzb"] {
        let log = run(&scratch, "2 compare\n", &[&rest[..], &["--strategy", strategy]].concat());
        // The images wait for each frame, so that every one of the 68 is compared.
        let said = format!("{strategy}: 0 pixels differ in 68 frames");
        assert!(log.contains(&said), "{log}");
    }
    // Half a second with culling, half a second without: the images are those of before.
    let plain = run(&scratch, "", &["--path", "cut", "--frames", "70", "--out", "plain"]);
    assert!(!plain.contains("differ"), "{plain}");
    for frame in [5, 40, 69] {
        let image =
            |folder: &str| pixels(&scratch.0.join(format!("{folder}/frame_{frame:05}.png")));
        assert!(image("out") == image("plain"), "frame {frame}");
    }
}

#[test]
fn a_strategy_that_is_not_exact_is_found_out_and_its_errors_are_marked() {
    let scratch = Scratch::new("script-differs");
    let rest = ["--path", "fly", "--objects", "2000", "--frames", "30", "--out", "out"];
    let log = run(&scratch, "2 compare\n", &[&rest[..], &["--strategy", "next_frame"]].concat());
    // Objects that come into view are missing until their results are read back.
    let differing = number_before(&log, "of 28 frames differ");
    assert!((1..=28).contains(&differing) && !log.contains("at most by 0"), "{log}");
    let is_marked = |frame: u32| {
        of_colour(&pixels(&scratch.0.join(format!("out/frame_{frame:05}.png"))), MARK) > 0
    };
    assert!(!is_marked(1) && (3..30).any(is_marked), "where they differ is outlined");
}

#[test]
fn what_cannot_be_compared_is_said() {
    let scratch = Scratch::new("script-compare-not");
    let log = run(&scratch, "2 strategy frustum\n2 compare\n", &["--frames", "4"]);
    assert!(log.contains("frustum is the reference of the comparison"), "{log}");
    let log = run(&scratch, "2 freeze\n3 compare\n", &["--frames", "5"]);
    assert!(log.contains("the culling is frozen: let it go on to compare"), "{log}");
    // Frozen while it compares, it says what it found and ends.
    let log = run(&scratch, "2 compare\n6 freeze\n", &["--frames", "8"]);
    assert!(log.contains("antumbra: 0 pixels differ in"), "{log}");
}

#[test]
fn an_object_says_why_it_is_drawn_or_not() {
    let scratch = Scratch::new("script-identify");
    let script = "20 identify 160,120\n25 strategy frustum\n26 identify\n30 identify 160,0\n";
    let log = run(&scratch, script, &["--frames", "40", "--out", "out", "--path", "street"]);
    for said in [
        "object: ",
        " x ",
        "triangles: ",
        "decision: drawn: taken as visible",
        "visible since frame",
        "decision: drawn: in the frustum",
        "there is no object",
    ] {
        assert!(log.contains(said), "{said}: {log}");
    }
}

/// Checks that an object that a frozen view left out can be identified from outside of the frozen
/// view.
#[test]
fn what_a_frozen_view_left_out_says_so() {
    let scratch = Scratch::new("script-frozen");
    // From a street into the air, 90 m above it. A click in every second frame.
    let rest = "0 1 0 1.0471976 0.2\n";
    let street = "-11.5 1.7 0 0.99875 0.05 0";
    let cameras = (0..80).map(|frame| {
        let place = if frame < 30 { street } else { "8.5 90 0 0.6 -0.8 0" };
        format!("{} {place} {rest}", f64::from(frame) / 60.0)
    });
    let path = format!("antumbra path 1\n{}", cameras.collect::<String>());
    fs::write(scratch.0.join("path.txt"), path).unwrap();
    let asked = (32..78).step_by(2).map(|frame| (frame, [frame * 37 % 320, frame * 13 % 180]));
    let asked = asked.map(|(frame, [x, y])| format!("{frame} identify {x},{y}\n"));
    let script = format!("25 freeze\n{}", asked.collect::<String>());
    let log = run(&scratch, &script, &["--frames", "80", "--path", "path.txt"]);
    let said = |what: &str| log.lines().filter(|line| line.contains(what)).count();
    for decision in ["drawn: taken as visible", "not drawn: outside", "not drawn, hidden in frame"]
    {
        assert!(said(&format!("decision: {decision}")) > 0, "{decision}: {log}");
    }
    // With a standing camera all results are read back: nothing is open.
    assert_eq!(said("drawn if it shows"), 0, "{log}");
}

#[test]
fn escape_closes_what_is_topmost_and_the_panel_of_an_object_too() {
    let scratch = Scratch::new("city-panels");
    let script = "1 identify\n6 help\n8 escape\n10 escape\n";
    // Large enough for the keys.
    run(&scratch, script, &["--frames", "12", "--out", "out", "--size", "960x540"]);
    let frame = |number: u32| pixels(&scratch.0.join(format!("out/frame_{number:05}.png")));
    let [plain, outlined, helped] = [0, 5, 7].map(frame);
    assert!(plain != outlined && outlined != helped, "an object is outlined, then keys are shown");
    assert!(frame(9) == outlined, "the keys are closed first");
    assert!(frame(11) == plain, "then the object");
}
