//! Rules about the manifests of crates: their dependencies and descriptions.

use crate::files::SourceFile;
use crate::{assert_catches, assert_obeyed, assert_permits};

/// The crates of the workspace that each crate may depend on, by any kind of dependency.
const ARROWS: [(&str, &[&str]); 18] = [
    ("engine/animation/Cargo.toml", &["cull"]),
    (
        "engine/antumbra/Cargo.toml",
        &[
            "animation",
            "cull",
            "gpu",
            "import",
            "methods",
            "occlusion",
            "pacing",
            "render",
            "scene",
            "shadows",
        ],
    ),
    (
        "engine/capi/Cargo.toml",
        &["cull", "gpu", "import", "occlusion", "render", "scene", "shadows"],
    ),
    ("engine/cull/Cargo.toml", &[]),
    ("engine/gpu/Cargo.toml", &["shaders"]),
    ("engine/import/Cargo.toml", &["animation", "cull", "scene"]),
    ("engine/methods/Cargo.toml", &["cull", "gpu", "occlusion"]),
    ("engine/occlusion/Cargo.toml", &["cull", "gpu", "shaders"]),
    ("engine/pacing/Cargo.toml", &[]),
    ("engine/render/Cargo.toml", &["cull", "gpu", "occlusion", "scene", "shadows"]),
    ("engine/scene/Cargo.toml", &["cull"]),
    ("engine/shadows/Cargo.toml", &["cull"]),
    // Its folder has the name of the crate wgpu, which no other crate may depend on.
    ("engine/wgpu/Cargo.toml", &["cull", "gpu", "occlusion", "wgpu"]),
    ("samples/Cargo.toml", &["antumbra", "bench", "harness", "scenes", "tests"]),
    ("samples/bench/Cargo.toml", &["antumbra", "harness", "scenes"]),
    ("samples/scenes/Cargo.toml", &["cull", "scene"]),
    (
        "samples/workshop/Cargo.toml",
        &["antumbra", "bench", "harness", "samples", "scenes", "tests"],
    ),
    ("shaders/Cargo.toml", &[]),
];

/// Finds dependencies between crates that [`ARROWS`] does not allow.
pub fn arrows(files: &[SourceFile]) -> Vec<String> {
    const VULKAN: [&str; 3] = ["ash", "ash-window", "gpu-allocator"];
    /// The manifests that may name crates of Vulkan; the window programs need them for one file
    /// ([`EGUI_OVER_VULKAN`](crate::rules::EGUI_OVER_VULKAN)).
    const KNOW_VULKAN: [(&str, &[&str]); 2] =
        [("engine/gpu/Cargo.toml", &VULKAN), ("samples/Cargo.toml", &["ash"])];
    let mut findings = Vec::new();
    for file in files {
        let of_file = ARROWS.iter().find(|(path, _)| *path == file.path);
        let Some((_, allowed)) = of_file else { continue };
        for (line, name) in dependencies(&file.text) {
            let bare = name.strip_prefix("antumbra-").unwrap_or(&name);
            let is_refused = (is_ours(bare) && !allowed.contains(&bare))
                || (VULKAN.contains(&bare)
                    && !KNOW_VULKAN
                        .iter()
                        .any(|(path, names)| *path == file.path && names.contains(&bare)));
            if is_refused {
                findings.push(file.finding(line, &format!("must not depend on {name}")));
            }
        }
    }
    findings
}

/// Returns true for a package of this workspace.
fn is_ours(package: &str) -> bool {
    let folders = ARROWS.iter().filter_map(|(path, _)| path.rsplit('/').nth(1));
    folders.chain(["harness", "tests"]).any(|folder| folder == package)
}

/// Returns the names and packages of a manifest's dependencies, of every kind, with their lines.
fn dependencies(manifest: &str) -> Vec<(usize, String)> {
    let mut names = Vec::new();
    let mut in_dependencies = false;
    for (line, text) in (1..).zip(manifest.lines().map(str::trim)) {
        if let Some(section) = text.strip_prefix('[') {
            let section = section.trim_end_matches(']');
            in_dependencies = section.ends_with("dependencies");
            if let Some((_, name)) = section.rsplit_once("dependencies.") {
                in_dependencies = true;
                names.push((line, name.to_owned()));
            }
        } else if in_dependencies && !text.starts_with('#') {
            let key = text.split(['.', '=', ' ']).next().unwrap_or_default();
            let package = text.split_once("package").and_then(|(_, after)| after.split('"').nth(1));
            names.extend([Some(key), package].into_iter().flatten().map(|n| (line, n.to_owned())));
        }
    }
    names
}

