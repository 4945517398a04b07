//! Runs `walkthrough` and `viewer` over scenes out of files: right ones, and what cannot be.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

#[path = "program/picture.rs"]
mod picture;
#[allow(dead_code, reason = "shared with the tests of walkthrough")]
mod program;
#[path = "program/scene.rs"]
mod scene;

use std::fs;
use std::process::Output;

use picture::pixels;
use program::{Scratch, program, stderr, walkthrough};
use serde_json::Value;

fn scratch(name: &str) -> Scratch {
    let scratch = Scratch::new(name);
    fs::write(scratch.0.join("small.glb"), scene::small()).unwrap();
    scratch
}

fn viewer(scratch: &Scratch, arguments: &[&str]) -> Output {
    let mut command = program(env!("CARGO_BIN_EXE_viewer"), &scratch.0, arguments);
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command.output().expect("the program runs")
}

/// A walk of which every frame is compared; its report.
fn walk(scratch: &Scratch, device: &str, more: &[&str]) -> Value {
    let small = ["--quiet", "--frames=24", "--size=128x72", "--validation=sync", "--verify=every"];
    let rest = ["--costs=ignored", "--scene=small.glb", "--report=report.json", "--device", device];
    let output = walkthrough(&scratch.0, &[&small[..], &rest, more].concat()).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = fs::read_to_string(scratch.0.join("report.json")).unwrap();
    serde_json::from_str(&report).unwrap()
}

#[test]
fn a_walk_through_a_file_is_exact_with_every_strategy_that_there_is() {
    for device in ["llvmpipe", "swiftshader"] {
        let scratch = scratch(&format!("scene-walk-{device}"));
        let report = walk(&scratch, device, &["--path=walk", "--strategy=all", "--out=pictures"]);
        assert_eq!(report["validation_messages"], 0);
        let runs = report["runs"].as_array().unwrap();
        let names: Vec<&str> = runs.iter().map(|run| run["strategy"].as_str().unwrap()).collect();
        for expected in ["frustum", "antumbra", "ideal", "pyramid"] {
            assert!(names.contains(&expected), "{device}: {names:?}");
        }
        for run in runs.iter().filter(|run| run["strategy"] != "next_frame") {
            assert_eq!(run["pixels_wrong"], 0, "{device}: {}", run["strategy"]);
            assert_eq!(run["frames_verified"], 24);
        }
        let file = &report["scene"]["file"];
        assert_eq!(report["scene"]["name"], "small.glb");
        assert_eq!(report["scene"]["objects"], 64);
        assert_eq!(report["scene"]["triangles"], 64 * 12);
        assert_eq!((&file["path"], &file["meshes"]), (&"small.glb".into(), &3.into()));
        assert_eq!(
            (&file["cameras"], &file["clips"], &file["playing"]),
            (&2.into(), &2.into(), &2.into())
        );
        assert!(file["load_ms"].as_f64().unwrap() > 0.0 && file["lights"].as_u64().is_some());
        assert_eq!(report["moving_objects"], 1, "the door");
        let names = scratch.names("pictures");
        assert!(names.contains(&"frame_00000.png".to_owned()), "{names:?}");
    }
}

#[test]
fn orthographic_cameras_are_exact_too_and_it_is_told_how_they_are_shown() {
    let parallel = serde_json::json!({
        "type": "orthographic",
        "orthographic": {"xmag": 8.0, "ymag": 4.5, "znear": 0.1, "zfar": 50.0},
    });
    for device in ["llvmpipe", "swiftshader"] {
        let scratch = Scratch::new(&format!("scene-parallel-{device}"));
        fs::write(scratch.0.join("small.glb"), scene::small_seen_by(&parallel)).unwrap();
        let report = walk(&scratch, device, &["--path=walk", "--strategy=all"]);
        assert_eq!(report["validation_messages"], 0);
        for run in report["runs"].as_array().unwrap() {
            if run["strategy"] != "next_frame" {
                assert_eq!(run["pixels_wrong"], 0, "{device}: {}", run["strategy"]);
                assert_eq!(run["frames_verified"], 24);
            }
        }
        let small = ["--quiet", "--frames=2", "--size=32x32", "--scene=small.glb", "--device"];
        let output = walkthrough(&scratch.0, &[&small[..], &[device]].concat()).output().unwrap();
        let told = String::from_utf8_lossy(&output.stdout).into_owned();
        let note = "orthographic cameras, shown by a narrow view from far away (2 times";
        assert!(told.contains(note), "{told}");
    }
}

