//! The shaders: the committed SPIR-V matches the GLSL, and shaders and Rust agree on every layout.
#![forbid(unsafe_code)]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod instance_numbers;
mod layouts;

#[cfg(feature = "shader-compiler")]
mod compiling;

use std::path::PathBuf;

use shaders::{Shader, sources};

/// The command to run after a change of a shader.
const REGENERATE: &str = "run `cargo --config ci/shaderc-debian.toml run -p antumbra-gpu \
    --features shader-compiler --example compile_shaders` and commit what it writes";

/// The shaders that `gpu` embeds for itself.
const OF_GPU: [Shader; 4] = [
    shaders::PREDICATE_COUNTS,
    shaders::PREDICATE_INSTANCES,
    shaders::SUM_QUERIES,
    shaders::FARTHEST_DEPTHS,
];

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shaders")
}

fn committed_spirv(name: &str) -> Vec<u8> {
    let file = folder().join(format!("{name}.spv"));
    std::fs::read(&file).unwrap_or_else(|error| panic!("{}: {error}; {REGENERATE}", file.display()))
}

#[test]
fn sources_and_spirv_belong_together() {
    let recorded = std::fs::read_to_string(folder().join("sources.sha256")).unwrap_or_default();
    let found = sources::hashes(&folder()).unwrap();
    let name = |line: &str| line.split_whitespace().last().unwrap_or_default().to_owned();
    let differs = |a: &str, b: &str| -> Vec<String> {
        a.lines().filter(|line| !b.lines().any(|other| other == *line)).map(name).collect()
    };
    let changed = differs(&found, &recorded);
    let gone = differs(&recorded, &found);
    assert!(
        found == recorded,
        "the shaders changed and were not compiled (new or changed: {changed:?}, recorded: \
         {gone:?}); {REGENERATE}"
    );
}

#[test]
fn every_stage_is_embedded_as_it_is_committed() {
    let all = || shaders::PASSES.into_iter().chain(OF_GPU);
    let mut embedded: Vec<&str> = all().map(|shader| shader.name).collect();
    embedded.sort_unstable();
    assert_eq!(sources::stages(&folder()).unwrap(), embedded);
    for shader in all() {
        assert_eq!(shader.spirv, committed_spirv(shader.name), "{}", shader.name);
    }
}
