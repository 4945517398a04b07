//! Runs the programs for Windows under Wine, in windows of an X server without a screen.
//! `ci/windows` builds them, prepares Wine, and sets the two variables.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::running::{Running, headless};
use harness::{Scratch, pixels, program, scene, stderr};
use tests::x11_screen::Seen;
use tests::xvfb::Xvfb;

/// The folder of the programs.
const PROGRAMS: &str = "ANTUMBRA_WINDOWS_PROGRAMS";
/// The folder for images of their windows.
const RESULTS: &str = "ANTUMBRA_WINDOWS_RESULTS";
const SIZE: &str = "640x360";
const RESIZED: [u32; 2] = [800, 500];

fn folder(variable: &str) -> PathBuf {
    let folder = std::env::var_os(variable);
    folder.unwrap_or_else(|| panic!("{variable} is not set: run ci/windows")).into()
}

fn save(window: &Seen, size: [u32; 2], file: &Path) {
    let [width, height] = size;
    let pixels = window.pixels().expect("the window is on the screen");
    let mut encoder = png::Encoder::new(File::create(file).unwrap(), width, height);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(pixels.as_flattened()).unwrap();
}

/// Returns true if an image has this size and several colours, and something in its last row.
fn is_drawn(pixels: &[[u8; 3]], size: [u32; 2]) -> bool {
    let [width, height] = size;
    let pixel_count = (width * height) as usize;
    let last_row = || &pixels[pixel_count - width as usize..];
    let is_black = |pixel: &[u8; 3]| *pixel == [0; 3];
    pixels.len() == pixel_count
        && !last_row().iter().all(is_black)
        && pixels.iter().any(|pixel| *pixel != pixels[0])
}

/// Writes a scene, and a script in which nothing moves.
fn write_scene(scratch: &Scratch) {
    std::fs::write(scratch.0.join("small.glb"), scene::small()).unwrap();
    std::fs::write(scratch.0.join("script"), "0 pause\n").unwrap();
}

/// Starts a program, waits until its window is right, resizes and closes it.
fn open_resize_and_close(
    server: &Xvfb,
    name: &str,
    arguments: &[&str],
    size: [u32; 2],
    is_right: impl Fn(&[[u8; 3]]) -> bool,
) {
    let scratch = Scratch::new(&format!("wine-{name}"));
    write_scene(&scratch);
    let file = folder(PROGRAMS).join(name).with_extension("exe");
    let all = [&[file.to_str().unwrap()], arguments].concat();
    let running = Running::show(program("wine", &scratch.0, &all), &scratch, server);
    let window = Seen::wait_for_size(server, size.map(|side| side as u16));
    window.await_that("its image", |found| is_drawn(found, size) && is_right(found));
    save(&window, size, &folder(RESULTS).join(format!("{name}.png")));
    window.resize(RESIZED);
    window.await_that("an image of the new size", |found| is_drawn(found, RESIZED));
    // The image after the resize may be the old one, stretched.
    std::thread::sleep(Duration::from_secs(1));
    save(&window, RESIZED, &folder(RESULTS).join(format!("{name}_resized.png")));
    window.close();
    running.end_well();
}

#[test]
#[ignore = "needs Wine and the programs for Windows: `ci/windows` has both"]
fn programs_for_windows_open_resize_and_close() {
    // Wine's own desktop process stays with the display that it began with.
    let server = Xvfb::start();
    let linux = Scratch::new("wine-linux");
    let expected = headless(&linux, &["--size", SIZE]);
    let size = [640, 360];
    let line = ["--size", SIZE, "--device", "llvmpipe"];
    let city = [&line[..], &["--objects", "500", "--cost-model", "off", "--hud", "off"]].concat();
    open_resize_and_close(&server, "city", &city, size, |found| *found == expected);
    write_scene(&linux);
    let viewer = ["small.glb", "--camera", "still", "--script", "script", "--hud", "off"];
    let viewer = [&line[..], &viewer].concat();
    let mut command = program(crate::VIEWER, &linux.0, &viewer);
    let output = command.args(["--headless", "--frames", "2", "--out", "viewer"]).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let expected = pixels(&linux.0.join("viewer/frame_00001.png"));
    open_resize_and_close(&server, "viewer", &viewer, size, |found| *found == expected);
    open_resize_and_close(&server, "shadows", &line, size, |_| true);
    open_resize_and_close(&server, "workshop", &line, size, |_| true);
    // The size of a window that asks for none.
    open_resize_and_close(&server, "triangle", &[], [800, 600], |_| true);
}

#[test]
#[ignore = "needs Wine and the programs for Windows: `ci/windows` has both"]
fn images_are_those_of_linux() {
    let server = Xvfb::start();
    let scratch = Scratch::new("wine-images");
    let exe = folder(PROGRAMS).join("city.exe");
    let line = ["--headless", "--objects", "500", "--device", "llvmpipe", "--cost-model", "off"];
    let line = [&line[..], &["--frames", "12", "--size", "320x180"]].concat();
    for path in ["street", "fly"] {
        let line = [&line[..], &["--path", path]].concat();
        let on_linux = format!("{path}-linux");
        let on_windows = format!("{path}-windows");
        let linux = [&line[..], &["--out", &on_linux]].concat();
        let windows = [&[exe.to_str().unwrap()], &line[..], &["--out", &on_windows]].concat();
        for (name, arguments) in [(crate::CITY, linux), ("wine", windows)] {
            let mut command = program(name, &scratch.0, &arguments);
            let output = command.env("DISPLAY", server.display()).output().unwrap();
            assert!(output.status.success(), "{}", stderr(&output));
        }
        let names = scratch.names(&on_linux);
        assert_eq!((names.len(), &names), (12, &scratch.names(&on_windows)));
        for name in &names {
            let image = |folder: &str| pixels(&scratch.0.join(folder).join(name));
            assert!(image(&on_windows) == image(&on_linux), "{path}: {name} is another image");
        }
    }
}