/// Finds dependencies of the measuring crate on window systems and fonts, and on charts unless
/// optional.
pub fn light_instrument(files: &[SourceFile]) -> Vec<String> {
    const OF_WINDOWS: [&str; 7] =
        ["arboard", "egui", "epaint", "evdev", "renderdoc", "tracy-client", "winit"];
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| file.path == "samples/bench/Cargo.toml") {
        for (line, name) in dependencies(&file.text) {
            let text = file.text.lines().nth(line - 1).unwrap_or_default();
            if OF_WINDOWS.contains(&name.as_str()) {
                findings
                    .push(file.finding(line, &format!("{name} belongs to the window programs")));
            } else if name == "plotters" && !text.contains("optional = true") {
                findings.push(file.finding(line, "must be optional: the demo draws no chart"));
            }
        }
    }
    findings
}

/// Finds published crates whose manifest lacks a description for registries, or the target for
/// docs.rs: without one it builds the pages for five systems, with the importer's C++ for each.
pub fn published(files: &[SourceFile]) -> Vec<String> {
    const SHOWN: [&str; 5] = ["description", "license", "readme", "keywords", "categories"];
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| file.path.ends_with("Cargo.toml")) {
        let Some((_, package)) = file.text.split_once("[package]\n") else { continue };
        let lines = || package.lines().take_while(|line| !line.starts_with('['));
        if lines().any(|line| line == "publish = false") {
            continue;
        }
        for key in SHOWN {
            let has = |line: &str| {
                line.strip_prefix(key).is_some_and(|after| after.starts_with([' ', '.']))
            };
            if !lines().any(has) {
                let reason = format!("is published and has no {key}; else say `publish = false`");
                findings.push(file.finding(1, &reason));
            }
        }
        let docs = file.text.split_once("[package.metadata.docs.rs]\n");
        let one_target = |line: &str| line == "targets = [\"x86_64-unknown-linux-gnu\"]";
        if !docs.is_some_and(|(_, docs)| docs.lines().take(2).any(one_target)) {
            findings.push(file.finding(1, "is published and names no target for docs.rs"));
        }
    }
    findings
}

/// Finds packages of the workspace that do not take the workspace's lints, and packages beside it
/// that do not repeat each of them.
pub fn lints(files: &[SourceFile]) -> Vec<String> {
    const MEMBERS: [&str; 4] = ["engine/", "samples/", "shaders/", "tests/"];
    let is_member = |file: &&SourceFile| {
        let begins = MEMBERS.iter().any(|folder| file.path.starts_with(folder));
        begins && file.path.ends_with("Cargo.toml") && file.text.contains("[package]")
    };
    let root = files.iter().find(|file| file.path == "Cargo.toml");
    let root = root.map(|file| file.text.as_str()).unwrap_or_default();
    let all = root.split("[workspace.lints.").skip(1).flat_map(|section| {
        let section = section.split("\n[").next().unwrap_or_default();
        section.lines().filter(|line| line.contains(" = "))
    });
    let all: Vec<&str> = all.collect();
    let takes_all = |file: &&SourceFile| {
        if file.text.contains("\n[workspace]\n") {
            all.iter().all(|lint| file.text.lines().any(|line| line == *lint))
        } else {
            file.text.contains("[lints]\nworkspace = true\n")
        }
    };
    let members = files.iter().filter(is_member);
    members
        .filter(|file| !takes_all(file))
        .map(|file| file.finding(1, "must take the lints of the workspace"))
        .collect()
}

