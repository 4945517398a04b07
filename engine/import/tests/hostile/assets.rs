//! Tests that whole scenes in the folder `ANTUMBRA_ASSETS` are accepted.

use std::io::Write;
use std::path::PathBuf;

use antumbra_import as import;

#[test]
fn whole_scenes_are_accepted() {
    let Some(folder) = std::env::var_os("ANTUMBRA_ASSETS") else {
        // Not by `eprintln!`, whose output is hidden if the test passes.
        let _told =
            writeln!(std::io::stderr(), "SKIPPED: ANTUMBRA_ASSETS names no folder of scenes");
        return;
    };
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the folder can be read")
        .map(|entry| entry.expect("its entries can be read").path())
        .filter(|path| path.extension().is_some_and(|end| end == "glb" || end == "gltf"))
        .collect();
    scenes.sort();
    assert!(!scenes.is_empty());
    for scene in scenes {
        let source = import::open(&scene, &import::LoadOptions::default()).expect("it is accepted");
        for accessor in source.document.accessors() {
            let index = accessor.index();
            let floats = match accessor.dimensions().multiplicity() {
                1 => source.floats::<1>(index).map(|all| all.len()),
                2 => source.floats::<2>(index).map(|all| all.len()),
                3 => source.floats::<3>(index).map(|all| all.len()),
                4 => source.floats::<4>(index).map(|all| all.len()),
                _ => source.floats::<16>(index).map(|all| all.len()),
            };
            assert_eq!(floats, Some(accessor.count()), "{}, accessor {index}", source.file);
        }
        let images = source.images.iter().flatten().map(|image| image.size);
        eprintln!(
            "{}: images {:?}, notes {:?}",
            source.file,
            images.collect::<Vec<_>>(),
            source.notes
        );
    }
}