#[test]
fn lamps_beyond_those_that_an_object_has_are_told() {
    let scratch = Scratch::new("scene-lamps");
    let small = scene::small();
    let length = u32::from_le_bytes(small[12..16].try_into().unwrap()) as usize;
    let (document, buffer) = (&small[20..20 + length], &small[28 + length..]);
    let mut document: Value = serde_json::from_slice(document).unwrap();
    document["extensionsUsed"] = serde_json::json!(["KHR_lights_punctual"]);
    document["extensions"] = serde_json::json!({
        "KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 5.0}]},
    });
    let nodes = document["nodes"].as_array_mut().unwrap();
    let first = nodes.len();
    let lamp = serde_json::json!({"extensions": {"KHR_lights_punctual": {"light": 0}}});
    nodes.extend(std::iter::repeat_n(lamp, 17));
    let count = nodes.len();
    document["scenes"][0]["nodes"].as_array_mut().unwrap().extend((first..count).map(Value::from));
    fs::write(scratch.0.join("lamps.glb"), scene::glb(&document, buffer)).unwrap();
    let note = "64 objects are reached by more than 16 lights: the weakest of them are left out";

    let small = ["--quiet", "--frames=2", "--size=32x32", "--scene=lamps.glb", "--device=llvmpipe"];
    let output = walkthrough(&scratch.0, &small).output().unwrap();
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(told.contains(&format!("not as in the file: {note}")), "{told}");
    let shown = ["lamps.glb", "--headless", "--frames=1", "--size=32x32", "--device=llvmpipe"];
    let told = stderr(&viewer(&scratch, &shown));
    assert!(told.contains(note), "{told}");
}

#[test]
fn scenes_of_blended_objects_alone_are_exact_with_every_strategy() {
    for device in ["llvmpipe", "swiftshader"] {
        let scratch = Scratch::new(&format!("scene-blended-{device}"));
        fs::write(scratch.0.join("small.glb"), scene::cards([0, 1])).unwrap();
        let report = walk(&scratch, device, &["--strategy=all"]);
        assert_eq!(
            (&report["validation_messages"], &report["scene"]["objects"]),
            (&0.into(), &0.into())
        );
        for run in report["runs"].as_array().unwrap() {
            assert_eq!(run["pixels_wrong"], 0, "{device}: {}", run["strategy"]);
        }
    }
}

/// The whole clip once from end to end, in however many frames.
#[test]
fn the_camera_goes_from_end_to_end_in_any_number_of_frames() {
    let scratch = scratch("scene-ends");
    let last = |frames: &str, out: &str| {
        let pictures = format!("--pictures={frames}");
        let frames = format!("--frames={frames}");
        let more = ["--path=walk", "--strategy=antumbra", &frames, &pictures, "--out", out];
        walk(&scratch, "llvmpipe", &more);
        let names = scratch.names(out);
        let name = names.iter().rfind(|name| name.starts_with("frame_")).unwrap().clone();
        let picture = |name: &str| pixels(&scratch.0.join(out).join(name));
        (picture("frame_00000.png"), picture(&name))
    };
    let (few, many) = (last("3", "few"), last("13", "many"));
    assert!(few.0 == many.0 && few.1 == many.1 && few.0 != few.1);
}

#[test]
fn without_a_name_it_is_the_first_camera_and_a_still_one_stands() {
    let scratch = scratch("scene-cameras");
    assert_eq!(walk(&scratch, "llvmpipe", &["--strategy=antumbra"])["path"], "walk");
    let more = ["--path=still", "--strategy=antumbra", "--out=still", "--pictures=24"];
    walk(&scratch, "llvmpipe", &more);
    let picture = |frame: u32| pixels(&scratch.0.join(format!("still/frame_{frame:05}.png")));
    // Only the door moves, sixty frames a second.
    assert!(picture(0) != picture(23));
}