#[test]
fn every_package_takes_the_lints() {
    assert_obeyed(lints);
    let package = "[package]\nname = \"a\"\n";
    assert_catches(lints, &[("engine/a/Cargo.toml", package)]);
    let with = format!("{package}[lints]\nworkspace = true\n");
    assert_permits(lints, &[("engine/a/Cargo.toml", &with), ("examples/a/Cargo.toml", package)]);
    let beside = |lint: &str| {
        let root =
            "[workspace.lints.rust]\n# Why.\nmissing_docs = \"warn\"\n\n[profile.dev]\na = 1\n";
        let own = format!("{package}\n[workspace]\n\n[lints.rust]\n{lint}\n");
        lints(&[SourceFile::new("Cargo.toml", root), SourceFile::new("engine/a/Cargo.toml", &own)])
    };
    assert_eq!(beside("missing_docs = \"warn\"").len(), 0);
    assert_eq!(beside("missing_docs = \"allow\"").len(), 1);
}

#[test]
fn crates_depend_only_downwards() {
    assert_obeyed(arrows);
    assert_catches(
        arrows,
        &[
            ("engine/cull/Cargo.toml", "[dependencies]\ngpu.workspace = true\n"),
            ("engine/cull/Cargo.toml", "[dev-dependencies]\nash = \"0.38\"\n"),
            ("engine/cull/Cargo.toml", "[dependencies]\nx = { package = \"antumbra-gpu\" }\n"),
            ("engine/capi/Cargo.toml", "[dependencies]\nmethods.workspace = true\n"),
            ("engine/pacing/Cargo.toml", "[dependencies]\nash.workspace = true\n"),
            ("engine/pacing/Cargo.toml", "[dependencies]\ncull.workspace = true\n"),
            ("engine/gpu/Cargo.toml", "[dependencies]\ncull.workspace = true\n"),
            (
                "engine/gpu/Cargo.toml",
                "[target.'cfg(unix)'.dependencies]\nrender = { path = \"x\" }\n",
            ),
            ("engine/gpu/Cargo.toml", "[dependencies.cull]\nworkspace = true\n"),
            ("engine/render/Cargo.toml", "[dependencies]\nsamples = { path = \"x\" }\n"),
            ("engine/import/Cargo.toml", "[dependencies]\nrender.workspace = true\n"),
            ("engine/scene/Cargo.toml", "[dev-dependencies]\nscenes.workspace = true\n"),
            ("shaders/Cargo.toml", "[dependencies]\nantumbra-gpu = \"0.1\"\n"),
            ("samples/bench/Cargo.toml", "[dependencies]\nsamples = { path = \"..\" }\n"),
        ],
    );
    let harmless = "[package]\nname = \"antumbra-gpu\"\n[dependencies]\ngpu-allocator = \"1\"\n";
    assert_permits(arrows, &[("engine/gpu/Cargo.toml", harmless)]);
}

#[test]
fn what_measures_is_light() {
    assert_obeyed(light_instrument);
    assert_catches(
        light_instrument,
        &[
            ("samples/bench/Cargo.toml", "[dependencies]\nwinit = \"0.30\"\n"),
            ("samples/bench/Cargo.toml", "[dependencies]\nplotters.workspace = true\n"),
        ],
    );
    let optional = "[dependencies]\nplotters = { workspace = true, optional = true }\n";
    assert_permits(
        light_instrument,
        &[
            ("samples/bench/Cargo.toml", optional),
            ("samples/Cargo.toml", "[dependencies]\nwinit = \"0.30\"\n"),
        ],
    );
}

#[test]
fn published_crates_describe_themselves() {
    assert_obeyed(published);
    let whole = "[package]\ndescription = \"A\"\nlicense.workspace = true\nreadme = \"README.md\"\n\
                 keywords = []\ncategories = []\n\n[package.metadata.docs.rs]\n\
                 targets = [\"x86_64-unknown-linux-gnu\"]\n";
    let without = |key: &str| {
        let lines = whole.lines().filter(|line| !line.starts_with(key));
        lines.map(|line| format!("{line}\n")).collect::<String>()
    };
    for key in ["description", "license", "readme", "keywords", "categories", "targets"] {
        assert_catches(published, &[("a/Cargo.toml", &without(key))]);
    }
    let private = "[package]\npublish = false\n[dependencies]\n";
    assert_permits(published, &[("a/Cargo.toml", whole), ("b/Cargo.toml", private)]);
}
