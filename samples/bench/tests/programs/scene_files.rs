//! Runs `walkthrough` with valid and invalid scene files.

use std::fs;

use harness::{Scratch, pixels, scene};
use serde_json::Value;

use crate::{refusal, report, stdout, succeeded, walkthrough};

fn scratch(name: &str) -> Scratch {
    let scratch = Scratch::new(name);
    fs::write(scratch.0.join("small.glb"), scene::small()).unwrap();
    scratch
}

/// Runs a walk, compares every frame, and returns the report.
fn walk(scratch: &Scratch, device: &str, more: &[&str]) -> Value {
    let small = ["--quiet", "--frames=24", "--size=128x72", "--validation=sync", "--verify=every"];
    let rest =
        ["--cost-model=off", "--scene=small.glb", "--report=report.json", "--device", device];
    succeeded(&mut walkthrough(&scratch.0, &[&small[..], &rest, more].concat()));
    report(scratch)
}

#[test]
fn a_walk_through_a_file_is_exact_with_every_strategy_that_there_is() {
    for device in ["llvmpipe", "swiftshader"] {
        let scratch = scratch(&format!("scene-walk-{device}"));
        let report = walk(&scratch, device, &["--path=walk", "--strategy=all", "--out=images"]);
        assert_eq!(report["validation_messages"], 0);
        let runs = report["runs"].as_array().unwrap();
        let names: Vec<&str> = runs.iter().map(|run| run["strategy"].as_str().unwrap()).collect();
        for expected in ["frustum", "antumbra", "ideal", "hzb"] {
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
        let names = scratch.names("images");
        assert!(names.contains(&"frame_00000.png".to_owned()), "{names:?}");
    }
}

#[test]
fn orthographic_cameras_are_exact_too() {
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
    }
}

#[test]
fn lamps_beyond_those_that_an_object_has_are_told() {
    let scratch = Scratch::new("scene-lamps");
    fs::write(scratch.0.join("lamps.glb"), scene::small_with_lamps(17)).unwrap();
    let small = ["--quiet", "--frames=2", "--size=32x32", "--scene=lamps.glb", "--device=llvmpipe"];
    let told = stdout(&succeeded(&mut walkthrough(&scratch.0, &small)));
    assert!(told.contains(&format!("not as in the file: {}", scene::LAMPS_NOTE)), "{told}");
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

/// Checks that the whole clip is walked once from end to end, in any number of frames.
#[test]
fn the_camera_goes_from_end_to_end_in_any_number_of_frames() {
    let scratch = scratch("scene-ends");
    let last = |frames: &str, out: &str| {
        let images = format!("--images={frames}");
        let frames = format!("--frames={frames}");
        let more = ["--path=walk", "--strategy=antumbra", &frames, &images, "--out", out];
        walk(&scratch, "llvmpipe", &more);
        let names = scratch.names(out);
        let name = names.iter().rfind(|name| name.starts_with("frame_")).unwrap().clone();
        let image = |name: &str| pixels(&scratch.0.join(out).join(name));
        (image("frame_00000.png"), image(&name))
    };
    let few = last("3", "few");
    let many = last("13", "many");
    assert!(few.0 == many.0 && few.1 == many.1 && few.0 != few.1);
}

#[test]
fn without_a_name_it_is_the_first_camera_and_a_still_one_stands() {
    let scratch = scratch("scene-cameras");
    assert_eq!(walk(&scratch, "llvmpipe", &["--strategy=antumbra"])["path"], "walk");
    let more = ["--path=still", "--strategy=antumbra", "--out=still", "--images=24"];
    walk(&scratch, "llvmpipe", &more);
    let image = |frame: u32| pixels(&scratch.0.join(format!("still/frame_{frame:05}.png")));
    // Only the door moves, at sixty frames per second.
    assert!(image(0) != image(23));
}

#[test]
fn files_that_cannot_be_shown_end_with_2_and_are_named() {
    let scratch = scratch("scene-mistakes");
    for file in scene::write_unreadable(&scratch.0) {
        let arguments = ["--quiet", "--scene", file, "--size", "32x32", "--frames", "2"];
        let message = refusal(&mut walkthrough(&scratch.0, &arguments), 2);
        assert!(message.contains(file), "{message}");
    }
}

#[test]
fn cameras_that_are_not_there_are_refused_with_those_that_are() {
    let scratch = scratch("scene-no-camera");
    let along = |path| walkthrough(&scratch.0, &["--quiet", "--scene=small.glb", path]);
    let message = refusal(&mut along("--path=wlak"), 2);
    let sentence =
        "small.glb: unknown camera 'wlak': there is walk and still; did you mean 'walk'?";
    assert!(message.contains(sentence), "{message}");
    assert!(refusal(&mut along("--path=no/such.txt"), 2).contains("no/such.txt"));
}
