//! Tests whether faults are tolerated or refuse a file, depending on the shown elements.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use antumbra_import::{GltfScene, ImportError, LoadOptions, load_bytes};
use serde_json::{Value, json};

use super::deviations::{LEFT_OUT, SHOWN, SPELLINGS};
use super::replaced::REPLACED;
use super::unused::{ASIDE, UNUSED};
use crate::strict;
use gltf_files::files::{F32, GltfFile, everything};
use gltf_files::loaded;
use gltf_files::playback::play;

/// The outcome of loading a file.
#[derive(Clone, Copy, Debug)]
pub enum Outcome {
    /// A file that opens without a note.
    Opens,
    /// A file that opens with one note, which has these parts.
    Noted(&'static [&'static str]),
    /// A file that opens with one note, which has this part: the fault is not in a shown element.
    Unused(&'static str),
    /// A file that opens with one note, which has these parts. If broken parts are refused, the
    /// error has the same parts.
    Broken(&'static [&'static str]),
    /// A file that is refused with an error that has these parts.
    Refused(&'static [&'static str]),
}

/// A situation, the change of a file with all features, and its outcome.
pub type Row = (&'static str, fn(&mut GltfFile), Outcome);

fn load(bytes: Vec<u8>) -> Result<GltfScene, ImportError> {
    load_with(bytes, &LoadOptions::default())
}

fn load_with(bytes: Vec<u8>, options: &LoadOptions) -> Result<GltfScene, ImportError> {
    load_bytes(bytes, None, options, &mut |_| ControlFlow::Continue(()))
}

/// Returns the notes that are not mere remarks.
fn texts(imported: &GltfScene) -> Vec<String> {
    let is_plain = |text: &String| {
        text.contains("scenes, only scene") || text.contains("the file has no light")
    };
    imported.notes.iter().map(ToString::to_string).filter(|text| !is_plain(text)).collect()
}

#[test]
fn what_is_shown_decides() {
    let lists = [UNUSED, ASIDE, SPELLINGS, SHOWN, REPLACED, LEFT_OUT];
    assert!(lists.iter().map(|list| list.len()).sum::<usize>() >= 60);
    let mut wrong = Vec::new();
    for &(name, change, outcome) in lists.into_iter().flatten() {
        let mut scene = everything();
        change(&mut scene);
        for bytes in [scene.glb(), scene.gltf()] {
            let result = load(bytes.clone());
            let strict = load_with(bytes, &strict()).map(drop);
            if !is_as_expected(&result, outcome) || !is_strict_as_expected(&strict, outcome) {
                let said = result.as_ref().map(texts).map_err(ToString::to_string);
                let strict = strict.map_err(|error| error.to_string());
                wrong.push(format!("{name}: {said:?}, strictly {strict:?}, not {outcome:?}"));
            }
            if let Ok(imported) = result {
                loaded::check(&imported);
                play(imported);
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn is_as_expected(result: &Result<GltfScene, ImportError>, outcome: Outcome) -> bool {
    let has = |text: &String, parts: &[&str]| parts.iter().all(|part| text.contains(part));
    match (result, outcome) {
        (Ok(imported), Outcome::Opens) => imported.notes.is_empty(),
        (Ok(imported), Outcome::Noted(parts) | Outcome::Broken(parts)) => {
            matches!(texts(imported).as_slice(), [text] if has(text, parts))
        }
        (Ok(imported), Outcome::Unused(part)) => {
            let parts = [part, "nothing that is shown uses it"];
            let is_once = imported.notes.iter().all(|note| note.count == 1);
            is_once && matches!(texts(imported).as_slice(), [text] if has(text, &parts))
        }
        (Err(error), Outcome::Refused(parts)) => has(&error.to_string(), parts),
        _ => false,
    }
}

/// Returns true if the result with broken parts refused fits the outcome.
fn is_strict_as_expected(strict: &Result<(), ImportError>, outcome: Outcome) -> bool {
    match (strict, outcome) {
        (Err(error), Outcome::Broken([first, ..]) | Outcome::Refused([first, ..])) => {
            error.to_string().contains(first)
        }
        (strict, _) => strict.is_ok(),
    }
}

/// Appends to a list.
pub fn add(scene: &mut GltfFile, list: &str, value: Value) {
    scene.push(list, value);
}

/// Appends a buffer to the file's buffers.
pub fn buffer(scene: &mut GltfFile, value: Value) {
    let own = GltfFile { json: json!({}), binary: scene.binary.clone() };
    let data = json!({ "byteLength": own.binary.len(), "uri": own.data_uri() });
    scene.set("/buffers", json!([data, value]));
}

/// Appends an accessor with one changed field.
pub fn accessor(scene: &mut GltfFile, key: &str, value: Value) {
    let at = scene.push("accessors", json!({ "componentType": F32, "type": "VEC3", "count": 3 }));
    scene.set(&format!("/accessors/{at}/{key}"), value);
}

/// Appends a light.
pub fn light(scene: &mut GltfFile, value: Value) {
    scene.set("/extensions/KHR_lights_punctual/lights/1", value);
}

/// Gives the first node a matrix with one number that makes it neither a rotation nor a scale.
pub fn matrix(scene: &mut GltfFile, place: usize, number: f32) {
    let mut matrix = [0.0; 16];
    [0, 5, 10, 15].into_iter().for_each(|place| matrix[place] = 1.0);
    matrix[place] = number;
    scene.set("/nodes/0/matrix", json!(matrix));
}

/// Returns the accessor of an animation's keys, which nothing else uses.
pub fn keys(scene: &mut GltfFile) -> usize {
    let at = scene.floats("SCALAR", &[0.0, 1.0]);
    scene.set("/animations/0/samplers/1/input", json!(at));
    at
}

/// Moves the first image, or the keys of the animation, to a buffer that does not exist.
pub fn elsewhere(scene: &mut GltfFile, is_image: bool) {
    let at = keys(scene);
    buffer(scene, json!({ "byteLength": 8, "uri": "gone.bin" }));
    let view = scene.push("bufferViews", json!({ "buffer": 1, "byteLength": 8 }));
    let place = if is_image {
        "/images/0/bufferView".to_owned()
    } else {
        format!("/accessors/{at}/bufferView")
    };
    scene.set(&place, json!(view));
}

/// Writes all whole numbers as `1.0`.
pub fn as_floats(value: &mut Value) {
    match value {
        Value::Number(number) => *value = json!(number.as_f64()),
        Value::Array(list) => list.iter_mut().for_each(as_floats),
        Value::Object(entries) => entries.values_mut().for_each(as_floats),
        _ => {}
    }
}

/// Adds vendor properties to all objects except those whose keys are names.
pub fn vendor(value: &mut Value) {
    match value {
        Value::Array(list) => list.iter_mut().for_each(vendor),
        Value::Object(entries) => {
            let others = entries.iter_mut().filter(|(key, _)| *key != "attributes");
            for (key, value) in others {
                match value {
                    // Their keys are names.
                    Value::Object(named) if key == "extensions" => {
                        named.values_mut().for_each(vendor);
                    }
                    value => vendor(value),
                }
            }
            let is_target = entries.contains_key("POSITION");
            if !is_target {
                entries.insert("vendorThing".to_owned(), json!({ "a": [1.5, null] }));
            }
        }
        _ => {}
    }
}

/// Loads a file within the time limit, whatever the outcome.
fn quickly(scene: &GltfFile) -> Result<GltfScene, ImportError> {
    let start = Instant::now();
    let result = load(scene.glb());
    assert!(start.elapsed() < Duration::from_secs(20), "took {:?}", start.elapsed());
    result
}

#[test]
fn many_broken_elements_are_one_note_or_refused() {
    let mut scene = everything();
    let broken = json!({ "componentType": F32, "type": "VEC5", "count": 1 });
    let list = scene.json["accessors"].as_array_mut().expect("a list");
    let first = list.len();
    list.extend(std::iter::repeat_n(broken, 100_000));
    let imported = quickly(&scene).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(imported.notes.len(), 1, "{:?}", imported.notes);
    assert_eq!(imported.notes[0].object, format!("accessor {first}"));
    assert_eq!(imported.notes[0].count, 100_000);
    // A fault in place of an accessor could take far more memory than its text.
    let list = scene.json["accessors"].as_array_mut().expect("a list");
    list.truncate(first);
    list.extend(std::iter::repeat_n(json!(1), 5_000));
    let error = quickly(&scene).map(drop).expect_err("too much is broken").to_string();
    assert!(error.contains("it must be an object, and is 1"), "{error}");
}

#[test]
fn broken_images_and_clips_are_noted_up_to_a_bound() {
    let mut scene = everything();
    scene.set("/images", json!(vec![json!({ "uri": "gone.png" }); 200]));
    scene.show_images(200);
    let imported = quickly(&scene).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(imported.notes.len(), 65);
    assert_eq!(imported.notes[64].reason, "136 more are left out");
    assert_eq!(imported.scene.surfaces.expect("surfaces").images.len(), 200);
    let mut scene = everything();
    accessor(&mut scene, "count", json!(0));
    let at = scene.json["accessors"].as_array().expect("a list").len() - 1;
    let sampler = json!({ "input": at, "output": at });
    let channel = json!({ "sampler": 0, "target": { "node": 2, "path": "rotation" } });
    let clip = json!({ "samplers": [sampler], "channels": vec![channel; 50_000] });
    scene.set("/animations", json!([clip, clip]));
    let imported = quickly(&scene).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((imported.clips.len(), imported.notes.len()), (0, 2), "{:?}", imported.notes);
}

#[test]
fn a_chain_whose_nodes_are_all_named_as_roots_is_shown_once() {
    let depth = 100_000;
    let mut scene = GltfFile::triangle();
    let mut nodes: Vec<Value> = (1..depth).map(|child| json!({ "children": [child] })).collect();
    nodes.push(json!({ "mesh": 0 }));
    scene.set("/nodes", json!(nodes));
    scene.set("/scenes/0/nodes", json!((0..depth).rev().collect::<Vec<_>>()));
    let imported = quickly(&scene).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((imported.rig.nodes().len(), imported.scene.objects.len()), (depth, 1));
    let once = imported.notes.iter().find(|note| note.reason.contains("shown once"));
    assert_eq!(once.map(|note| note.count), Some(depth as u64 - 1));
    // A cycle that is not shown, and one that is shown.
    scene.set("/scenes/0/nodes", json!([]));
    scene.set(&format!("/nodes/{}/children", depth - 1), json!([0]));
    let imported = quickly(&scene).unwrap_or_else(|error| panic!("{error}"));
    assert!(texts(&imported).iter().any(|text| text.contains("its own ancestor")));
    // It is cut at the listed node, and shown.
    scene.set("/scenes/0/nodes", json!([5]));
    let imported = quickly(&scene).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((imported.rig.nodes().len(), imported.scene.objects.len()), (depth, 1));
    let cut = "node 4, children: node 5 would be its own ancestor";
    assert!(texts(&imported).iter().any(|text| text.contains(cut)), "{:?}", imported.notes);
}

#[test]
fn numbers_beyond_64_bits_are_faults_of_what_they_are_in() {
    use Outcome::*;
    let rows: &[Row] = &[
        (
            "an unused node",
            |s| s.set("/nodes/4", json!({ "scale": [1, 1, 7e77] })),
            Unused("node 4: its scale is"),
        ),
        (
            "an unused node's mesh",
            |s| s.set("/nodes/4", json!({ "mesh": 7e77 })),
            Unused("node 4, mesh: it must be"),
        ),
        (
            "an unused camera",
            |s| {
                let lens = json!({ "yfov": 1, "znear": 7e77 });
                s.set("/cameras/1", json!({ "type": "perspective", "perspective": lens }))
            },
            Unused("camera 1: its projection is beyond"),
        ),
        ("extras", |s| s.set("/nodes/0/extras", json!({ "far": 7e77 })), Opens),
        ("another's", |s| s.set("/nodes/0/VENDOR_x", json!([7e77])), Opens),
        (
            "bounds",
            |s| s.set("/accessors/0/max", json!([7e77, 1, 0])),
            Noted(&["accessor 0: its min"]),
        ),
        (
            "a node",
            |s| s.set("/nodes/0/scale", json!([1, 7e77, 1])),
            Broken(&["node 0: its scale is"]),
        ),
        (
            "a camera",
            |s| s.set("/cameras/0/perspective/znear", json!(7e77)),
            Broken(&["camera 0: its"]),
        ),
    ];
    for &(name, change, outcome) in rows {
        let mut scene = everything();
        change(&mut scene);
        let text = String::from_utf8(scene.gltf()).expect("JSON");
        assert!(text.contains("7e77") || text.contains("7e+77"), "{text}");
        let text = text.replace("7e77", "7e777").replace("7e+77", "-7e+777");
        let result = load(text.into_bytes());
        let said = result.as_ref().map(texts).map_err(ToString::to_string);
        assert!(is_as_expected(&result, outcome), "{name}: {said:?}, not {outcome:?}");
    }
}

#[test]
fn names_that_occur_twice_are_noted() {
    let text = String::from_utf8(GltfFile::triangle().gltf()).expect("JSON");
    let twice = text.replacen("{", "{\"scene\":0,", 1);
    let imported = load(twice.into_bytes()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(imported.scene.objects.len(), 1);
    assert!(texts(&imported)[0].contains("JSON: a name occurs twice"), "{:?}", imported.notes);
}
