//! Runs the examples of the engine's crates as users do, and checks their output. Examples that
//! draw run under the validation layer.
//!
//! Cargo builds examples with all tests (`cargo test --workspace`), but not with a single test.

#![allow(clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The examples that these tests do not run: one writes the shaders' SPIR-V into the repository,
/// three measure.
const NOT_RUN: [&str; 4] = ["bucket_costs", "compile_shaders", "load", "share_queries"];

/// Returns the folder of the repository.
fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Returns the path of a file that a test may write.
fn scratch(name: &str) -> String {
    format!("{}/{name}", env!("CARGO_TARGET_TMPDIR"))
}

/// Runs an example with synchronization validation and returns its output. Any message of the layer
/// fails the test.
fn run(name: &str, arguments: &[&str]) -> String {
    let this = std::env::current_exe().expect("a program");
    let profile = this.ancestors().nth(2).expect("a target folder");
    let output = Command::new(profile.join("examples").join(name))
        .args(arguments)
        .current_dir(env!("CARGO_TARGET_TMPDIR"))
        .env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation")
        .env("VK_LAYER_ENABLES", "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT")
        .output()
        .unwrap_or_else(|error| {
            panic!("{name}: {error}; `cargo build --workspace --all-features --examples` builds it")
        });
    let [printed, errors] =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    assert!(output.status.success(), "{name}: {errors}");
    assert!(errors.is_empty(), "{name}: {errors}");
    assert!(!printed.contains("VUID-") && !printed.contains("SYNC-HAZARD"), "{name}: {printed}");
    printed
}

/// Returns the last line with this beginning.
fn line<'a>(printed: &'a str, start: &str) -> &'a str {
    let found = printed.lines().rfind(|line| line.starts_with(start));
    found.unwrap_or_else(|| panic!("no line begins with \"{start}\":\n{printed}"))
}

/// Returns the whole numbers of a line, in their order.
fn numbers(line: &str) -> Vec<u64> {
    let parts = line.split(|letter: char| !letter.is_ascii_digit());
    parts.filter_map(|part| part.parse().ok()).collect()
}

#[test]
fn cull_plans_one_draw_and_few_tests() {
    let printed = run("plan_frames", &[]);
    assert!(numbers(line(&printed, "frame 0:"))[2] > 100, "{printed}");
    assert_eq!(line(&printed, "frame 90:"), "frame 90: 1 drawn, 1 tests decide about 1000 more");
}

#[test]
fn shadow_maps_are_planned_once_and_then_the_moving_casters_alone() {
    let printed = run("plan_maps", &[]);
    let first = numbers(line(&printed, "frame 0:"));
    assert_eq!(first[1], first[2], "{printed}");
    let last = numbers(line(&printed, "frame 9:"));
    assert!(last[1] < last[2] && last[3] < first[3] / 10, "{printed}");
}

#[test]
fn scene_is_checked_and_changed() {
    let printed = run("check_scene", &[]);
    assert!(printed.starts_with("three sails: 3 triangles, 3 of 2097152 objects\n"), "{printed}");
    let refused = line(&printed, "refused:");
    assert_eq!(refused, "refused: object 3 cannot be drawn: the scene does not have its mesh");
    assert_eq!(numbers(line(&printed, "next frame:")), [3]);
}

#[test]
fn animation_bends_an_arm() {
    let printed = run("bend_arm", &[]);
    assert_eq!(line(&printed, "0.00 s:"), "0.00 s: the tip is at 0.00 m, 2.00 m");
    assert_eq!(line(&printed, "1.00 s:"), "1.00 s: the tip is at -1.00 m, 1.00 m");
    assert_eq!(line(&printed, "2.00 s:"), "2.00 s: the tip is at 0.00 m, 2.00 m");
}

#[test]
fn pacing_starts_frames_late() {
    let printed = run("pace_frames", &[]);
    let [_, lead_us] = numbers(line(&printed, "frame 900 "))[..] else { panic!("{printed}") };
    assert!((5_000..6_000).contains(&lead_us), "5 ms of work:\n{printed}");
    assert!(printed.contains("period 10ms,"), "{printed}");
    assert_eq!(line(&printed, "missed"), "missed refreshes: 0");
}

#[test]
fn import_lists_a_triangle() {
    let printed = run("list_gltf", &[]);
    assert!(printed.starts_with("memory: 1 meshes, 1 objects, 1 triangles\n"), "{printed}");
    assert_eq!(line(&printed, "clip"), "clip 0, hoist: 1.00 s");
    assert_eq!(numbers(line(&printed, "half a second")), [1]);
}

#[test]
fn import_lists_a_file() {
    let file = scratch("examples-no-scene.gltf");
    fs::write(&file, "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{}]}")
        .expect("the target folder is writable");
    let printed = run("list_gltf", &[&file]);
    fs::remove_file(file).expect("it is there");
    assert!(printed.starts_with("examples-no-scene: 0 meshes, 0 objects"), "{printed}");
}

#[test]
fn shaders_are_listed() {
    assert!(numbers(line(&run("list_shaders", &[]), "sky.frag "))[0] > 100);
}

#[test]
fn gpu_counts_half_of_the_samples() {
    let printed = run("count_samples", &[]);
    assert_eq!(line(&printed, "left half"), "left half: 2048 samples");
    assert_eq!(line(&printed, "2048"), "2048 of 4096 pixels are red");
}

