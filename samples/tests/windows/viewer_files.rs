//! Runs `viewer` over files without a window: valid ones and bad ones.

use std::fs;
use std::ops::ControlFlow;
use std::process::Output;

use harness::{Scratch, pixels, program, scene, stderr};

use crate::VIEWER;

pub fn scratch(name: &str) -> Scratch {
    let scratch = Scratch::new(name);
    fs::write(scratch.0.join("small.glb"), scene::small()).unwrap();
    scratch
}

fn viewer(scratch: &Scratch, arguments: &[&str]) -> Output {
    let mut command = program(VIEWER, &scratch.0, arguments);
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command.output().expect("the program runs")
}

/// Returns true if two images are those of one view, of files with different nodes: one pixel of
/// them was seen to differ in the last place of a channel, so that is let pass.
fn is_same_view(one: &[[u8; 3]], other: &[[u8; 3]]) -> bool {
    let mut parts = one.iter().flatten().zip(other.iter().flatten());
    one.len() == other.len() && parts.all(|(a, b)| a.abs_diff(*b) <= 1)
}

#[test]
fn the_viewer_writes_images_of_what_moves() {
    let scratch = scratch("viewer-headless");
    let arguments = ["small.glb", "--headless", "--frames", "31", "--out", "out"];
    let rest = ["--camera", "still", "--size", "128x72", "--validation", "sync"];
    fs::write(
        scratch.0.join("script"),
        "10 pause\n20 step\n20 step\n20 step\n20 step\n25 camera 1\n26 camera 2\n",
    )
    .unwrap();
    let all = [&arguments[..], &rest, &["--script", "script", "--device", "llvmpipe"]].concat();
    let output = viewer(&scratch, &all);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let image = |frame: u32| pixels(&scratch.0.join(format!("out/frame_{frame:05}.png")));
    assert!(image(0) != image(9), "the door moves");
    assert!(image(10) == image(19), "time stands still");
    assert!(image(19) != image(20), "some steps");
    assert!(image(25) != image(24), "another camera");
    assert!(image(26) == image(24), "the first one again");

    let brighter = [&arguments[..5], &["dark"], &rest, &["--exposure", "0.25"]].concat();
    assert_eq!(viewer(&scratch, &brighter).status.code(), Some(0));
    let sum = |folder: &str| {
        let image = pixels(&scratch.0.join(folder).join("frame_00000.png"));
        image.iter().flatten().map(|part| u64::from(*part)).sum::<u64>()
    };
    assert!(sum("dark") < sum("out"));
    let sky = |folder: &str| pixels(&scratch.0.join(folder).join("frame_00000.png"))[64];
    assert!(sky("dark")[2] < sky("out")[2], "{:?} {:?}", sky("dark"), sky("out"));
}

