//! Runs `walkthrough` from end to end on the software drivers: exact, silent, complete.

use std::fs;
use std::path::Path;

use antumbra::{cull, methods};
use harness::{Scratch, stderr};
use serde_json::Value;

use crate::{report, stdout, succeeded, walkthrough};

const FRAMES: u64 = 12;
const SIZE: [u32; 2] = [96, 64];

/// Walks through a small city on `device`, every frame compared, and returns the report. Without
/// measured costs, which differ from run to run, everything is tested.
fn walk(scratch: &Scratch, device: &str, more: &[&str]) -> Value {
    walk_by(scratch, device, &[&["--cost-model=off"], more].concat())
}

fn walk_by(scratch: &Scratch, device: &str, more: &[&str]) -> Value {
    let small = [
        "--scene=city",
        "--objects=1000",
        "--seed=5",
        "--path=street",
        "--frames=12",
        "--size=96x64",
        "--strategy=frustum,antumbra",
        "--verify=every",
        "--validation=sync",
        "--frames-in-flight=3",
        "--out=images",
        "--images=3",
        "--report=report.json",
        "--device",
        device,
    ];
    let output = succeeded(&mut walkthrough(&scratch.0, &[&small[..], more].concat()));
    let messages = stderr(&output);
    assert!(!messages.contains("error") && !messages.contains("WARN"), "{messages}");
    let table = stdout(&output);
    for name in ["frustum", "antumbra"] {
        assert!(table.contains(name), "{table}");
    }
    assert_eq!(scratch.names("."), ["images", "report.json"]);
    report(scratch)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

/// Checks that every key of the contract has a plausible value.
fn assert_report(report: &Value, device: &str) {
    let name = report["device"]["name"].as_str().expect("a name");
    assert!(name.to_lowercase().contains(device), "{name}");
    assert!(!report["device"]["driver"].as_str().expect("a driver").is_empty());
    assert!(report["device"]["api"].as_str().expect("a version").starts_with("1.3."));
    assert_eq!(report["device"]["conditional_rendering"], device == "llvmpipe");
    assert_eq!(report["scene"]["name"], "city");
    assert_eq!(report["scene"]["seed"], 5);
    assert!((900.0..1100.0).contains(&number(&report["scene"]["objects"])));
    let triangles = number(&report["scene"]["triangles"]);
    assert!(triangles > 10_000.0);
    assert_eq!(report["path"], "street");
    assert_eq!(report["frames"], FRAMES);
    assert_eq!(report["size"], serde_json::json!(SIZE));
    assert_eq!(report["frames_in_flight"], 3);
    assert_eq!(report["validation_messages"], 0);
    assert!(number(&report["memory"]["peak_resident_mib"]) > 1.0);
    assert!(number(&report["build_ms"]["hierarchy"]) > 0.0);

    let runs = report["runs"].as_array().expect("runs");
    let names: Vec<_> = runs.iter().filter_map(|run| run["strategy"].as_str()).collect();
    assert_eq!(names, ["frustum", "antumbra"]);
    for run in runs {
        assert_run(run, triangles);
    }
    let run = |name| runs.iter().find(|run| run["strategy"] == name).expect("its run");
    let frustum = run("frustum");
    let antumbra = run("antumbra");
    assert_eq!((&frustum["queries"], &frustum["predicated_draws"]), (&0.into(), &0.into()));
    assert!(number(&antumbra["tests"]) > 0.0, "nobody asked anything");
    assert!(number(&antumbra["draws"]) < number(&frustum["draws"]), "nothing was hidden");
    let age = &antumbra["result_age_frames"];
    assert!(number(&age["median"]) >= 1.0 && number(&age["max"]) <= 3.0, "{age}");

    let ratio = number(&report["ratios"]["frustum/antumbra"]);
    let medians = [frustum, antumbra].map(|run| number(&run["frame_ms"]["median"]));
    assert!((ratio - medians[0] / medians[1]).abs() < 0.01 * ratio + 0.001, "{ratio}");
    assert!(number(&report["paired_ratios"]["frustum/antumbra"]) > 0.0);
    let command = report["provenance"]["command"].as_array().expect("words");
    assert!(command.len() > 10 && command[0] == "walkthrough", "{command:?}");
    assert_eq!(report["ratios"].as_object().expect("pairs").len(), 2);
}

fn assert_run(run: &Value, scene_triangles: f64) {
    for times in [&run["frame_ms"], &run["cpu_ms"]] {
        let [median, p95, max] = ["median", "p95", "max"].map(|key| number(&times[key]));
        assert!(0.0 < median && median <= p95 && p95 <= max && max < 600_000.0, "{times}");
    }
    assert!(number(&run["draws"]) >= 1.0);
    assert!((1.0..=scene_triangles).contains(&number(&run["triangles"])));
    assert_eq!(run["blocking_waits"], 0);
    assert_eq!(run["frames_timed"], FRAMES);
    assert_eq!(run["frames_verified"], FRAMES);
    assert_eq!(run["warm_up_frames_verified"], 4, "from an empty history on");
    assert_eq!(run["pixels_wrong"], 0);
    let times = run["frame_times_ms"].as_array().expect("times");
    assert_eq!(times.len() as u64, FRAMES);
    assert!(times.iter().all(|time| number(time) <= number(&run["frame_ms"]["max"])));
    assert!(run["predicated_draws"].is_u64() && run["result_age_frames"].is_object());
}

/// Checks the images that a person looks at: whole PNG files of the right size that are not
/// blank.
fn assert_images(scratch: &Scratch) {
    let names = scratch.names("images");
    let expected = [
        "frame_00000.png",
        "frame_00004.png",
        "frame_00008.png",
        "top_down_00006.png",
        "top_down_00006_seen.png",
    ];
    assert_eq!(names, expected);
    for name in names {
        let pixels = decode(&scratch.0.join("images").join(&name));
        let mut colours: Vec<&[u8]> = pixels.chunks_exact(3).collect();
        colours.sort_unstable();
        colours.dedup();
        assert!(colours.len() > 20, "{name} shows {} colours", colours.len());
    }
}

/// Returns the colours of an image, three bytes per pixel.
fn decode(file: &Path) -> Vec<u8> {
    let bytes = fs::read(file).expect("an image");
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut pixels).expect("a whole PNG");
    assert_eq!([info.width, info.height], SIZE, "{}", file.display());
    let samples = info.color_type.samples();
    pixels.chunks_exact(samples).flat_map(|pixel| pixel[..3].to_vec()).collect()
}

