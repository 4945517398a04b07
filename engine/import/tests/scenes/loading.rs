//! Loading of files that tests build, and tests of loading itself.

use std::ops::ControlFlow;

use antumbra_import::{
    Cause, GltfScene, ImportError, Limits, LoadOptions, Note, Progress, Stage, load_bytes,
};
use serde_json::json;

use gltf_files::files::{GltfFile, everything};
use gltf_files::loaded::check;

/// Returns the result of loading with the default options.
pub fn try_load(scene: &GltfFile) -> Result<GltfScene, ImportError> {
    let options = LoadOptions::default();
    load_bytes(scene.glb(), None, &options, &mut |_| ControlFlow::Continue(()))
}

/// Returns the scene of a file that must load, and checks everything in it.
pub fn load(scene: &GltfFile) -> GltfScene {
    let imported = try_load(scene).unwrap_or_else(|error| panic!("{error}"));
    check(&imported);
    imported
}

/// Returns the error of a file that must not load.
pub fn refused(scene: &GltfFile) -> String {
    match try_load(scene) {
        Ok(_) => panic!("it was loaded"),
        Err(error) => error.to_string(),
    }
}

/// Returns true if the reason of a note begins with `beginning`.
pub fn notes(imported: &GltfScene, beginning: &str) -> bool {
    imported.notes.iter().any(|note| note.reason.starts_with(beginning))
}

/// Returns true if a note whose object and reason begin with these texts has this count.
pub fn counts(imported: &GltfScene, object: &str, reason: &str, count: u64) -> bool {
    let is_it = |note: &Note| note.object.starts_with(object) && note.reason.starts_with(reason);
    imported.notes.iter().any(|note| is_it(note) && note.count == count)
}

#[test]
fn a_file_with_everything_in_it_is_loaded() {
    let imported = load(&everything());
    let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
    assert_eq!(imported.scene.objects.len(), 3, "two instances, one with a skin");
    assert_eq!((imported.cameras.len(), surfaces.lights.len(), surfaces.images.len()), (1, 1, 3));
    assert_eq!((imported.clips.len(), imported.skins.len()), (1, 1));
    assert_eq!(imported.notes, []);
}

#[test]
fn progress_goes_on_and_can_be_broken_off() {
    let bytes = everything().glb();
    let mut reports: Vec<Progress> = Vec::new();
    let progress_fn = &mut |progress| {
        reports.push(progress);
        ControlFlow::Continue(())
    };
    load_bytes(bytes.clone(), None, &LoadOptions::default(), progress_fn).expect("it is loaded");
    assert_eq!(reports[0], Progress { stage: Stage::Reading, fraction: 0.0 });
    assert_eq!(reports.last().map(|report| report.stage), Some(Stage::Meshes));
    assert!(reports.iter().all(|report| (0.0..=1.0).contains(&report.fraction)));
    let reading = reports.iter().filter(|report| report.stage == Stage::Reading);
    let images: Vec<u32> = reading.map(|report| (report.fraction * 3.0).round() as u32).collect();
    assert_eq!(images, [0, 1, 2, 3], "it goes on with the images");
    for calls in 0..reports.len() {
        let mut left = calls;
        let progress_fn = &mut |_| match left {
            0 => ControlFlow::Break(()),
            _ => {
                left -= 1;
                ControlFlow::Continue(())
            }
        };
        let given_up = load_bytes(bytes.clone(), None, &LoadOptions::default(), progress_fn);
        assert_eq!(given_up.expect_err("given up").cause, Cause::GivenUp);
    }
}

#[test]
fn what_grows_while_it_is_made_counts_against_the_limits() {
    let mut scene = GltfFile::triangle();
    scene.set("/materials", json!([{ "doubleSided": true }]));
    scene.set("/meshes/0/primitives/0/material", json!(0));
    let with = |vertices: u64, corners: u64| {
        let limits = Limits { vertices, corners, ..Limits::default() };
        let options = LoadOptions { limits, ..LoadOptions::default() };
        load_bytes(scene.glb(), None, &options, &mut |_| ControlFlow::Continue(()))
    };
    assert!(with(6, 6).is_ok());
    for (vertices, corners, word) in [(5, 6, "5 vertices"), (6, 5, "5 corners")] {
        let error = with(vertices, corners).expect_err("beyond the limit");
        assert_eq!(error.cause, Cause::TooLarge);
        let said = error.to_string();
        assert!(said.contains("mesh 0, primitive 0") && said.contains(word), "{said}");
    }
}

#[test]
fn an_empty_scene_is_a_scene() {
    let mut scene = GltfFile::triangle();
    scene.set("/nodes", json!([{ "name": "nothing" }]));
    let imported = load(&scene);
    assert!(imported.scene.objects.is_empty() && imported.scene.meshes.is_empty());
    assert!(notes(&imported, "there is nothing to see"));
}

#[test]
fn what_is_large_and_seen_once_is_cut_and_what_is_shared_is_not() {
    let mut scene = GltfFile::triangle();
    let row = |place: usize| {
        let x = place as f32;
        [x, 0.0, 0.0, x + 1.0, 0.0, 0.0, x, 1.0, 0.0]
    };
    let places: Vec<f32> = (0..100).flat_map(row).collect();
    let positions = scene.floats("VEC3", &places);
    scene.set("/meshes/0/primitives/0", json!({ "attributes": { "POSITION": positions } }));
    let with = |scene: &GltfFile, cut_above_triangles: Option<usize>| {
        let options = LoadOptions { cut_above_triangles, ..LoadOptions::default() };
        let progress_fn = &mut |_| ControlFlow::Continue(());
        load_bytes(scene.glb(), None, &options, progress_fn).expect("it is loaded").scene
    };
    let cut = with(&scene, Some(80));
    assert_eq!((cut.objects.len(), cut.meshes.len(), cut.triangles()), (16, 16, 100));
    assert!(cut.meshes.iter().all(|mesh| mesh.triangles() <= 10));
    assert_eq!(cut.meshes[3].name, "mesh 0, piece 3");
    assert_eq!(with(&scene, Some(100)).meshes.len(), 1);
    assert_eq!(with(&scene, None).meshes.len(), 1);
    scene.set("/nodes/1", json!({ "mesh": 0 }));
    scene.set("/scenes/0/nodes", json!([0, 1]));
    let shared = with(&scene, Some(80));
    assert_eq!((shared.objects.len(), shared.meshes.len()), (2, 1));
}