#[test]
fn a_camera_whose_clip_plays_no_more_gives_way_to_a_view_of_everything() {
    let scratch = scratch("viewer-left");
    // First the camera's clip alone, then the door's.
    fs::write(scratch.0.join("script"), "1 camera 1\n2 next_clip\n3 next_clip\n").unwrap();
    fs::write(scratch.0.join("none.glb"), scene::small_without_cameras()).unwrap();
    let last = |file: &str, out: &str| {
        let arguments = [file, "--headless", "--frames", "31", "--out", out, "--script", "script"];
        let rest = ["--size", "128x72", "--device", "llvmpipe", "--hud", "off"];
        let output = viewer(&scratch, &[&arguments[..], &rest].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        pixels(&scratch.0.join(out).join("frame_00030.png"))
    };
    assert!(is_same_view(&last("small.glb", "seen"), &last("none.glb", "unseen")));
}

#[test]
fn the_first_camera_is_where_one_begins_unless_a_clip_has_it_before_a_wall() {
    let scratch = scratch("viewer-begin");
    fs::write(scratch.0.join("none.glb"), scene::small_without_cameras()).unwrap();
    fs::write(scratch.0.join("wall.glb"), scene::small_before_the_wall()).unwrap();
    fs::write(scratch.0.join("leaving.glb"), scene::small_leaving_the_wall()).unwrap();
    let seen = |arguments: &[&str], out: &str| {
        let rest = ["--headless", "--frames", "1", "--out", out, "--size", "128x72"];
        let mut command = program(VIEWER, &scratch.0, arguments);
        command.args(rest).args(["--device", "llvmpipe"]).env("RUST_LOG", "samples=info");
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (pixels(&scratch.0.join(out).join("frame_00000.png")), stderr(&output))
    };
    let hint = "a clip moves the file's first camera, walk: key 1 looks through it, 2 through";
    let (before, log) = seen(&["wall.glb"], "wall");
    assert!(log.contains(hint), "{log}");
    let (none, log) = seen(&["none.glb"], "none");
    assert!(is_same_view(&before, &none) && !log.contains("key 1"), "{log}");
    let (asked, log) = seen(&["wall.glb", "--camera", "walk"], "asked");
    assert!(asked != none && !log.contains("key 1"), "{log}");
    // One that leaves the wall: there, as soon as it has.
    let (left, log) = seen(&["leaving.glb"], "left");
    assert!(!is_same_view(&left, &none) && !log.contains("key 1"), "{log}");
    let (begun, _) = seen(&["leaving.glb", "--camera", "walk"], "begun");
    assert!(!is_same_view(&left, &begun), "right before the wall");
    let (clear, log) = seen(&["small.glb"], "clear");
    assert!(clear != none && !log.contains("key 1"), "{log}");
    assert!(clear == seen(&["small.glb", "--camera", "walk"], "clear-asked").0);
}

#[test]
fn without_a_display_the_viewer_says_so() {
    let scratch = scratch("viewer-no-display");
    let output = viewer(&scratch, &["small.glb"]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("no display") && message.contains("--headless"), "{message}");
}

/// Returns the message of a refusal: one line that names the file.
fn refusal(output: &Output) -> String {
    let message = stderr(output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.starts_with("error: ") && !message.contains("panicked"), "{message}");
    assert_eq!(message.lines().count(), 1, "one sentence: {message}");
    assert!(output.stdout.is_empty());
    message
}

#[test]
fn files_that_cannot_be_shown_end_with_2_and_what_the_walkthrough_says() {
    let scratch = scratch("viewer-mistakes");
    for file in scene::write_unreadable(&scratch.0) {
        let path = scratch.0.join(file);
        let read =
            bench::scene_file::load(&path, &Default::default(), &mut |_| ControlFlow::Continue(()));
        let path = path.to_str().unwrap();
        let output = viewer(&scratch, &[path, "--headless", "--size", "32x32", "--frames", "2"]);
        let Err(reason) = read else { panic!("{file} was read") };
        let reason = reason.to_string();
        assert_eq!(refusal(&output), format!("error: {reason}\n"));
        assert!(reason.contains(file), "{reason}");
    }
}

#[test]
fn a_camera_that_is_not_there_is_refused_with_those_that_are() {
    let scratch = scratch("viewer-no-camera");
    let viewed = viewer(&scratch, &["small.glb", "--headless", "--camera", "Still"]);
    assert!(refusal(&viewed).contains("did you mean 'still'?"));
}

#[test]
fn lamps_beyond_those_that_an_object_has_are_told() {
    let scratch = Scratch::new("viewer-lamps");
    fs::write(scratch.0.join("lamps.glb"), scene::small_with_lamps(17)).unwrap();
    let shown = ["lamps.glb", "--headless", "--frames=1", "--size=32x32", "--device=llvmpipe"];
    let told = stderr(&viewer(&scratch, &shown));
    assert!(told.contains(scene::LAMPS_NOTE), "{told}");
}

#[test]
fn of_little_that_shows_coarser_levels_are_drawn_and_a_key_says_so() {
    let scratch = Scratch::new("viewer-detail");
    fs::write(scratch.0.join("ball.glb"), scene::ball()).unwrap();
    let script =
        "5 identify\n9 detail_by_samples\n20 identify\n26 detail_by_samples\n31 identify\n";
    fs::write(scratch.0.join("script"), script).unwrap();
    let run = |more: &[&str]| {
        let all = ["ball.glb", "--headless", "--frames=40", "--size=128x72", "--device=llvmpipe"];
        let rest = ["--script", "script", "--validation", "sync"];
        let mut command = program(VIEWER, &scratch.0, &[&all[..], &rest, more].concat());
        let output = command.env("RUST_LOG", "samples=info").output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stderr(&output)
    };
    let triangles = |log: &str| -> Vec<u64> {
        let found = log.split("triangles: ").skip(1);
        found.map(|found| found.split(';').next().unwrap().trim().parse().unwrap()).collect()
    };
    let log = run(&["--detail", "0.1"]);
    assert!(log.contains("detail by visible samples of 1 objects, too"), "{log}");
    assert!(log.contains("detail by distance alone"), "{log}");
    let [by_distance, by_samples, again] = triangles(&log)[..] else { panic!("{log}") };
    assert!(by_samples < by_distance && by_distance == again, "{log}");
    let log = run(&["--detail", "0.1", "--detail-by-samples"]);
    assert_eq!(triangles(&log), [by_samples, by_distance, by_samples], "{log}");
    let log = run(&[]);
    assert!(log.contains("the scene has no levels of detail"), "{log}");
    assert_eq!(triangles(&log), [2208; 3], "{log}");
}
