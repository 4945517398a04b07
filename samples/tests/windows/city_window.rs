//! Runs `city` and `triangle` in windows of an X server without a screen, and of a Wayland
//! compositor.

use std::fs;
use std::process::Command;
use std::time::Duration;

use crate::running::{ESCAPE, Running, SIZE, TAB, headless, of_colour};
use harness::{Scratch, pixels, program};
use tests::weston::Weston;
use tests::x11_screen::Seen;
use tests::xvfb::Xvfb;

/// The colour of the sign over an image while the path is recorded.
const RECORDING: [u8; 3] = [255, 70, 60];

#[test]
fn the_window_shows_what_is_drawn_without_one_in_every_mode() {
    let server = Xvfb::start();
    let scratch = Scratch::new("window-right");
    for (device, modes) in [
        ("llvmpipe", &["fifo", "fifo_relaxed", "mailbox", "immediate"][..]),
        ("SwiftShader", &["fifo", "mailbox"]),
    ] {
        let expected = headless(&scratch, &["--size", SIZE, "--device", device]);
        for mode in modes {
            let arguments = ["--device", device, "--hud", "off", "--present-mode", mode];
            let running = Running::city(&scratch, &server, &arguments);
            let window = Seen::wait_for(&server);
            window.await_pixels(&expected, "the image");
            window.close();
            running.end_well();
        }
    }
}

#[test]
fn keys_do_what_they_say() {
    let server = Xvfb::start();
    let scratch = Scratch::new("window-keys");
    let expected = headless(&scratch, &["--size", SIZE]);
    let running = Running::city(&scratch, &server, &["--out", "shots"]);
    let window = Seen::wait_for(&server);
    window.await_that("a text", |found| found != expected && of_colour(found, [235, 240, 245]) > 0);
    // First all details, then nothing.
    window.strike('h'.into());
    window.strike('h'.into());
    window.await_pixels(&expected, "the image without text");
    for (key, said) in [
        (TAB, "strategy antumbra_queries"),
        ('f'.into(), "3 frames in flight"),
        ('p'.into(), "present mode fifo_relaxed"),
        ('k'.into(), "wrote shots/city_"),
    ] {
        window.strike(key);
        running.await_text(said);
        window.await_pixels(&expected, "the same image");
    }
    for key in ['b', 'x', 'g', 'c'] {
        window.strike(key.into());
        window.await_that(&format!("what {key} does"), |found| found != expected);
        window.strike(key.into());
        window.await_pixels(&expected, "the image as it was");
    }
    window.strike('r'.into());
    running.await_text("recording the path");
    window.await_that("a sign without text", |found| of_colour(found, RECORDING) > 0);
    window.press('w'.into(), Duration::from_millis(300));
    window.strike('r'.into());
    window
        .await_that("another place", |found| of_colour(found, RECORDING) == 0 && found != expected);
    running.await_text(" frames in shots/path_");
    let shot = scratch.names("shots").into_iter().find(|name| name.ends_with(".png")).unwrap();
    assert!(pixels(&scratch.0.join("shots").join(shot)) == expected, "a screenshot shows it");
    window.strike(ESCAPE);
    running.await_text("press Esc again to quit");
    window.strike(ESCAPE);
    running.end_well();
}

/// Checks that errors are shown without the HUD, too, and disappear.
#[test]
fn what_cannot_be_is_told_without_the_hud() {
    let server = Xvfb::start();
    let scratch = Scratch::new("window-told");
    let expected = headless(&scratch, &["--size", SIZE]);
    fs::write(scratch.0.join("script"), "3 strategy hzb\n").unwrap();
    let running = Running::city(&scratch, &server, &["--hud", "off", "--script", "script"]);
    let window = Seen::wait_for(&server);
    window.await_pixels(&expected, "the image without a text");
    window.strike('x'.into());
    let mark = [250, 210, 90];
    window.await_that("what cannot be explained", |found| of_colour(found, mark) > 0);
    window.await_that("a notice alone", |found| found[..320 * 90] == expected[..320 * 90]);
    window.await_pixels(&expected, "the image without it again");
    window.close();
    running.end_well();
}

