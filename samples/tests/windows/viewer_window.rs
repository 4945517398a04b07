//! Runs `viewer` in a window of an X server without a screen.

use std::fs;

use crate::running::{Running, of_colour};
use crate::viewer_files::scratch;
use harness::{Scratch, pixels, program, scene, stderr};
use tests::x11_screen::Seen;
use tests::xvfb::Xvfb;

const COMMON: [&str; 6] = ["--size", "320x180", "--device", "llvmpipe", "--validation", "sync"];

fn start(scratch: &Scratch, server: &Xvfb, arguments: &[&str]) -> Running {
    let all = [&COMMON[..], arguments].concat();
    Running::show(program(crate::VIEWER, &scratch.0, &all), scratch, server)
}

/// Arguments for a window over `small.glb` whose image stands still.
const STILL: [&str; 7] = ["small.glb", "--camera", "still", "--script", "script", "--hud", "off"];

/// Returns the image of [`STILL`], drawn without a window.
fn still_image(scratch: &Scratch) -> Vec<[u8; 3]> {
    fs::write(scratch.0.join("script"), "0 pause\n").unwrap();
    let rest = ["--headless", "--frames", "2", "--out", "headless"];
    let all = [&COMMON[..], &STILL, &rest].concat();
    let output = program(crate::VIEWER, &scratch.0, &all).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    pixels(&scratch.0.join("headless/frame_00001.png"))
}

#[test]
fn the_window_shows_what_is_drawn_without_one() {
    let server = Xvfb::start();
    let scratch = scratch("viewer-window");
    let expected = still_image(&scratch);
    let mut running = start(&scratch, &server, &STILL);
    let window = Seen::wait_for(&server);
    window.await_pixels(&expected, "the image");
    (0..8).for_each(|_| window.strike('.'.into()));
    window.await_that("some steps", |found| found != expected);
    window.strike('1'.into());
    window.strike('h'.into());
    window.await_that("a text", |found| of_colour(found, [235, 240, 245]) > 0);
    window.close();
    let status = running.end();
    assert!(status.success(), "{status}: {}", running.log());
    for said in ["time stands still", "one step", "camera walk"] {
        assert!(running.log().contains(said), "{said}: {}", running.log());
    }
}

#[test]
fn a_file_that_cannot_be_shown_ends_with_2_in_a_window_too() {
    let server = Xvfb::start();
    let scratch = scratch("viewer-window-broken");
    fs::write(scratch.0.join("cut.glb"), &scene::small()[..200]).unwrap();
    let mut running = start(&scratch, &server, &["cut.glb"]);
    let status = running.end();
    assert_eq!(status.code(), Some(2), "{}", running.log());
    assert!(running.log().contains("error: cut.glb: "), "{}", running.log());
}

/// Checks that a broken file leaves the scene as it is with a message, and that a valid one
/// replaces it.
#[test]
fn files_can_be_dropped_into_the_window() {
    let server = Xvfb::start();
    let scratch = scratch("viewer-window-drop");
    fs::write(scratch.0.join("cut.glb"), &scene::small()[..200]).unwrap();
    fs::write(scratch.0.join("thin.glb"), scene::thin()).unwrap();
    let expected = still_image(&scratch);
    let running = start(&scratch, &server, &STILL);
    let window = Seen::wait_for(&server);
    window.await_pixels(&expected, "the image");
    let folder = scratch.0.canonicalize().unwrap();
    window.drop_file(&folder.join("cut.glb"));
    // The upper half shows the scene that was there, the lower edge says what is wrong.
    let half = expected.len() / 2;
    window.await_that("what is wrong, over the old scene", |found| {
        found[..half] == expected[..half] && found[half..] != expected[half..]
    });
    assert!(running.log().contains("cut.glb cannot be shown: "), "{}", running.log());
    window.drop_file(&folder.join("thin.glb"));
    window.await_that("points and lines", |found| {
        [[255, 0, 0], [0, 255, 0]].iter().all(|colour: &[u8; 3]| {
            found.iter().any(|pixel| (0..3).all(|part| pixel[part].abs_diff(colour[part]) < 80))
        }) && found[..half] != expected[..half]
    });
    window.close();
    running.end_well();
}

#[test]
fn a_signal_while_it_loads_ends_it() {
    let server = Xvfb::start();
    let scratch = scratch("viewer-window-signal");
    let mut running = start(&scratch, &server, &["small.glb"]);
    let _window = Seen::wait_for(&server);
    let process = rustix::process::Pid::from_child(&running.process);
    rustix::process::kill_process(process, rustix::process::Signal::TERM).unwrap();
    let status = running.end();
    assert_eq!(status.code(), Some(143), "{status}: {}", running.log());
}

#[test]
fn an_empty_window_waits_for_a_file() {
    let server = Xvfb::start();
    let scratch = scratch("viewer-window-empty");
    let running = start(&scratch, &server, &[]);
    let window = Seen::wait_for(&server);
    window.await_that("what to do", |found| of_colour(found, [250, 210, 90]) > 0);
    window.close();
    running.end_well();
}
