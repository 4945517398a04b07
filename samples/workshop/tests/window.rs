//! Works in the window of `workshop` as a user does, on an X server without a screen.
#![allow(clippy::expect_used, clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use harness::{Scratch, pixels, program, stderr};
use serde_json::Value;
use tests::x11_screen::{BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, Seen};
use tests::xvfb::Xvfb;

const WORKSHOP: &str = env!("CARGO_BIN_EXE_workshop");
const ESCAPE: u32 = 0xff1b;
const F1: u32 = 0xffbe;
const CONTROL: u32 = 0xffe3;
const LEFT: u8 = 1;
const SIZE: [usize; 2] = [800, 600];
/// The lines around what is below the pointer, and around what is selected.
const HOVERED: [u8; 3] = [63, 180, 255];
const SELECTED: [u8; 3] = [255, 160, 0];
/// Places of the lid, of the body, and of a screen without the window.
const LID: [i16; 2] = [445, 322];
const BODY: [i16; 2] = [520, 412];
const BESIDE: [i16; 2] = [1270, 1020];

/// The program in a window. It is killed if a test fails before it ends.
struct Workshop {
    process: Child,
    log: std::path::PathBuf,
}

impl Workshop {
    fn start(scratch: &Scratch, server: &Xvfb, arguments: &[&str]) -> Self {
        let line = ["--device", "llvmpipe", "--validation", "sync", "--report", "report.json"];
        let mut command = program(WORKSHOP, &scratch.0, &[&line, arguments].concat());
        command.env("DISPLAY", server.display()).env("RUST_LOG", "workshop=info,winit=error");
        command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        let log = scratch.0.join("log");
        command.stdout(Stdio::null()).stderr(fs::File::create(&log).unwrap());
        Self { process: command.spawn().unwrap(), log }
    }

    fn await_text(&self, text: &str) {
        let began = Instant::now();
        loop {
            let log = fs::read_to_string(&self.log).unwrap();
            if log.contains(text) {
                return;
            }
            assert!(began.elapsed() < Duration::from_secs(60), "never said {text}: {log}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits for its end, and returns the steps of its report.
    fn end(mut self, scratch: &Scratch) -> Vec<Value> {
        let status = self.process.wait().unwrap();
        assert!(status.success(), "{status}: {}", fs::read_to_string(&self.log).unwrap());
        let text = fs::read_to_string(scratch.0.join("report.json")).unwrap();
        let report: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(report["validation_messages"], 0, "{text}");
        report["steps"].as_array().unwrap().clone()
    }
}

impl Drop for Workshop {
    fn drop(&mut self) {
        let _is_over = self.process.kill();
        let _is_over = self.process.wait();
    }
}

fn has_colour(found: &[[u8; 3]], colour: [u8; 3]) -> bool {
    let is_near = |pixel: &[u8; 3]| pixel.iter().zip(colour).all(|(a, b)| a.abs_diff(b) <= 6);
    found.iter().filter(|pixel| is_near(pixel)).count() > 50
}

#[test]
fn the_pointer_hovers_selects_opens_the_lid_and_cuts() {
    let server = Xvfb::start();
    let scratch = Scratch::new("workshop-window");
    fs::write(scratch.0.join("script"), "image expected.png\n").unwrap();
    let size = format!("{}x{}", SIZE[0], SIZE[1]);
    let line = ["--headless", "--script", "script", "--size", &size, "--device", "llvmpipe"];
    let output = program(WORKSHOP, &scratch.0, &line).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let expected = pixels(&scratch.0.join("expected.png"));

    let workshop = Workshop::start(&scratch, &server, &["--size", &size]);
    let window = Seen::wait_for(&server);
    window.point_at(BESIDE);
    window.await_that("a panel", |found| found[..200] != expected[..200]);
    // No step of the report: it is a shortcut of others.
    window.press_with(CONTROL, 's'.into());
    window.strike('t'.into());
    // The cube stays, in the upper right.
    let left = |image: &[[u8; 3]]| -> Vec<[u8; 3]> {
        image.chunks(SIZE[0]).flat_map(|row| row[..600].to_vec()).collect()
    };
    let expected = left(&expected);
    window.await_that("the image of a script", |found| left(found) == expected);
    window.point_at(BODY);
    window.await_that("what is below the pointer", |found| has_colour(found, HOVERED));
    window.strike('k'.into());
    workshop.await_text("image: Image");
    let image = pixels(&scratch.0.join("workshop.png"));
    assert!(left(&image) == expected, "images have no outline of what is hovered");
    window.click(LEFT);
    workshop.await_text("select: Selected([\"body\"])");
    window.point_at(BESIDE);
    window.await_that("what is selected", |found| has_colour(found, SELECTED));
    window.strike(ESCAPE);
    workshop.await_text("deselect: Done");

    window.point_at(LID);
    window.button(LEFT, BUTTON_PRESS_EVENT);
    window.move_by(30, [0, -4]);
    workshop.await_text("lid: Lid(");
    window.button(LEFT, BUTTON_RELEASE_EVENT);
    window.strike('x'.into());
    workshop.await_text("section: Done");
    window.await_that("an open lid, cut", |found| left(found) != expected);
    window.close();
    let steps = workshop.end(&scratch);
    let verbs: Vec<&str> = steps.iter().map(|step| step["command"].as_str().unwrap()).collect();
    assert_eq!(verbs, ["image", "select", "deselect", "lid", "section"], "{steps:#?}");
    let degrees = steps[3]["lid"]["degrees"].as_f64().unwrap();
    assert!(degrees > 5.0, "120 pixels upwards: {degrees}");
}

#[test]
fn small_windows_and_large_models_are_shown_and_closed() {
    let server = Xvfb::start();
    let scratch = Scratch::new("workshop-small");
    let arguments = ["assembly", "--parts", "2000", "--size", "300x200"];
    let workshop = Workshop::start(&scratch, &server, &arguments);
    let window = Seen::wait_for(&server);
    window.point_at(BESIDE);
    let is_shown = |found: &[[u8; 3]]| found.iter().any(|pixel| *pixel != found[0]);
    window.await_that("a model", is_shown);
    let first = window.pixels().unwrap();
    for key in ['t'.into(), F1] {
        let before = window.pixels().unwrap();
        window.strike(key);
        window.await_that("a panel or a page", |found| found != before);
    }
    window.strike(ESCAPE);
    window.strike('t'.into());
    window.await_pixels(&first, "the model alone");
    for size in [[1, 1], [801, 77], [300, 200]] {
        window.resize(size);
        std::thread::sleep(Duration::from_millis(300));
    }
    window.await_pixels(&first, "the model as it was");
    window.close();
    assert!(workshop.end(&scratch).is_empty());
}
