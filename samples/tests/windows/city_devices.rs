//! Runs `city` on several devices, one after the other, as after losses.

use std::fs;

use crate::running::Running;
use harness::{Scratch, pixels, program, stderr};
use tests::xvfb::Xvfb;

const SMALL: [&str; 5] = ["--headless", "--objects", "500", "--size", "320x180"];

/// Checks that a walk that changes its device again and again has the images of one that does not,
/// with lamps and shadows; that a screenshot in between is kept; and that text is drawn
/// on a device that did not draw its letters before.
#[test]
fn another_device_shows_the_same_images() {
    let scratch = Scratch::new("city-devices");
    let script = "0 hour 21:30\n0 shadows maps\n1 another_device\n3 another_device\n\
                  4 screenshot\n5 another_device\n8 another_device\n9 hud\n";
    let stay = script.split_inclusive('\n').filter(|line| !line.ends_with("another_device\n"));
    fs::write(scratch.0.join("stay"), stay.collect::<String>()).unwrap();
    fs::write(scratch.0.join("change"), script).unwrap();
    for script in ["stay", "change"] {
        let rest = ["--validation", "sync", "--frames", "11", "--path", "street"];
        let files = ["--script", script, "--out", &format!("out-{script}")];
        let all = [&SMALL[..], &rest, &files].concat();
        let output = program(crate::CITY, &scratch.0, &all).output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
    }
    let image = |script: &str, frame: u32| {
        pixels(&scratch.0.join(format!("out-{script}/frame_{frame:05}.png")))
    };
    // What is drawn without history is in the text, which differs.
    let differing = (0..9).filter(|frame| image("stay", *frame) != image("change", *frame));
    assert_eq!(differing.collect::<Vec<u32>>(), Vec::<u32>::new());
    assert!(image("stay", 2) != image("stay", 8), "nobody walked");
    // What the text says depends on the history, and on the clock.
    let panel = |script: &str| -> Vec<[u8; 3]> {
        image(script, 10)
            .chunks(320)
            .take(100)
            .skip(22)
            .flat_map(|row| row[4..70].to_vec())
            .collect()
    };
    let is_white = |pixel: &[u8; 3]| pixel.iter().all(|part| *part > 200);
    for script in ["stay", "change"] {
        assert!(panel(script).iter().filter(|pixel| is_white(pixel)).count() > 50, "no text");
    }
    let shot = pixels(&scratch.0.join("out-change/city_00004.png"));
    assert!(shot == image("change", 4), "the screenshot is another image");
}

/// Checks that a window that continues on another device keeps the present mode that its user
/// chose: the next one follows it.
#[test]
fn a_window_on_another_device_keeps_its_present_mode() {
    let server = Xvfb::start();
    let scratch = Scratch::new("city-devices-window");
    let script = "5 present_mode mailbox\n10 another_device\n20 present_mode\n";
    fs::write(scratch.0.join("script"), script).unwrap();
    let mut running = Running::city(&scratch, &server, &["--script", "script", "--frames", "30"]);
    let status = running.end();
    let log = running.log();
    assert!(status.success(), "{status}: {log}");
    assert!(log.contains("now on SwiftShader"), "{log}");
    assert!(log.contains("present mode immediate"), "{log}");
}
