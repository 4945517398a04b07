//! Keys and the mouse in the window of `city`, on an X server without a screen.

use std::process::Command;
use std::time::Duration;

use crate::running::{ESCAPE, Running, SIZE, TAB, headless, of_colour};
use harness::{Scratch, pixels, program};
use tests::weston::Weston;
use tests::x11_screen::{BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, Seen};
use tests::xvfb::Xvfb;

const F1: u32 = 0xffbe;
const F11: u32 = 0xffc8;
const CYRILLIC_A: u32 = 0x6c1;
const CONTROL: u32 = 0xffe3;
const DOWN: u32 = 0xff54;
const RETURN: u32 = 0xff0d;
const MARK: [u8; 3] = [250, 210, 90];
const STRIKE: Duration = Duration::from_millis(20);

/// Sets the server's layout to one in which no letter is Latin.
fn use_russian(server: &Xvfb) {
    let status =
        Command::new("setxkbmap").args(["-display", server.display(), "ru"]).status().unwrap();
    assert!(status.success(), "setxkbmap: {status}");
}

#[test]
fn letters_do_the_same_in_a_layout_without_latin_ones() {
    let server = Xvfb::start();
    let scratch = Scratch::new("keys-russian");
    let running = Running::city(&scratch, &server, &[]);
    let window = Seen::wait_for(&server);
    let codes = ['f', 'p'].map(|letter| window.code_of(letter.into()));
    use_russian(&server);
    assert_eq!(window.code_of(CYRILLIC_A), codes[0], "the key F writes no Latin letter");
    for (code, said) in [(codes[0], "3 frames in flight"), (codes[1], "present mode fifo_relaxed")]
    {
        window.press_code(code, STRIKE);
        running.await_text(said);
    }
    window.close();
    running.end_well();
}

#[test]
fn help_lists_the_keys_and_escape_closes_it() {
    let server = Xvfb::start();
    let scratch = Scratch::new("keys-help");
    let arguments = ["--hud", "off", "--size", "1280x720"];
    let expected = headless(&scratch, &["--size", "1280x720"]);
    let running = Running::city(&scratch, &server, &arguments);
    let window = Seen::wait_for(&server);
    window.await_pixels(&expected, "the image");
    window.strike(F1);
    window.await_that("all keys", |found| of_colour(found, MARK) > 100);
    window.strike(ESCAPE);
    window.await_pixels(&expected, "the image without them");
    assert!(!running.log().contains("Esc again"), "{}", running.log());
    window.close();
    running.end_well();
}

#[test]
fn a_row_of_a_list_is_chosen_by_a_click() {
    let server = Xvfb::start();
    let scratch = Scratch::new("keys-click");
    let running = Running::city(&scratch, &server, &["--hud", "off", "--size", "1280x720"]);
    let window = Seen::wait_for(&server);
    window.point_at([60, 692]);
    window.strike('u'.into());
    window.await_that("a list", |found| of_colour(found, MARK) > 20);
    window.click(1);
    running.await_text("strategy antumbra_");
    window.await_that("no list", |found| of_colour(found, MARK) == 0);
    assert!(!running.log().contains("object"), "{}", running.log());
    window.close();
    running.end_well();
}

#[test]
fn the_title_says_scene_strategy_and_rate() {
    let server = Xvfb::start();
    let scratch = Scratch::new("keys-title");
    let running = Running::city(&scratch, &server, &["--scene", "field"]);
    let window = Seen::wait_for(&server);
    window.await_title(|title| {
        title.starts_with("field - antumbra - ") && title.ends_with(" frames/s - Antumbra")
    });
    window.strike(TAB);
    window.await_title(|title| title.starts_with("field - antumbra_queries - "));
    window.close();
    running.end_well();
}

#[test]
fn the_mouse_looks_while_held_and_while_captured() {
    let server = Xvfb::start();
    let scratch = Scratch::new("keys-mouse");
    let expected = headless(&scratch, &["--size", SIZE]);
    let running = Running::city(&scratch, &server, &["--hud", "off"]);
    let window = Seen::wait_for(&server);
    window.await_pixels(&expected, "the image");
    window.focus();
    window.point_at([100, 90]);
    window.move_by(10, [3, 0]);
    window.await_pixels(&expected, "the same while no button is held");
    window.button(1, BUTTON_PRESS_EVENT);
    window.move_by(10, [3, 0]);
    window.await_that("another view", |found| found != expected);
    let held = window.pixels().unwrap();
    window.button(1, BUTTON_RELEASE_EVENT);
    std::thread::sleep(Duration::from_millis(100));
    assert!(window.is_pointer_free(), "released, it is free");
    // Captured by a click of the right button: it looks on without a button, until Esc.
    window.click(3);
    running.await_text("the mouse is captured; Esc frees it");
    assert!(!window.is_pointer_free(), "captured, it stays in the window");
    window.move_by(10, [0, 3]);
    window.await_that("one more view", |found| found != held && found != expected);
    window.strike(ESCAPE);
    let began = std::time::Instant::now();
    while !window.is_pointer_free() {
        assert!(began.elapsed() < Duration::from_secs(60), "it stays captured");
        std::thread::sleep(STRIKE);
    }
    assert!(!running.log().contains("Esc again"), "the first Esc frees it: {}", running.log());
    window.strike(ESCAPE);
    running.await_text("press Esc again to quit");
    window.strike(ESCAPE);
    running.end_well();
}

