//! Tests of files that break a rule which their scene can do without: a note names the object and
//! the reason.

use antumbra_import::{Limits, read};
use serde_json::json;

use gltf_files::files::{GltfFile, encoded, everything};

use crate::refused::Case;

/// Changes without which the scene can be shown, and parts of the notes.
const LEFT_OUT: &[Case] = &[
    (
        |s| s.set("/animations/0/channels/0/sampler", json!(9)),
        &["animation 0, channel 0", "sampler 9"],
    ),
    (
        |s| s.set("/animations/0/channels/0/target/node", json!(9)),
        &["animation 0, channel 0", "node 9"],
    ),
    (
        |s| s.set("/animations/0/samplers/0/input", json!(99)),
        &["animation 0, sampler 0", "accessor 99"],
    ),
    (
        |s| s.set("/animations/0/samplers/1/output", json!(99)),
        &["animation 0, sampler 1", "accessor 99"],
    ),
    (
        |s| s.set("/animations/0/samplers/0/input", json!(0)),
        &["animation 0, sampler 0", "vectors of 3 floats"],
    ),
    (
        |s| s.set("/animations/0/samplers/0/interpolation", json!("BEST")),
        &["animation 0, sampler 0", "interpolation does not exist"],
    ),
    (
        |s| s.remove("/animations/0/samplers/0/interpolation"),
        &["animation 0, channel 0", "2 keys of 1 values each, but its output has 6"],
    ),
    (
        |s| s.set("/animations/0/channels/0/target/path", json!("scale")),
        &["animation 0, channel 0", "vectors of 4 floats"],
    ),
    (
        |s| s.set("/animations/0/channels/0/target/path", json!("colour")),
        &["animation 0, channel 0", "path does not exist"],
    ),
    (
        |s| s.set("/animations/0/channels/1/target/node", json!(0)),
        &["animation 0, channel 1", "node 0, which has no morph targets"],
    ),
    (|s| s.set("/images/0/bufferView", json!(99)), &["image 0", "buffer view 99"]),
    (|s| set_image(s, b"nonsense"), &["image 0", "no PNG, JPEG, WebP or KTX2"]),
    (|s| set_image(s, b""), &["image 0", "no PNG, JPEG, WebP or KTX2"]),
    (|s| set_image(s, b"GIF89a        "), &["image 0", "no PNG, JPEG, WebP or KTX2"]),
    (|s| set_image(s, b"\xABKTX 20\xBB\r\n\x1A\n"), &["image 0", "KTX2 image that cannot be read"]),
    (|s| set_cut_image(s, image::ImageFormat::Png), &["image 0", "cannot be decoded"]),
    (|s| set_cut_image(s, image::ImageFormat::Jpeg), &["image 0", "cut off"]),
    (|s| set_cut_image(s, image::ImageFormat::WebP), &["image 0", "cannot be decoded"]),
    (|s| s.set("/images/0", json!({})), &["image 0", "neither a URI nor a buffer view"]),
    (|s| s.set("/images/0", json!({ "uri": "data:image/png" })), &["image 0", "no comma"]),
    (|s| s.set("/images/0", json!({ "uri": "a.png" })), &["image 0", "read without a folder"]),
];

#[test]
fn what_the_scene_can_do_without_is_left_out_and_named() {
    for &(change, expected) in LEFT_OUT {
        let mut scene = everything();
        change(&mut scene);
        let source = read(scene.glb(), None, &Limits::default());
        let source = source.unwrap_or_else(|error| panic!("{expected:?}: {error}"));
        let texts: Vec<String> = source.notes.iter().map(ToString::to_string).collect();
        let is_noted = |text: &String| expected.iter().all(|part| text.contains(part));
        assert!(texts.iter().any(is_noted), "{texts:?}\nlack a part of {expected:?}");
        assert_eq!(texts.len(), 1, "{texts:?}");
        let is_image = texts[0].contains("checkers are shown for image 0");
        assert_eq!(source.placeholders.contains(&0), is_image, "{texts:?}");
        assert!(is_image || texts[0].contains("animation 0 is not played"), "{texts:?}");
    }
}

fn set_image(scene: &mut GltfFile, bytes: &[u8]) {
    let view = scene.view(bytes);
    scene.set("/images/0", json!({ "bufferView": view, "mimeType": "image/png" }));
}

fn set_cut_image(scene: &mut GltfFile, format: image::ImageFormat) {
    let whole = encoded(format);
    // PNG ends with a checksum and an empty chunk, so that a little less is still a complete
    // image.
    set_image(scene, &whole[..whole.len() - 24]);
}
