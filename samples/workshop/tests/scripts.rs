//! Runs `workshop` as a user does: scripts without a window, under synchronization validation.
#![allow(clippy::expect_used, clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::process::Output;

use harness::{Scratch, pixels, program, stderr};
use serde_json::Value;

const WORKSHOP: &str = env!("CARGO_BIN_EXE_workshop");

/// Runs a script of these lines in a folder of its own.
fn run(scratch: &Scratch, script: &str, arguments: &[&str]) -> Output {
    fs::write(scratch.0.join("script"), script).unwrap();
    let line = ["--headless", "--script", "script", "--report", "report.json", "--size", "320x240"];
    let line = [&line[..], &["--validation", "sync"], arguments].concat();
    program(WORKSHOP, &scratch.0, &line).output().expect("the program runs")
}

/// Returns the steps of a report.
fn steps(scratch: &Scratch) -> Vec<Value> {
    let text = fs::read_to_string(scratch.0.join("report.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["validation_messages"], 0, "{text}");
    report["steps"].as_array().unwrap().clone()
}

#[test]
#[cfg(target_os = "linux")]
fn a_fault_of_vulkan_ends_with_1_and_its_call_and_code() {
    harness::assert_faults_end_programs("workshop-fault", |folder| {
        fs::write(folder.join("script"), "view front\nlid 40\nimage open.png\n").unwrap();
        let line = ["--headless", "--script", "script", "--size", "64x48", "--device", "llvmpipe"];
        program(WORKSHOP, folder, &line)
    });
}

/// Checks that a device without what phones often lack draws the same image.
#[test]
#[cfg(target_os = "linux")]
fn an_image_on_a_phone_is_that_on_a_desktop() {
    let line = ["--headless", "--script", "script", "--size", "160x120", "--device", "llvmpipe"];
    let command = |scratch: &Scratch| {
        fs::write(scratch.0.join("script"), "view front\nlid 40\nimage open.png\n").unwrap();
        program(WORKSHOP, &scratch.0, &line)
    };
    let desktop = Scratch::new("workshop-desktop");
    let output = command(&desktop).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let phone = Scratch::new("workshop-phone");
    harness::PhoneLoader::new("phone-workshop-loader").run(command(&phone));
    assert!(pixels(&phone.0.join("open.png")) == pixels(&desktop.0.join("open.png")));
}

#[test]
fn a_script_picks_turns_the_lid_explodes_measures_and_exports() {
    for device in ["llvmpipe", "SwiftShader"] {
        let scratch = Scratch::new(&format!("workshop-{device}"));
        let script = "\
            view front\n\
            projection orthographic\n\
            pick 145 128\n\
            pick 190 128\n\
            distance 145 128 190 128\n\
            image closed.png\n\
            lid 40\n\
            image open.png\n\
            lid -30\n\
            lid 0\n\
            image again.png\n\
            explode 12.5\n\
            assemble\n\
            select lid\n\
            hide\n\
            export body.glb\n\
            show\n\
            lid 200\n\
            play 3\n";
        let output = run(&scratch, script, &["--device", device]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let steps = steps(&scratch);
        assert_eq!(steps[2]["picked"]["part"], "body", "{steps:#?}");
        // The front of the body is plane: its points are found to a thousandth of a millimetre.
        let point =
            |step: usize, axis: usize| steps[step]["picked"]["point_mm"][axis].as_f64().unwrap();
        assert!((point(2, 2) - 125.0).abs() < 1e-3, "{}", point(2, 2));
        let distance_mm = steps[4]["distance"]["distance_mm"].as_f64().unwrap();
        assert!((distance_mm - (point(3, 0) - point(2, 0))).abs() < 1e-3, "{distance_mm}");
        assert!(distance_mm > 50.0, "{distance_mm}");
        let lid = &steps[6]["lid"];
        assert!((lid["degrees"].as_f64().unwrap() - 40.0).abs() < 1e-3 && lid["contact"].is_null());
        let shut = &steps[8]["lid"];
        assert_eq!(shut["contact"][1], "body", "{steps:#?}");
        let degrees = shut["degrees"].as_f64().unwrap();
        assert!(degrees < -0.05 && degrees > -1.0, "0.6 mm to the body: {degrees}");
        // Far beyond the vertical it comes to lie on its own cable.
        let stopped = &steps[17]["lid"];
        assert_eq!(stopped["contact"][0], "lid shell", "{steps:#?}");
        assert_eq!(stopped["contact"][1], "cable");
        let degrees = stopped["degrees"].as_f64().unwrap();
        assert!((163.0..165.0).contains(&degrees), "{degrees}");
        let image = |name: &str| pixels(&scratch.0.join(name));
        assert!(image("open.png") != image("closed.png"));
        assert!(image("again.png") == image("closed.png"), "the lid comes back to the bit");
        let gap_mm = steps[11]["exploded"]["least_gap_mm"].as_f64().unwrap();
        assert!((12.5..12.6).contains(&gap_mm), "{gap_mm}");

        let exported = gltf::Gltf::open(scratch.0.join("body.glb")).unwrap();
        let names: Vec<&str> = exported.nodes().filter_map(|node| node.name()).collect();
        assert!(names.contains(&"body") && !names.contains(&"lid shell"), "{names:?}");
    }
}

#[test]
fn the_knob_is_made_anew_for_the_image_and_exported() {
    for (device, path) in [("llvmpipe", "tessellation shaders"), ("SwiftShader", "compute")] {
        let scratch = Scratch::new(&format!("workshop-tessellate-{device}"));
        let script = "\
            export before.glb\n\
            tessellate 64\n\
            image coarse.png\n\
            tessellate 0.5\n\
            image fine.png\n\
            hide lid knob\n\
            image without.png\n\
            show\n\
            image again.png\n\
            export after.glb\n";
        let output = run(&scratch, script, &["--device", device]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let steps = steps(&scratch);
        let made = [1, 3].map(|step| &steps[step]["tessellated"]);
        assert!(made.iter().all(|made| made["path"] == path), "{steps:#?}");
        let [coarse, fine] = made.map(|made| made["triangles"].as_u64().unwrap());
        assert!(coarse >= 8 && coarse * 16 < fine, "{coarse} {fine}");
        let image = |name: &str| pixels(&scratch.0.join(name));
        assert!(
            image("coarse.png") != image("fine.png") && image("fine.png") == image("again.png")
        );
        assert!(image("without.png") != image("fine.png"));
        let bytes = |step: usize| steps[step]["exported"]["bytes"].as_u64().unwrap();
        assert!(bytes(9) > bytes(0) + fine * 6, "{steps:#?}");
    }
    let scratch = Scratch::new("workshop-tessellate-none");
    let output = run(&scratch, "tessellate 4\n", &["assembly", "--parts", "20"]);
    assert!(stderr(&output).contains("no curved part"), "{}", stderr(&output));
}

#[test]
fn an_empty_selection_and_what_is_not_there_change_nothing() {
    let scratch = Scratch::new("workshop-refused");
    let script = "\
        image before.png\n\
        hide\n\
        isolate\n\
        ghost the moon\n\
        pick 0 0\n\
        pick 99999 0\n\
        distance 99999 1 2 3\n\
        distance 2 3 1 240\n\
        edge 320 1\n\
        image after.png\n";
    let output = run(&scratch, script, &[]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let said = stderr(&output);
    assert!(said.contains("hide: nothing is selected") && said.contains("'the moon'"), "{said}");
    let steps = steps(&scratch);
    assert!(steps[1]["refused"].is_string(), "{steps:#?}");
    for step in &steps[5..9] {
        assert!(step["refused"].as_str().unwrap().contains("320x240"), "{step}");
    }
    assert_eq!(steps[4].get("picked"), Some(&Value::Null), "{steps:#?}");
    let image = |name: &str| pixels(&scratch.0.join(name));
    assert!(image("before.png") == image("after.png"));
}

#[test]
fn what_is_wrong_is_refused_before_anything_is_written() {
    let scratch = Scratch::new("workshop-wrong");
    for (script, arguments, reason) in [
        ("image a.png\nfly\n", &[][..], "script:2: unknown command 'fly'"),
        ("image a.png\n", &["--report", "nowhere/report.json"], "there is no folder"),
        ("image a.png\n", &["waffle", "--parts", "5"], "--parts is about the model assembly"),
        ("image a.png\n", &["--fragments-per-pixel", "5"], "--transparency fragments"),
        ("image a.png\n", &["moon"], "there is no model 'moon'"),
        ("image a.png\n", &["moon.glb"], "moon.glb"),
        ("image nowhere/a.png\n", &[], "nowhere/a.png"),
        ("export nowhere/a.glb\n", &[], "nowhere/a.glb"),
        ("deselect\n", &["--report", "./script"], "would be lost"),
    ] {
        let output = run(&scratch, script, arguments);
        assert_ne!(output.status.code(), Some(0), "{script} {arguments:?}");
        assert!(stderr(&output).contains(reason), "{script}: {}", stderr(&output));
        let left = scratch.names("");
        assert!(
            !left.iter().any(|name| name.ends_with("png") || name.ends_with("glb")),
            "{left:?}"
        );
    }
}

#[test]
fn an_assembly_is_taken_apart_by_its_names() {
    let scratch = Scratch::new("workshop-assembly");
    let script = "select assembly\nview top-front\nfit\npick 160 120\nimage all.png\n";
    let output = run(&scratch, script, &["assembly", "--parts", "1000", "--seed", "3"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let steps = steps(&scratch);
    assert_eq!(steps[0]["selected"].as_array().unwrap().len(), 1000, "{}", steps[0]);
    let visible = steps[4]["image"]["visible"].as_array().unwrap().len();
    assert!((10..1000).contains(&visible), "{visible}");
}

/// Writes `panes.gltf`: transparent triangles, and if wanted a small opaque part.
fn write_panes(scratch: &Scratch, panes: usize, parts: usize) {
    let corners: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    fs::write(scratch.0.join("corners.bin"), corners.map(f32::to_le_bytes).concat()).unwrap();
    let triangle = |material: u32| {
        serde_json::json!({
            "primitives": [{ "attributes": { "POSITION": 0 }, "material": material }]
        })
    };
    let pin = serde_json::json!({ "name": "pin", "mesh": 1, "scale": [0.01, 0.01, 0.01] });
    let mut nodes = vec![pin; parts];
    nodes.extend(vec![serde_json::json!({ "name": "pane", "mesh": 0 }); panes]);
    let shown: Vec<usize> = (0..nodes.len()).collect();
    let accessor = serde_json::json!({
        "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
        "min": [0, 0, 0], "max": [1, 1, 0]
    });
    let red = serde_json::json!({ "baseColorFactor": [1, 0, 0, 0.5] });
    let file = serde_json::json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": shown }],
        "scene": 0,
        "nodes": nodes,
        "meshes": [triangle(0), triangle(1)],
        "materials": [
            { "alphaMode": "BLEND", "doubleSided": true, "pbrMetallicRoughness": red },
            {}
        ],
        "accessors": [accessor],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "uri": "corners.bin", "byteLength": 36 }]
    });
    fs::write(scratch.0.join("panes.gltf"), file.to_string()).unwrap();
}

#[test]
fn fragments_without_room_are_said_and_fail() {
    for (room, code) in [("1", Some(1)), ("32", Some(0))] {
        let scratch = Scratch::new(&format!("workshop-fragments-{room}"));
        write_panes(&scratch, 20, 0);
        let arguments = ["panes.gltf", "--transparency", "fragments"];
        let arguments = [&arguments[..], &["--fragments-per-pixel", room]].concat();
        let output = run(&scratch, "view front\nfit\nimage panes.png\n", &arguments);
        assert_eq!(output.status.code(), code, "{}", stderr(&output));
        let inexact = &steps(&scratch)[2]["image"]["inexact"];
        assert_eq!(inexact.is_string(), room == "1", "{inexact}");
        assert_eq!(stderr(&output).contains("found no room"), room == "1", "{}", stderr(&output));
    }
}

#[test]
fn transparent_objects_of_a_file_are_seen_and_left_out_of_exports() {
    for parts in [0, 1] {
        let scratch = Scratch::new(&format!("workshop-transparent-{parts}"));
        write_panes(&scratch, 3, parts);
        let script = "view front\nfit\nimage panes.png\nexport panes.glb\n";
        let output = run(&scratch, script, &["panes.gltf"]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1 - parts as i32), "{said}");
        assert_eq!(said.contains("no opaque part is shown"), parts == 0, "{said}");
        let image = pixels(&scratch.0.join("panes.png"));
        let is_red = |pixel: &&[u8; 3]| pixel[0] > pixel[2];
        let share = image.iter().filter(is_red).count() as f32 / image.len() as f32;
        assert!((0.05..0.6).contains(&share), "the panes are within the image: {share}");
        assert_eq!(said.contains("3 transparent objects are left out"), parts == 1, "{said}");
    }
}

#[test]
fn parts_beside_transparent_objects_of_a_file_become_ghosts() {
    let scratch = Scratch::new("workshop-ghost-beside");
    write_panes(&scratch, 1, 1);
    let script = "view front\nfit\nimage shown.png\nghost pin\nimage ghost.png\n\
                  hide pin\nimage hidden.png\n";
    let output = run(&scratch, script, &["panes.gltf"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let [shown, ghost, hidden] =
        ["shown.png", "ghost.png", "hidden.png"].map(|name| pixels(&scratch.0.join(name)));
    let differ = |a: &[[u8; 3]], b: &[[u8; 3]]| a.iter().zip(b).filter(|(a, b)| a != b).count();
    let of_pin = differ(&shown, &hidden);
    assert!((1..shown.len() / 20).contains(&of_pin), "the pin alone comes and goes: {of_pin}");
    assert!((1..=of_pin).contains(&differ(&ghost, &hidden)), "the ghost is seen where it is");
    assert!(differ(&ghost, &shown) > 0, "and is no opaque part");
}
