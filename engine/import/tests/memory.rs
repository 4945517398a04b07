//! Tests that the memory for loading stays below the limits. The process has a single test, since
//! its allocator counts.

#![allow(clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

use antumbra_import::{Limits, LoadOptions, read};
use gltf_files::files::{F32, GltfFile, everything};
use peak_alloc::PeakAlloc;
use serde_json::json;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

const MIB: u64 = 1 << 20;

fn options() -> LoadOptions {
    LoadOptions { limits: limits(), ..LoadOptions::default() }
}

fn limits() -> Limits {
    Limits {
        file_bytes: 64 * MIB,
        json_bytes: 32 * MIB,
        json_memory_bytes: 64 * MIB,
        buffer_bytes: 16 * MIB,
        image_bytes: 16 * MIB,
        image_scratch_bytes: 32 * MIB,
        ..Limits::default()
    }
}

/// Returns the most bytes in use while a file is read, beyond the bytes in use before.
fn peak_of(bytes: Vec<u8>) -> (u64, String) {
    let before = (ALLOCATOR.current_usage() - bytes.len()) as u64;
    ALLOCATOR.reset_peak_usage();
    let result = read(bytes, None, &options()).map(drop);
    let said = result.map_or_else(|error| error.to_string(), |()| "accepted".to_owned());
    (ALLOCATOR.peak_usage() as u64 - before, said)
}

/// Returns `around` with the `@` replaced by repetitions of `text` between commas, nearly as many
/// as the limits allow.
fn repeated(around: &str, text: &str) -> Vec<u8> {
    let times =
        |count: usize| around.replace('@', &[&format!("{text},").repeat(count), text].concat());
    let mut accepted = Vec::new();
    let mut count = 1000;
    loop {
        let bytes = times(count).into_bytes();
        let result = read(bytes.clone(), None, &options());
        if bytes.len() as u64 > limits().json_bytes
            || result.is_err_and(|error| error.to_string().contains("bytes of JSON in memory"))
        {
            return accepted;
        }
        accepted = bytes;
        count = count * 5 / 4;
    }
}

#[test]
fn memory_stays_below_its_bound() {
    let all = limits().memory_bound();
    let json = Limits { buffer_bytes: 0, image_bytes: 0, image_scratch_bytes: 0, ..limits() }
        .memory_bound();
    let mut cases: Vec<(String, Vec<u8>, u64)> = Vec::new();
    for (around, text) in [
        (r#"{"asset":{"version":"2.0"},"nodes":[@]}"#, "{}"),
        (r#"{"asset":{"version":"2.0"},"materials":[@]}"#, "{}"),
        (r#"{"asset":{"version":"2.0"},"samplers":[@]}"#, "{}"),
        (r#"{"asset":{"version":"2.0"},"scenes":[@]}"#, "{}"),
        (r#"{"asset":{"version":"2.0"},"nodes":[@]}"#, r#"{"children":[1]}"#),
        (r#"{"asset":{"version":"2.0"},"nodes":[@]}"#, r#"{"extensions":{"A":0}}"#),
        (r#"{"asset":{"version":"2.0"},"nodes":[@]}"#, r#"{"extensions":{"A":{"B":{}}}}"#),
        (r#"{"asset":{"version":"2.0"},"nodes":[@]}"#, r#"{"name":""}"#),
        (r#"{"asset":{"version":"2.0"},"extensions":{"A":[@]}}"#, "0"),
        (r#"{"asset":{"version":"2.0"},"extensions":{"A":[@]}}"#, "[]"),
        (r#"{"asset":{"version":"2.0"},"extensions":{"A":[@]}}"#, r#"{"":0}"#),
        (r#"{"asset":{"version":"2.0"},"extensions":{"A":[@]},"scenes":[{}]}"#, r#"{"":0}"#),
        (r#"{"asset":{"version":"2.0"},"extensionsUsed":[@]}"#, r#""""#),
        (r#"{"asset":{"version":"2.0"},"extras":[@]}"#, "{}"),
        (r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[@]}]}"#, r#"{"attributes":{}}"#),
        (
            r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{},"targets":[@]}]}]}"#,
            "{}",
        ),
        (r#"{"asset":{"version":"2.0"},"animations":[@]}"#, r#"{"samplers":[],"channels":[]}"#),
        (r#"{"asset":{"version":"2.0"},"nodes":[{"weights":[@]}]}"#, "0"),
        (r#"{"asset":{"version":"2.0"},"nodes":[{"children":[@]}]}"#, "0"),
        (r#"{"asset":{"version":"2.0"},"nodes":[{"name":9999999999},@]}"#, "{}"),
    ] {
        cases.push((format!("{around} of {text}"), repeated(around, text), json));
    }
    cases.push(("large images".to_owned(), images(1400, 1400, 2), all));
    cases.push(("too large images".to_owned(), images(2000, 2000, 2), all));
    cases.push(("everything".to_owned(), everything().glb(), json));
    cases.push(("a data URI".to_owned(), data_uri(15 << 20), all));
    cases.push(("a data URI that is too long".to_owned(), data_uri(20 << 20), all));
    cases.push(("zeros".to_owned(), zeros(), json));
    for (name, bytes, bound) in cases {
        let length = bytes.len();
        let bound = bound - limits().file_bytes + length as u64;
        let (peak, said) = peak_of(bytes);
        let said: String = said.chars().take(120).collect();
        eprintln!("{:6.1} MiB at {length} bytes: {name}: {said}", peak as f64 / MIB as f64);
        assert!(peak <= bound, "{peak} bytes for {name}: {said}; the bound is {bound}");
    }
}

fn images(width: u32, height: u32, count: usize) -> Vec<u8> {
    let pixels = image::RgbaImage::new(width, height);
    let mut scene = GltfFile::triangle();
    let mut images = Vec::new();
    for format in
        [image::ImageFormat::Png, image::ImageFormat::WebP].into_iter().cycle().take(count)
    {
        let mut bytes = std::io::Cursor::new(Vec::new());
        pixels.write_to(&mut bytes, format).expect("it can be encoded");
        images.push(
            json!({ "bufferView": scene.view(&bytes.into_inner()), "mimeType": "image/png" }),
        );
    }
    let textures: Vec<_> = (0..count).map(|source| json!({ "source": source })).collect();
    scene.set("/images", json!(images));
    scene.set("/textures", json!(textures));
    scene.glb()
}

fn data_uri(length: usize) -> Vec<u8> {
    let mut scene = GltfFile::triangle();
    scene.binary.resize(length, 0);
    scene.gltf()
}

fn zeros() -> Vec<u8> {
    let mut scene = GltfFile::triangle();
    scene.set("/accessors/0", json!({ "componentType": F32, "type": "VEC3", "count": 1 << 24 }));
    scene.glb()
}
