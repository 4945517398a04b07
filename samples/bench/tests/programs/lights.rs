//! Runs `walkthrough` under lights with shadows: every possible combination is exact, and
//! impossible ones are refused.

use harness::Scratch;
use serde_json::Value;

use crate::{refusal, report, succeeded, walkthrough};

const SMALL: [&str; 9] = [
    "--objects=400",
    "--frames=12",
    "--size=96x64",
    "--strategy=frustum,antumbra",
    "--cost-model=off",
    "--verify=every",
    "--validation=sync",
    "--report=report.json",
    "--quiet",
];

/// Walks through a small city on `device`, compares every frame, and returns the report.
fn walk(scratch: &Scratch, device: &str, more: &[&str]) -> Value {
    let arguments = [&SMALL[..], &["--device", device], more].concat();
    succeeded(&mut walkthrough(&scratch.0, &arguments));
    let report = report(scratch);
    assert_eq!(report["validation_messages"], 0);
    report
}

fn runs_of(report: &Value) -> &[Value] {
    report["runs"].as_array().expect("runs")
}

#[test]
fn each_combination_is_a_run_that_is_exact_while_objects_move() {
    let scratch = Scratch::new("combinations");
    let more = ["--lights=4", "--shadows=off,maps,maps_uncached,volumes", "--moving-percent=5"];
    let report = walk(&scratch, "llvmpipe", &more);
    assert_eq!(report["lights"], "4");
    let runs = runs_of(&report);
    let keys = |run: &Value| {
        ["shadows", "filter", "strategy"].map(|key| run[key].as_str().expect("a name").to_owned())
    };
    let found: Vec<[String; 3]> = runs.iter().map(keys).collect();
    let mut expected = Vec::new();
    for shadows in ["off", "maps", "maps_uncached", "volumes"] {
        for strategy in ["frustum", "antumbra"] {
            expected.push([shadows, "adaptive", strategy].map(str::to_owned));
        }
    }
    assert_eq!(found, expected);
    for (run, [shadows, ..]) in runs.iter().zip(&found) {
        assert_eq!(run["pixels_wrong"], 0, "{shadows}");
        assert_eq!((&run["frames_verified"], &run["frames_timed"]), (&12.into(), &12.into()));
        let faces = run["shadow_faces"].as_u64().expect("a number");
        match shadows.as_str() {
            "off" | "volumes" => assert_eq!(faces, 0),
            "maps_uncached" => assert!(faces > 4, "{faces}"),
            _ => {}
        }
    }
    let faces = |place: usize| runs[place]["shadow_faces"].as_u64().expect("a number");
    assert!(faces(3) <= faces(5), "a cache draws no more maps");
    assert!(report["ratios"]["antumbra maps adaptive/antumbra off adaptive"].is_number());
}

#[test]
fn midpoint_depths_are_exact_while_objects_move() {
    let scratch = Scratch::new("midpoints");
    let more =
        ["--lights=4", "--shadows=maps,maps_uncached", "--bias=midpoint", "--moving-percent=5"];
    let report = walk(&scratch, "llvmpipe", &[&more[..], &["--strategy=antumbra"]].concat());
    for run in runs_of(&report) {
        assert_eq!((&run["bias"], &run["pixels_wrong"]), (&"midpoint".into(), &0.into()));
        assert!(run["shadow_triangles"].as_u64().expect("a number") > 0);
    }
}

#[test]
fn filters_run_on_the_other_driver_too() {
    let scratch = Scratch::new("filters");
    let more = ["--lights=sun", "--shadows=maps", "--filter=single,fixed64", "--strategy=antumbra"];
    let report = walk(&scratch, "swiftshader", &more);
    assert_eq!(report["lights"], "sun");
    let filters: Vec<_> = runs_of(&report).iter().map(|run| &run["filter"]).collect();
    assert_eq!(filters, ["single", "fixed64"]);
    let most = |run: &Value| run["fixed64_difference_max"].as_u64().expect("it was compared");
    let [single, fixed64] = [0, 1].map(|place| most(&runs_of(&report)[place]));
    assert!(single > 0 && fixed64 == 0, "{single}, {fixed64}");
    assert!(runs_of(&report).iter().all(|run| run["pixels_wrong"] == 0));
}

#[test]
fn without_lights_nothing_is_said_about_them() {
    let scratch = Scratch::new("unlit");
    let report = walk(&scratch, "llvmpipe", &[]);
    let run = &runs_of(&report)[0];
    for absent in [&report["lights"], &run["shadows"], &run["filter"], &run["shadow_faces"]] {
        assert_eq!(absent, &Value::Null);
    }
}

/// Checks what only the scene tells; the command line's own refusals are tested beside it.
#[test]
fn lights_that_the_scene_has_not_are_refused() {
    let scratch = Scratch::new("bad-lights");
    for (arguments, sentence) in [
        (["--lights", "64", "--objects", "100"], "street lamps, not 64"),
        (["--lights", "torches", "--objects", "1"], "0 street lamps"),
    ] {
        let arguments = [&arguments[..], &["--quiet"]].concat();
        let message = refusal(&mut walkthrough(&scratch.0, &arguments), 2);
        assert!(message.contains(sentence), "{arguments:?}: {message}");
        assert!(scratch.names(".").is_empty());
    }
}