#[test]
fn the_image_follows_the_window() {
    let server = Xvfb::start();
    let scratch = Scratch::new("window-sizes");
    let running = Running::city(&scratch, &server, &["--hud", "off"]);
    let window = Seen::wait_for(&server);
    for size in [[200, 300], [1, 1], [801, 77], [320, 180]] {
        let expected = headless(&scratch, &["--size", &format!("{}x{}", size[0], size[1])]);
        window.resize(size);
        window.await_pixels(&expected, &format!("the image of {size:?}"));
    }
    let mut seed = 1_u32;
    for _ in 0..200 {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        window.resize([1 + (seed >> 8) % 500, 1 + (seed >> 20) % 300]);
        if seed.is_multiple_of(16) {
            window.hide();
            std::thread::sleep(Duration::from_millis(30));
            window.show();
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    window.resize([320, 180]);
    window.await_pixels(&headless(&scratch, &["--size", SIZE]), "the image at last");
    window.close();
    running.end_well();
}

#[test]
fn a_window_that_is_destroyed_is_a_good_end() {
    let server = Xvfb::start();
    let scratch = Scratch::new("window-destroyed");
    let running = Running::city(&scratch, &server, &["--hud", "off"]);
    let window = Seen::wait_for(&server);
    let expected = headless(&scratch, &["--size", SIZE]);
    window.await_pixels(&expected, "the image");
    window.destroy();
    running.end_well();
}

#[test]
fn a_display_that_dies_leaves_the_trace() {
    let server = Xvfb::start();
    let scratch = Scratch::new("window-display");
    let running = Running::city(&scratch, &server, &["--hud", "off", "--trace", "trace.json"]);
    let window = Seen::wait_for(&server);
    window.await_pixels(&headless(&scratch, &["--size", SIZE]), "the image");
    drop((window, server));
    running.end_well();
    let trace = std::fs::read_to_string(scratch.0.join("trace.json")).unwrap();
    assert!(trace.contains("\"render\""), "{} bytes", trace.len());
}

/// Checks that the image survives 300 changes, one before each frame.
#[test]
fn whatever_is_switched_the_image_stays() {
    let server = Xvfb::start();
    let scratch = Scratch::new("window-switches");
    let expected = headless(&scratch, &["--size", SIZE]);
    let strategies = [
        "frustum",
        "naive",
        "batched",
        "stop_and_wait",
        "chc",
        "hzb",
        "antumbra",
        "antumbra_queries",
        "antumbra_flags",
        "antumbra_compute",
    ];
    let modes = ["fifo", "fifo_relaxed", "mailbox", "immediate"];
    let mut script = String::new();
    let mut seed = 7_u32;
    for frame in 0..300 {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let number = (seed >> 16) as usize;
        script += &match frame % 3 {
            0 => format!("{frame} strategy {}\n", strategies[number % strategies.len()]),
            1 => format!("{frame} frames_in_flight {}\n", number % 4 + 1),
            _ => format!("{frame} present_mode {}\n", modes[number % modes.len()]),
        };
        if frame % 75 == 74 {
            script += &format!("{frame} screenshot\n");
        }
    }
    fs::write(scratch.0.join("script"), script).unwrap();
    let arguments = ["--hud", "off", "--script", "script", "--out", "shots"];
    let running = Running::city(&scratch, &server, &arguments);
    let window = Seen::wait_for(&server);
    running.await_text("city_00299.png");
    window.await_pixels(&expected, "the image");
    for shot in scratch.names("shots") {
        assert!(pixels(&scratch.0.join("shots").join(&shot)) == expected, "{shot} is another");
    }
    window.close();
    running.end_well();
}

/// Checks that the statistics at the end are of the newest conditions alone.
#[test]
fn statistics_start_anew_with_another_strategy_or_size() {
    let server = Xvfb::start();
    let scratch = Scratch::new("window-statistics");
    for change in ["60 strategy frustum\n", "60 frames_in_flight 3\n"] {
        fs::write(scratch.0.join("script"), change).unwrap();
        let mut running =
            Running::city(&scratch, &server, &["--script", "script", "--frames", "80"]);
        let status = running.end();
        let log = running.log();
        assert!(status.success(), "{status}: {log}");
        let frames = log.split("of the last ").nth(1).and_then(|rest| rest.split(' ').next());
        let frames: u32 = frames.unwrap().parse().unwrap();
        assert!((5..20).contains(&frames), "{change}: {frames} frames: {log}");
    }
}

/// Checks that each step means the next mode, although no image followed yet.
#[test]
fn two_steps_in_one_frame_are_two_present_modes() {
    let server = Xvfb::start();
    let scratch = Scratch::new("window-steps");
    fs::write(scratch.0.join("script"), "10 present_mode\n10 present_mode\n").unwrap();
    let mut running = Running::city(&scratch, &server, &["--script", "script", "--frames", "20"]);
    let status = running.end();
    let log = running.log();
    assert!(status.success(), "{status}: {log}");
    assert!(log.contains("present mode fifo_relaxed") && log.contains("present mode mailbox"));
}

#[test]
fn a_signal_closes_the_window() {
    let server = Xvfb::start();
    let scratch = Scratch::new("window-signal");
    fs::write(scratch.0.join("script"), "0 record\n2 screenshot\n").unwrap();
    let mut running = Running::city(&scratch, &server, &["--script", "script", "--out", "out"]);
    running.await_text("wrote out/city_00002.png");
    let process = rustix::process::Pid::from_child(&running.process);
    rustix::process::kill_process(process, rustix::process::Signal::TERM).unwrap();
    let status = running.end();
    let log = running.log();
    assert_eq!(status.code(), Some(143), "{status}: {log}");
    assert!(log.contains(" frames in out/path_"), "{log}");
}

#[test]
fn it_runs_under_wayland() {
    let compositor = Weston::start();
    let scratch = Scratch::new("window-wayland");
    // The driver has two modes there, and takes them for the others.
    let immediate = "this window has no immediate; it is mailbox instead";
    let relaxed = "this window has no fifo_relaxed; it is fifo instead";
    for (mode, said) in
        [("mailbox", ""), ("fifo", ""), ("immediate", immediate), ("fifo_relaxed", relaxed)]
    {
        let small = ["--objects", "500", "--size", SIZE, "--device", "llvmpipe"];
        let rest = ["--frames", "30", "--validation", "sync", "--present-mode", mode];
        let arguments = [small, rest].concat();
        let mut command = program(crate::CITY, &scratch.0, &arguments);
        compositor.environment(&mut command);
        command.env("RUST_LOG", "samples=info,winit=error");
        let mut running = Running::start(command, &scratch);
        let status = running.end();
        let log = running.log();
        assert!(status.success() && log.contains(said), "{mode}: {status}: {log}");
        let counted = log.contains("of the last 2") || log.contains("of the last 3");
        let is_measured = log.contains("frame, median ") && !log.contains("frame, median -");
        assert!(counted && is_measured, "{mode}: the times of frames are missing: {log}");
    }
}

/// Checks that a variable of a terminated compositor does not hide the display that exists.
#[test]
fn a_stale_wayland_display_falls_back_to_x11() {
    let server = Xvfb::start();
    let scratch = Scratch::new("window-stale");
    let small = ["--objects", "500", "--size", SIZE, "--device", "llvmpipe", "--frames", "3"];
    let mut command = program(crate::CITY, &scratch.0, &small);
    command.env("DISPLAY", server.display()).env("WAYLAND_DISPLAY", "wayland-of-yesterday");
    command.env("XDG_RUNTIME_DIR", &scratch.0).env_remove("WAYLAND_SOCKET");
    Running::start(command, &scratch).end_well();
}

#[test]
fn the_triangle_opens_a_window_and_closes_it() {
    let server = Xvfb::start();
    let scratch = Scratch::new("window-triangle");
    let mut command = Command::new(crate::TRIANGLE);
    command.env("DISPLAY", server.display()).env_remove("WAYLAND_DISPLAY");
    let running = Running::start(command, &scratch);
    let window = Seen::wait_for(&server);
    let is_red = |pixel: &[u8; 3]| pixel[0] > 150 && pixel[1] < 100 && pixel[2] < 100;
    window.await_that("a red corner", |found| found.iter().any(is_red));
    // In windows of any shape it is as high as the window wants, and as wide as it is high.
    for size in [[900, 300], [500, 500], [640, 360]] {
        window.resize(size);
        window.await_that("a triangle in proportion", |found| {
            let drawn = |place: &usize| found[*place] != found[0];
            let drawn: Vec<usize> = (0..found.len()).filter(drawn).collect();
            let side = |coordinate: fn(usize, usize) -> usize| {
                let all = drawn.iter().map(|place| coordinate(*place, size[0] as usize));
                let least = all.clone().min();
                let most = all.max();
                most.zip(least).map_or(0, |(most, least)| most + 1 - least) as f64
            };
            let width = side(|place, row| place % row);
            let height = side(|place, row| place / row);
            // It is 2 wide and 1.7 high, 3 away, and the image shows 0.9 rad.
            let expected = f64::from(size[1]) * 1.7 / (6.0 * 0.45_f64.tan());
            (height - expected).abs() < 3.0 && (width * 1.7 - height * 2.0).abs() < 6.0
        });
    }
    window.close();
    running.end_well();
}

#[test]
fn a_triangle_that_cannot_be_drawn_in_a_window_is_no_success() {
    let server = Xvfb::start();
    let scratch = Scratch::new("window-no-triangle");
    let mut command = Command::new(crate::TRIANGLE);
    command.env("DISPLAY", server.display()).env_remove("WAYLAND_DISPLAY");
    command.env("VK_ADD_DRIVER_FILES", "").env("VK_DRIVER_FILES", "/nowhere.json");
    let mut running = Running::start(command, &scratch);
    let status = running.end();
    assert!(!status.success() && running.log().contains("triangle: "), "{}", running.log());
}