#[test]
fn a_walk_on_lavapipe_is_exact_and_complete() {
    let scratch = Scratch::new("walk-lavapipe");
    assert_report(&walk(&scratch, "llvmpipe", &[]), "llvmpipe");
    assert_images(&scratch);
}

#[test]
fn a_walk_on_swiftshader_is_exact_and_complete() {
    let scratch = Scratch::new("walk-swiftshader");
    assert_report(&walk(&scratch, "swiftshader", &[]), "swiftshader");
    assert_images(&scratch);
}

#[test]
fn a_walk_in_which_much_moves_is_exact() {
    for device in ["llvmpipe", "swiftshader"] {
        let scratch = Scratch::new(&format!("moving-{device}"));
        let report = walk(&scratch, device, &["--moving-percent=40"]);
        assert_report(&report, device);
        assert_eq!(report["moving_percent"], 40);
        let moving = number(&report["moving_objects"]);
        assert!((350.0..=450.0).contains(&moving), "{moving} objects");
        assert_images(&scratch);
    }
}

#[test]
fn a_walk_with_two_eyes_is_exact() {
    for (device, moving) in
        [("llvmpipe", "--moving-percent=20"), ("swiftshader", "--moving-percent=0")]
    {
        let scratch = Scratch::new(&format!("views-{device}"));
        let report = walk(&scratch, device, &["--views=2", moving]);
        assert_report(&report, device);
        assert_eq!(report["views"], 2);
        assert_images(&scratch);
    }
}

#[test]
fn walks_in_other_projections_are_exact() {
    for (device, eyes) in [("llvmpipe", "--views=2"), ("swiftshader", "--views=1")] {
        let images = ["perspective", "orthographic", "jittered"].map(|projection| {
            let scratch = Scratch::new(&format!("{projection}-{device}"));
            let report = walk(&scratch, device, &["--projection", projection, eyes]);
            assert_eq!(report["projection"], projection);
            assert_eq!(report["validation_messages"], 0);
            let runs = report["runs"].as_array().expect("runs");
            assert!(runs.iter().all(|run| run["pixels_wrong"] == 0), "{projection}: {runs:?}");
            assert!(runs.iter().all(|run| run["frames_verified"] == FRAMES), "{projection}");
            assert!(number(&runs[1]["tests"]) > 0.0, "{projection}: nobody asked anything");
            decode(&scratch.0.join("images/frame_00004.png"))
        });
        assert!(images[0] != images[1] && images[0] != images[2], "{device}: all the same");
    }
}