#[test]
fn occlusion_draws_few_boxes() {
    let printed = run("draw_boxes", &[]);
    let [_, drawn, all] = numbers(line(&printed, "frame "))[..] else { panic!("{printed}") };
    assert!(drawn > 10 && drawn < all / 3, "{printed}");
}

#[test]
fn render_explains_and_looks_from_above() {
    let file = scratch("examples-from-above.png");
    let printed = run("look_from_above", &[&file]);
    assert_eq!(line(&printed, "wall at 0 "), "wall at 0 m: 1 of 401 objects drawn");
    assert!(printed.contains("\ntile 1: one test for "), "{printed}");
    assert!(numbers(line(&printed, "wall at 1.2 "))[2] > 10, "{printed}");
    assert!(line(&printed, "tile 1").starts_with("tile 1: Drawn"), "{printed}");
    let png = fs::read(&file).expect("an image");
    fs::remove_file(file).expect("it is there");
    assert!(png.starts_with(b"\x89PNG") && png.len() > 2_000, "{} bytes", png.len());
}

#[test]
fn render_lets_a_host_draw_over_the_image() {
    let file = scratch("overlay.png");
    let printed = run("host_overlay", &[&file]);
    fs::remove_file(file).expect("it is there");
    assert_eq!(line(&printed, "over "), "over the image: 6400 green pixels");
    assert_eq!(line(&printed, "in "), "in the scene's image: 0 green pixels");
}

#[test]
fn antumbra_walks_into_a_file_and_writes_its_last_image() {
    let model = scratch("wall_and_tile.obj");
    let quad = |half: f32, z: f32| {
        let corners = [[-half, 0.0], [half, 0.0], [half, 9.0], [-half, 9.0]];
        corners.map(|[x, y]| format!("v {x} {y} {z}\n")).concat()
    };
    let wall = format!("{}o wall\nf 1 2 3 4\n", quad(40.0, -20.0));
    let tile = format!("{}o tile\nf 5 6 7 8\n", quad(1.0, -30.0));
    fs::write(&model, wall + &tile).expect("it is written");
    let printed = run("first_program", &[&model]);
    let [drawn, in_frustum] = numbers(line(&printed, ""))[..] else { panic!("{printed}") };
    assert!(in_frustum == 2 && (1..=2).contains(&drawn), "{printed}");
    let image = fs::read(scratch("first.png")).expect("it is there");
    assert!(image.starts_with(b"\x89PNG"));
    // The header has width and height; an image of one colour takes some hundred bytes.
    assert_eq!(image[16..24], [0, 0, 5, 0, 0, 0, 2, 208]);
    assert!(image.len() > 1000, "{} bytes", image.len());
}

#[test]
fn antumbra_draws_a_street_of_a_city() {
    let printed = run("walk_city", &[]);
    let [_, drawn, all] = numbers(line(&printed, "frame "))[..] else { panic!("{printed}") };
    assert!(drawn > 10 && drawn < all / 10, "{printed}");
}

#[test]
fn every_method_draws_what_the_bound_draws() {
    let printed = run("compare_methods", &[]);
    let row = |name: &str| match numbers(&line(&printed, &format!("{name} "))[name.len()..])[..] {
        [draws, tests, waits] => (draws, tests, waits),
        _ => panic!("{name}:\n{printed}"),
    };
    let (bound, _, _) = row("ideal");
    assert_eq!(row("frustum"), (401, 0, 0));
    for name in ["naive", "batched", "stop_and_wait", "chc", "antumbra"] {
        let (draws, tests, _) = row(name);
        assert!(draws >= bound && draws < 100 && tests > 0, "{name}:\n{printed}");
    }
    assert_eq!(row("antumbra").2, 0, "it never waits:\n{printed}");
}

#[test]
fn every_example_is_run_and_named_in_its_page() {
    let tests = include_str!("examples.rs");
    let mut crates: Vec<PathBuf> = fs::read_dir(repository().join("engine"))
        .expect("the engine")
        .map(|entry| entry.expect("it is read").path())
        .filter(|path| path.join("Cargo.toml").exists())
        .collect();
    crates.push(repository().join("shaders"));
    for folder in crates {
        let page = fs::read_to_string(folder.join("README.md")).expect("a page");
        if folder.ends_with("capi") {
            // These examples are programs in C and C++, which `ci/capi` builds and runs.
            continue;
        }
        if folder.ends_with("wgpu") {
            // Its example is outside of the workspace, too: `ci/hosts` builds and runs both.
            assert!(page.contains("examples/hosts/wgpu"), "{} does not name it", folder.display());
            continue;
        }
        let names = if folder.ends_with("methods") {
            // These examples run in a renderer, which only a higher crate knows.
            vec!["compare_methods".to_owned()]
        } else {
            example_names(&folder)
        };
        assert!(!names.is_empty(), "{} has no example", folder.display());
        for name in names {
            let command = format!("--example {name}");
            assert!(page.contains(&command), "{} does not name {name}", folder.display());
            let is_run = tests.contains(&format!("run(\"{name}\"")) || NOT_RUN.contains(&&*name);
            assert!(is_run, "no test runs {name}");
        }
    }
}

/// Returns the names of a crate's examples.
fn example_names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder.join("examples"));
    let entries = entries.unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let name = |path: &Path| path.file_stem().expect("a name").to_string_lossy().into_owned();
    entries.map(|entry| name(&entry.expect("it is read").path())).collect()
}