#[test]
fn the_viewer_writes_pictures_of_what_moves() {
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
    let picture = |frame: u32| pixels(&scratch.0.join(format!("out/frame_{frame:05}.png")));
    assert!(picture(0) != picture(9), "the door moves");
    assert!(picture(10) == picture(19), "time stands still");
    assert!(picture(19) != picture(20), "some steps");
    assert!(picture(25) != picture(24), "another camera");
    assert!(picture(26) == picture(24), "the first one again");

    let brighter = [&arguments[..5], &["dark"], &rest, &["--exposure", "0.25"]].concat();
    assert_eq!(viewer(&scratch, &brighter).status.code(), Some(0));
    let sum = |folder: &str| {
        let picture = pixels(&scratch.0.join(folder).join("frame_00000.png"));
        picture.iter().flatten().map(|part| u64::from(*part)).sum::<u64>()
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
    assert!(last("small.glb", "seen") == last("none.glb", "unseen"));
}

#[test]
fn the_first_camera_is_where_one_begins_unless_a_clip_has_it_before_a_wall() {
    let scratch = scratch("viewer-begin");
    fs::write(scratch.0.join("none.glb"), scene::small_without_cameras()).unwrap();
    fs::write(scratch.0.join("wall.glb"), scene::small_before_the_wall()).unwrap();
    let seen = |arguments: &[&str], out: &str| {
        let rest = ["--headless", "--frames", "1", "--out", out, "--size", "128x72"];
        let mut command = program(env!("CARGO_BIN_EXE_viewer"), &scratch.0, arguments);
        command.args(rest).args(["--device", "llvmpipe"]).env("RUST_LOG", "samples=info");
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (pixels(&scratch.0.join(out).join("frame_00000.png")), stderr(&output))
    };
    let hint = "a clip moves the file's first camera, walk: key 1 looks through it, 2 through";
    let (before, log) = seen(&["wall.glb"], "wall");
    assert!(log.contains(hint), "{log}");
    let (none, log) = seen(&["none.glb"], "none");
    assert!(before == none && !log.contains("key 1"), "{log}");
    let (asked, log) = seen(&["wall.glb", "--camera", "walk"], "asked");
    assert!(asked != none && !log.contains("key 1"), "{log}");
    let (clear, log) = seen(&["small.glb"], "clear");
    assert!(clear != none && !log.contains("key 1"), "{log}");
    assert!(clear == seen(&["small.glb", "--camera", "walk"], "clear-asked").0);
}

/// The message of a refusal: one line that names the file.
fn refusal(output: &Output) -> String {
    let message = stderr(output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.starts_with("error: ") && !message.contains("panicked"), "{message}");
    assert_eq!(message.lines().count(), 1, "one sentence: {message}");
    assert!(output.stdout.is_empty());
    message
}

#[test]
fn files_that_cannot_be_shown_end_with_2_and_are_named() {
    let scratch = scratch("scene-mistakes");
    let whole = scene::small();
    fs::write(scratch.0.join("cut.glb"), &whole[..whole.len() / 2]).unwrap();
    fs::write(scratch.0.join("empty.glb"), "").unwrap();
    fs::write(scratch.0.join("text.gltf"), "no JSON").unwrap();
    fs::create_dir(scratch.0.join("folder.glb")).unwrap();
    for file in ["missing.glb", "cut.glb", "empty.glb", "text.gltf", "folder.glb"] {
        let size = ["--size", "32x32", "--frames", "2"];
        let walked = walkthrough(&scratch.0, &[&["--quiet", "--scene", file], &size[..]].concat());
        let message = refusal(&{ walked }.output().unwrap());
        assert!(message.contains(file), "{message}");
        let viewed = viewer(&scratch, &[&[file, "--headless"], &size[..]].concat());
        assert_eq!(refusal(&viewed), message, "both say the same");
    }
}

#[test]
fn cameras_that_are_not_there_are_refused_with_those_that_are() {
    let scratch = scratch("scene-no-camera");
    let walked = walkthrough(&scratch.0, &["--quiet", "--scene=small.glb", "--path=wlak"]).output();
    let message = refusal(&walked.unwrap());
    let sentence =
        "small.glb: unknown camera 'wlak': there is walk and still; did you mean 'walk'?";
    assert!(message.contains(sentence), "{message}");
    let viewed = viewer(&scratch, &["small.glb", "--headless", "--camera", "Still"]);
    assert!(refusal(&viewed).contains("did you mean 'still'?"));
    let walked =
        walkthrough(&scratch.0, &["--quiet", "--scene=small.glb", "--path=no/such.txt"]).output();
    assert!(refusal(&walked.unwrap()).contains("no/such.txt"));
}

#[test]
fn without_a_display_the_viewer_says_so() {
    let scratch = scratch("viewer-no-display");
    let output = viewer(&scratch, &["small.glb"]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("no display") && message.contains("--headless"), "{message}");
}