#[test]
fn the_wheel_says_how_fast() {
    let server = Xvfb::start();
    let scratch = Scratch::new("keys-wheel");
    let running = Running::city(&scratch, &server, &[]);
    let window = Seen::wait_for(&server);
    window.point_at([100, 90]);
    window.click(4);
    running.await_text("speed 5.00 m/s");
    window.close();
    running.end_well();
}

/// Checks that full screen is asked for and left; the test is the window manager.
#[test]
fn full_screen_and_back() {
    let server = Xvfb::start();
    let scratch = Scratch::new("keys-full");
    let running = Running::city(&scratch, &server, &["--hud", "off"]);
    let window = Seen::wait_for(&server);
    window.await_pixels(&headless(&scratch, &["--size", SIZE]), "the image");
    window.manage();
    window.strike(F11);
    assert!(window.await_full_screen());
    window.resize([1280, 1024]);
    window.await_pixels(&headless(&scratch, &["--size", "1280x1024"]), "the large image");
    window.strike(F11);
    assert!(!window.await_full_screen());
    window.close();
    running.end_well();
}

#[test]
fn a_compositor_gives_the_full_screen() {
    let compositor = Weston::start();
    let scratch = Scratch::new("keys-full-wayland");
    std::fs::write(scratch.0.join("script"), "5 full_screen\n30 screenshot\n40 quit\n").unwrap();
    let arguments = ["--objects", "500", "--size", SIZE, "--device", "llvmpipe", "--hud", "off"];
    let rest = ["--script", "script", "--out", "shots", "--validation", "sync"];
    let arguments = [&arguments[..], &rest].concat();
    let mut command = program(crate::CITY, &scratch.0, &arguments);
    compositor.environment(&mut command);
    Running::start(command, &scratch).end_well();
    let shot = scratch.0.join("shots/city_00030.png");
    assert_eq!(pixels(&shot).len(), 1024 * 640, "the whole output");
}

#[test]
fn a_strategy_is_chosen_from_a_list() {
    let server = Xvfb::start();
    let scratch = Scratch::new("keys-strategies");
    let running = Running::city(&scratch, &server, &[]);
    let window = Seen::wait_for(&server);
    window.await_title(|title| title.contains("antumbra"));
    // Tab in the list is no next strategy; Esc closes it and asks nothing.
    [('u'.into()), TAB, ESCAPE].into_iter().for_each(|key| window.strike(key));
    [('u'.into()), DOWN, RETURN].into_iter().for_each(|key| window.strike(key));
    running.await_text("strategy antumbra_queries");
    ['u', '1'].into_iter().for_each(|key| window.strike(key.into()));
    running.await_text("strategy frustum");
    let log = running.log();
    assert!(log.matches("strategy ").count() == 2 && !log.contains("Esc again"), "{log}");
    window.close();
    running.end_well();
}

#[test]
fn a_scene_is_chosen_from_a_list_or_by_its_path() {
    let server = Xvfb::start();
    let scratch = Scratch::new("keys-scenes");
    std::fs::write(scratch.0.join("broken.glb"), "no glTF").unwrap();
    let running = Running::city(&scratch, &server, &["--cost-model", "off"]);
    let window = Seen::wait_for(&server);
    window.await_title(|title| title.starts_with("city - "));
    // The fifth row is the file in the working folder.
    ['o', '5'].into_iter().for_each(|key| window.strike(key.into()));
    running.await_text("broken.glb cannot be shown: ");
    window.press_with(CONTROL, 'o'.into());
    "missing.glb".chars().for_each(|letter| window.strike(letter.into()));
    window.strike(RETURN);
    running.await_text("missing.glb cannot be shown: ");
    window.press_with(CONTROL, 'o'.into());
    window.paste(CONTROL, "file:///nowhere/copied%20\u{e4}.glb");
    window.strike(RETURN);
    running.await_text("/nowhere/copied \u{e4}.glb: file: it cannot be read: ");
    ['o', '2'].into_iter().for_each(|key| window.strike(key.into()));
    window.await_title(|title| title.starts_with("field - "));
    window.close();
    running.end_well();
}

#[test]
fn a_click_says_what_an_object_is() {
    let server = Xvfb::start();
    let scratch = Scratch::new("keys-click");
    let expected = headless(&scratch, &["--size", SIZE]);
    let running = Running::city(&scratch, &server, &["--hud", "off"]);
    let window = Seen::wait_for(&server);
    window.await_pixels(&expected, "the image");
    window.point_at([160, 120]);
    window.click(1);
    running.await_text("decision: drawn: taken as visible");
    window.await_that("its outline", |found| found != expected);
    // The sky is no object.
    window.point_at([160, 2]);
    window.click(1);
    running.await_text("there is no object");
    window.await_pixels(&expected, "the image without it");
    window.close();
    running.end_well();
}

#[test]
fn a_key_compares_with_no_culling() {
    let server = Xvfb::start();
    let scratch = Scratch::new("keys-compare");
    let expected = headless(&scratch, &["--size", SIZE]);
    let running = Running::city(&scratch, &server, &["--hud", "off"]);
    let window = Seen::wait_for(&server);
    window.await_pixels(&expected, "the image");
    window.strike('v'.into());
    // With and without culling the image is the same; the text over its lower half is not.
    let half = expected.len() / 2;
    window.await_that("what is compared", |found| {
        found[..half] == expected[..half] && of_colour(found, MARK) > 0
    });
    // Each frame is drawn twice.
    window.await_title(|title| title.ends_with(" pairs/s - Antumbra"));
    // The camera moves meanwhile.
    window.press('d'.into(), Duration::from_millis(500));
    window.strike('v'.into());
    running.await_text("antumbra: 0 pixels differ in ");
    window.close();
    running.end_well();
}
