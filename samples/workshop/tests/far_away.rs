//! A model far from the origin of its file looks like the same model at the origin.
#![allow(clippy::expect_used, clippy::unwrap_used, reason = "a test fails by panicking")]

use std::borrow::Cow;
use std::fs;

use gltf::binary::Glb;
use harness::{Scratch, pixels, program, stderr};
use serde_json::{Value, json};

const WORKSHOP: &str = env!("CARGO_BIN_EXE_workshop");

/// 1,000 km, and less than that, along the axes.
const PLACE_M: [f64; 3] = [1.0e6, 40_000.0, -1.0e6];

/// Runs a script on a model, in the folder of all.
fn run(scratch: &Scratch, model: &str, script: &str) -> Value {
    fs::write(scratch.0.join("script"), script).unwrap();
    let line = [model, "--headless", "--script", "script", "--report", "report.json"];
    let line = [&line[..], &["--size", "320x240", "--validation", "sync"]].concat();
    let output = program(WORKSHOP, &scratch.0, &line).output().expect("the program runs");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    serde_json::from_slice(&fs::read(scratch.0.join("report.json")).unwrap()).unwrap()
}

/// Writes a model again whose root nodes are moved.
fn write_moved(scratch: &Scratch, from: &str, to: &str) {
    let bytes = fs::read(scratch.0.join(from)).unwrap();
    let mut glb = Glb::from_slice(&bytes).unwrap();
    let mut root: Value = serde_json::from_slice(&glb.json).unwrap();
    for node in root["scenes"][0]["nodes"].as_array().unwrap().clone() {
        root["nodes"][node.as_u64().unwrap() as usize]["translation"] = json!(PLACE_M);
    }
    glb.json = Cow::Owned(serde_json::to_vec(&root).unwrap());
    fs::write(scratch.0.join(to), glb.to_vec().unwrap()).unwrap();
}

#[test]
fn a_thousand_kilometres_away_a_model_looks_and_is_measured_the_same() {
    let scratch = Scratch::new("workshop-far-away");
    run(&scratch, "waffle", "export near.glb\n");
    write_moved(&scratch, "near.glb", "far.glb");
    // The plane z = 10 mm of the model, in the coordinates of each file.
    let script = |name: &str, offset_m: f64| {
        format!(
            "image {name}.png\nview front\npick 160 135\ndistance 145 128 190 128\n\
             section 0,0,-1,{offset_m}\nprojection orthographic\nimage {name}-cut.png\n\
             pick 160 135\nsection off\nexplode 3\nfit\nimage {name}-apart.png\n\
             assemble\nexport {name}-again.glb\n"
        )
    };
    let near = run(&scratch, "near.glb", &script("near", 0.01));
    let far = run(&scratch, "far.glb", &script("far", 0.01 + PLACE_M[2]));
    for image in ["", "-cut", "-apart"] {
        let of = |name: &str| pixels(&scratch.0.join(format!("{name}{image}.png")));
        assert!(of("near") == of("far"), "image '{image}'");
    }
    for step in [2, 7] {
        let picked = |report: &Value| report["steps"][step]["picked"].clone();
        assert_eq!(picked(&near)["part"], picked(&far)["part"]);
        for (axis, place_m) in PLACE_M.into_iter().enumerate() {
            let mm = |report: &Value| picked(report)["point_mm"][axis].as_f64().unwrap();
            let apart_mm = mm(&far) - mm(&near) - place_m * 1000.0;
            assert!(apart_mm.abs() < 1.0e-4, "axis {axis}: {apart_mm} mm");
        }
    }
    assert_eq!(near["steps"][3], far["steps"][3]);
    assert_eq!(near["steps"][9], far["steps"][9]);

    // What is exported lies where it was, and has lost nothing either.
    let exported = gltf::Gltf::open(scratch.0.join("far-again.glb")).unwrap();
    let root = exported.scenes().next().unwrap().nodes().next().unwrap();
    let gltf::scene::Transform::Decomposed { translation, .. } = root.transform() else {
        panic!("the root has a matrix")
    };
    assert_eq!(translation.map(f64::from), PLACE_M);
    let again = |name: &str| {
        run(&scratch, &format!("{name}-again.glb"), "image again.png\n");
        pixels(&scratch.0.join("again.png"))
    };
    assert!(again("near") == again("far"));
}
