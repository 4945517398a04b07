//! Tests of truncated containers, and of files that are not containers.

use antumbra_import::{LoadOptions, read};
use serde_json::json;

use gltf_files::files::{GltfFile, everything, glb_of};
use gltf_files::target::try_bytes;

fn refused(bytes: &[u8]) -> String {
    match read(bytes.to_vec(), None, &LoadOptions::default()) {
        Ok(_) => panic!("it was accepted"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn a_file_that_is_cut_off_anywhere_is_refused() {
    let scene = everything();
    for whole in [scene.glb(), scene.gltf()] {
        assert_eq!(try_bytes(&whole), Ok(()));
        for length in 0..whole.len() {
            assert!(try_bytes(&whole[..length]).is_err(), "accepted when cut off at {length}");
        }
    }
}

#[test]
fn headers_that_lie_are_named() {
    let glb = GltfFile::triangle().glb();
    let with = |at: usize, bytes: &[u8]| {
        let mut changed = glb.clone();
        changed[at..at + bytes.len()].copy_from_slice(bytes);
        refused(&changed)
    };
    assert!(with(4, &[1]).contains("GLB header: version 1"));
    assert!(with(8, &[255; 4]).contains("GLB header: says 4294967295 bytes"));
    assert!(with(8, &[11, 0, 0, 0]).contains("no JSON chunk"));
    assert!(with(8, &[15, 0, 0, 0]).contains("GLB chunk 0: its header is cut off"));
    assert!(with(12, &[255; 4]).contains("GLB chunk 0: says 4294967295 bytes"));
    assert!(with(16, b"BIN\0").contains("GLB chunk 0: must be the JSON"));
    assert!(refused(b"glTF").contains("GLB header: cut off after 4 bytes"));
}

#[test]
fn what_is_no_json_is_named() {
    for text in
        ["", "{", "[]", "null", "{\"asset\":{\"version\":\"2.0\"}} x", "\u{0}", "{\"asset\":1e}"]
    {
        assert!(refused(text.as_bytes()).contains("JSON") || text.is_empty(), "{text}");
        assert!(refused(&glb_of(&[(b"JSON", text.as_bytes())])).contains(": "), "{text}");
    }
    assert!(refused(b"\xFF\xFE{}").contains("JSON"));
    let deep = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"extras\":{}1{}}}",
        "[".repeat(500_000),
        "]".repeat(500_000)
    );
    // Extras have no meaning, so their depth does no harm. In a supported extension it would.
    let _ = try_bytes(deep.as_bytes());
    let deep = deep.replace("\"extras\":", "\"extensions\":{\"X\":").replace("1]", "1}]");
    assert!(try_bytes(deep.as_bytes()).is_err());
}

#[test]
fn buffers_must_come_from_somewhere() {
    let mut scene = GltfFile::triangle();
    scene.set("/buffers", json!([{ "byteLength": 44 }, { "byteLength": 4 }]));
    let source = read(scene.glb(), None, &LoadOptions::default()).expect("nothing uses buffer 1");
    let note = source.notes[0].to_string();
    assert!(note.contains("buffer 1: it has no URI") && note.contains("nothing that is shown"));
    scene.set("/bufferViews/0/buffer", json!(1));
    scene.set("/buffers/1/byteLength", json!(44));
    assert!(refused(&scene.glb()).contains("buffer 1: it has no URI"));
    scene.set("/bufferViews/0/buffer", json!(0));
    assert!(refused(&scene.gltf()).contains("buffer 0: it has no URI"));
}
