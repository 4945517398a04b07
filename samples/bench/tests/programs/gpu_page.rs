//! Runs `gpu_page` as `ci/gpu` does, with small inputs, on both software drivers.

use std::fs;
use std::process::Command;

use harness::Scratch;

use crate::{refusal, succeeded, walkthrough};

fn gpu_page(scratch: &Scratch, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gpu_page"));
    command.current_dir(&scratch.0).args(arguments);
    command
}

/// Walks with a few small frames, and writes a report to the folder `reports`.
fn walk(scratch: &Scratch, device: &str, name: &str, more: &[&str]) {
    let report = format!("reports/{name}.json");
    let common = ["--frames=4", "--size=64x48", "--quiet", "--device", device];
    let all = [&common[..], &["--strategy=frustum,antumbra,ideal", "--report", &report], more];
    succeeded(&mut walkthrough(&scratch.0, &all.concat()));
}

#[test]
fn a_page_of_each_driver_is_made() {
    let most = ["--most=10", "--rounds=1", "--size=64x48", "--validation=sync"];
    let told = ["--commit=abc", "--uncommitted", "--left-out=left-out.txt"];
    let fences = concat!(env!("CARGO_MANIFEST_DIR"), "/fences.gltf");
    for (device, stem) in [("llvmpipe", "llvmpipe"), ("swiftshader", "swiftshader")] {
        let scratch = Scratch::new(&format!("gpu-page-{device}"));
        fs::create_dir_all(scratch.0.join("reports")).expect("writable");
        fs::write(scratch.0.join("left-out.txt"), "it lacks counts\n").expect("writable");
        walk(&scratch, device, "timed", &["--objects=100"]);
        walk(&scratch, device, "lit", &["--objects=100", "--lights=4", "--shadows=volumes"]);
        let checked = ["--verify=every", "--validation=sync"];
        walk(&scratch, device, "compared", &[&checked[..], &["--objects=100"]].concat());
        let textured = ["--scene", fences, "--lights=sun", "--shadows=maps", "--msaa=4"];
        walk(&scratch, device, "textured", &[&checked[..], &textured].concat());
        let arguments = ["--device", device, "--reports=reports", "--out=out"];
        succeeded(&mut gpu_page(&scratch, &[&arguments[..], &most, &told].concat()));
        let files = scratch.names("out");
        assert_eq!(files.len(), 2, "{files:?}");
        let page = files.iter().find(|file| file.ends_with(".md")).expect("a page");
        assert!(page.starts_with(stem), "{page}");
        let page = fs::read_to_string(scratch.0.join("out").join(page)).expect("a page");
        for part in [
            "commit abc and changes that are not committed",
            "draws on the CPU",
            "Nothing is broken.",
            "| city street | 100 | ",
            "| fences.gltf walk, 4 samples per pixel, sun, shadow maps | 81 | ",
            "| core and synchronization | 3 | 24 | 0 |",
            "| `frustum` | the baseline: all that is in the view frustum | 16 | 0 |",
            " | promises no exactness |  |",
            "\n- it lacks counts\n",
            "| city street, 4 lamps, shadow volumes | 100 | 64x48 | `antumbra` |",
            "| item | 1 | 10 |",
            "| draws skipped by instances |",
            "| large boxes by flags |",
            "| draws in calls of 10 | - | ",
            "| resets of queries by the CPU |",
            "| resets of queries by a command |",
            "| breaks of a rendering |",
            "| `antumbra` |",
        ] {
            assert!(page.contains(part), "{part} is missing in\n{page}");
        }
        assert_eq!(page.contains("| draws taken by conditional |"), device == "llvmpipe");
        // SwiftShader evaluates depth and coverage of a sample at different positions.
        assert_eq!(page.contains("without `antumbra`, `ideal`: "), device == "swiftshader");
    }
}

#[test]
fn reports_of_another_device_are_refused() {
    let scratch = Scratch::new("gpu-page-other");
    fs::create_dir_all(scratch.0.join("reports")).expect("writable");
    walk(&scratch, "swiftshader", "timed", &["--objects=100"]);
    let mut other = gpu_page(&scratch, &["--device=llvmpipe", "--reports=reports", "--out=out"]);
    let message = refusal(&mut other, 2);
    assert!(message.contains("is a report of SwiftShader"), "{message}");
}
