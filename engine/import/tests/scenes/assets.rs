//! Tests that whole scenes in the folder `ANTUMBRA_ASSETS` are loaded without losses.

use std::io::Write;
use std::ops::ControlFlow;
use std::path::Path;

use antumbra_import::{LoadOptions, load};

use gltf_files::loaded::check;

/// The expected contents of a scene. The numbers of objects and triangles are published with the
/// files; the other numbers come from the first run and only guard against changes.
struct Expected {
    file: &'static str,
    meshes: usize,
    objects: usize,
    triangles: u64,
    nodes: usize,
    clips: usize,
    lights: usize,
    images: usize,
    skinned_meshes: usize,
    cameras: &'static [&'static str],
    /// True if its white walls would be overexposed.
    is_dimmed: bool,
}

const SCENES: &[Expected] = &[
    Expected {
        file: "rooms.glb",
        meshes: 4,
        objects: 17_416,
        triangles: 65_249_376,
        nodes: 19_475,
        clips: 6,
        lights: 1025,
        images: 0,
        skinned_meshes: 0,
        cameras: &["walk", "fly"],
        is_dimmed: true,
    },
    Expected {
        file: "kaykit_city.glb",
        meshes: 45,
        objects: 18_792,
        triangles: 7_790_320,
        nodes: 34_111,
        clips: 2,
        lights: 1,
        images: 1,
        skinned_meshes: 0,
        cameras: &["street", "fly"],
        is_dimmed: false,
    },
    Expected {
        file: "kaykit_dungeon.glb",
        meshes: 20,
        objects: 2475,
        triangles: 1_560_030,
        nodes: 4877,
        clips: 75,
        lights: 101,
        images: 1,
        skinned_meshes: 0,
        cameras: &["walk", "fly"],
        is_dimmed: false,
    },
    Expected {
        file: "fox.glb",
        meshes: 1,
        objects: 1,
        triangles: 576,
        nodes: 26,
        clips: 3,
        lights: 1,
        images: 1,
        skinned_meshes: 1,
        cameras: &[],
        is_dimmed: false,
    },
    Expected {
        file: "morphstresstest.gltf",
        meshes: 2,
        objects: 2,
        // Both materials are double-sided: front and back count as one.
        triangles: 2412,
        nodes: 1,
        clips: 3,
        lights: 1,
        images: 3,
        skinned_meshes: 2,
        cameras: &[],
        is_dimmed: false,
    },
];

#[test]
fn nothing_of_a_scene_is_lost() {
    let Some(folder) = std::env::var_os("ANTUMBRA_ASSETS") else {
        // Not by `eprintln!`, whose output is hidden if the test passes.
        let _told =
            writeln!(std::io::stderr(), "SKIPPED: ANTUMBRA_ASSETS names no folder of scenes");
        return;
    };
    for expected in SCENES {
        let path = Path::new(&folder).join(expected.file);
        let progress_fn = &mut |_| ControlFlow::Continue(());
        let imported = load(&path, &LoadOptions::default(), progress_fn).expect("it is loaded");
        check(&imported);
        let scene = &imported.scene;
        let surfaces = scene.surfaces.as_ref().expect("surfaces");
        let cameras: Vec<_> = imported.cameras.iter().map(|camera| camera.name.as_str()).collect();
        let file = expected.file;
        assert_eq!(file.split('.').next(), Some(scene.name.as_str()));
        assert_eq!(scene.meshes.len(), expected.meshes, "{file}");
        assert_eq!(scene.objects.len() + surfaces.transparent.len(), expected.objects, "{file}");
        assert_eq!(scene.triangles(), expected.triangles, "{file}");
        assert_eq!(imported.rig.nodes().len(), expected.nodes, "{file}");
        assert_eq!(imported.clips.len(), expected.clips, "{file}");
        assert_eq!(surfaces.lights.len(), expected.lights, "{file}");
        assert_eq!(surfaces.images.len(), expected.images, "{file}");
        assert_eq!(surfaces.skinned_meshes.len(), expected.skinned_meshes, "{file}");
        assert_eq!(cameras, expected.cameras, "{file}");
        let [dimmed, others] = [true, false].map(|is_dimmed| {
            let notes = imported.notes.iter();
            notes.filter(|note| note.reason.contains("dimmed") == is_dimmed).count()
        });
        assert_eq!((dimmed == 1, others), (expected.is_dimmed, 0), "{file}: {:?}", imported.notes);
    }
}