#[test]
fn a_walk_by_measured_costs_is_exact() {
    for device in ["llvmpipe", "swiftshader"] {
        let scratch = Scratch::new(&format!("costs-{device}"));
        let report = walk_by(&scratch, device, &[]);
        for run in report["runs"].as_array().expect("runs") {
            assert_eq!(run["pixels_wrong"], 0, "{device}");
            assert_eq!(run["frames_verified"], FRAMES);
        }
        assert!(report["runs"][1]["corrections"].is_object(), "by default costs are measured");
    }
}

#[test]
fn a_cache_that_cannot_be_written_is_no_reason_to_stop() {
    let scratch = Scratch::new("no-cache");
    let small = ["--quiet", "--objects=50", "--frames=2", "--size=32x32", "--device=llvmpipe"];
    let mut command = walkthrough(&scratch.0, &small);
    let output = succeeded(command.env("XDG_CACHE_HOME", "/proc/nowhere"));
    assert!(stderr(&output).contains("pipeline cache"), "{}", stderr(&output));
}

#[test]
fn a_threshold_is_not_exact_and_says_how_wrong_it_can_be() {
    for device in ["llvmpipe", "SwiftShader"] {
        let scratch = Scratch::new(&format!("threshold-{device}"));
        let asked = [
            "--quiet",
            "--objects=1000",
            "--frames=12",
            "--size=192x108",
            "--strategy=frustum,antumbra,antumbra_flags,chc",
            "--verify=every",
            "--validation=sync",
            "--threshold=60",
            "--cost-model=off",
            "--report=report.json",
            "--device",
            device,
        ];
        let output = succeeded(&mut walkthrough(&scratch.0, &asked));
        let table = stdout(&output);
        assert!(table.contains("not exact: objects that show at most 60 pixels"), "{table}");
        assert!(table.contains("without antumbra_flags: ") && !table.contains("WRONG"), "{table}");
        assert!(table.contains("antumbra left out "), "{table}");
        let report = crate::report(&scratch);
        assert_eq!(
            (&report["threshold_pixels"], &report["validation_messages"]),
            (&60.into(), &0.into())
        );
        assert_ne!(report["predicates"], "conditional");
        let runs = report["runs"].as_array().expect("runs");
        let numbers = |key| runs.iter().map(|run| number(&run[key])).collect::<Vec<f64>>();
        let wrong = numbers("pixels_wrong");
        let most = numbers("pixels_wrong_at_most");
        assert_eq!((wrong[0], most[0]), (0.0, 0.0));
        for run in 1..3 {
            assert!(0.0 < wrong[run] && wrong[run] <= most[run], "{wrong:?} {most:?}");
        }
        for (timed, all) in numbers("samples_below_threshold").iter().zip(&most) {
            assert!(timed <= all, "every timed frame was compared, and those that warm up");
        }
    }
}

#[test]
fn strategies_are_listed_without_a_device() {
    let scratch = Scratch::new("list-strategies");
    let mut command = walkthrough(&scratch.0, &["--list-strategies"]);
    let names = stdout(&succeeded(command.env("VK_DRIVER_FILES", "/nonexistent")));
    // The first word of a line is for scripts.
    let first = names.lines().map(|line| line.split(' ').next().unwrap_or_default());
    assert!(first.eq(methods::strategies().into_iter().map(cull::Strategy::name)), "{names}");
    assert!(names.lines().all(|line| line.contains(" exact ")), "{names}");
}

#[test]
#[cfg(feature = "shader-compiler")]
fn wrong_pixels_end_with_1_after_the_table_and_the_report() {
    let scratch = Scratch::new("wrong-pixels");
    let shaders = Scratch::new("wrong-pixels-glsl");
    // Proxies that never show: what they stand for stays hidden for ever.
    let test = "shows_low || shows_high ?";
    let never = "shows_low && !shows_low ?";
    harness::edited_shaders(&shaders, "box.glsl", test, never);
    let folder = shaders.0.to_string_lossy();
    let small = ["--quiet", "--objects=1000", "--frames=12", "--size=96x64", "--device=llvmpipe"];
    let asked = [
        "--strategy=frustum,antumbra",
        "--verify=every",
        "--report=report.json",
        "--shaders",
        &folder,
    ];
    let output =
        walkthrough(&scratch.0, &[&small[..], &asked].concat()).output().expect("it starts");
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(message.starts_with("error: ") && message.contains("antumbra has "), "{message}");
    assert!(stdout(&output).contains("WRONG"));
    let report = crate::report(&scratch);
    assert!(number(&report["runs"][1]["pixels_wrong"]) > 0.0);
    assert_eq!(report["runs"][0]["pixels_wrong"], 0);
}
