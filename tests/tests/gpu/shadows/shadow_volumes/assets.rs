//! The meshes of real scenes, from the folder that `ANTUMBRA_ASSETS` names.

use std::io::Write;
use std::ops::ControlFlow;

use glam::Vec3;
use import::{LoadOptions, load};
use shadows::{Caps, Extrusion, VolumeEnd, VolumeKind, VolumeMesh, VolumeSource};

const FILES: [&str; 5] =
    ["fox.glb", "kaykit_city.glb", "kaykit_dungeon.glb", "morphstresstest.gltf", "rooms.glb"];

#[test]
fn every_mesh_of_the_scenes_has_volumes() {
    let Some(folder) = std::env::var_os("ANTUMBRA_ASSETS") else {
        // Not by `eprintln!`, whose output is hidden if the test passes.
        let _told =
            writeln!(std::io::stderr(), "SKIPPED: ANTUMBRA_ASSETS names no folder of scenes");
        return;
    };
    let mut kinds = [0, 0];
    for file in FILES {
        let path = std::path::Path::new(&folder).join(file);
        let options = LoadOptions::default();
        let scene = load(&path, &options, &mut |_| ControlFlow::Continue(())).unwrap().scene;
        let skinned_meshes = &scene.surfaces.as_ref().unwrap().skinned_meshes;
        for (id, mesh) in (0..).zip(&scene.meshes) {
            let positions: Vec<Vec3> =
                mesh.vertices.iter().map(|vertex| vertex.position.into()).collect();
            let skinned = skinned_meshes.iter().find(|skinned| skinned.mesh.0 == id);
            let motions = skinned.map(|skinned| skinned.motions(positions.len()));
            let motions = &motions.unwrap_or_default();
            let source = VolumeSource { positions: &positions, triangles: &mesh.indices, motions };
            let volumes = VolumeMesh::new(&source).unwrap();
            let kind = volumes.kind();
            kinds[usize::from(kind == VolumeKind::Robust)] += 1;
            assert!(volumes.triangles().len() as u64 <= mesh.indices.len() as u64 / 3);
            let light = Vec3::new(0.3, 0.9, 0.2).extend(0.0);
            let extrusion = Extrusion { light, kind, caps: Caps::Near, end: VolumeEnd::INFINITY };
            let boundary = extrusion.volumes(&volumes, &positions);
            let is_flat = mesh.indices.is_empty() || volumes.triangles().is_empty();
            assert_eq!(boundary.is_empty(), is_flat, "{file}: {}", mesh.name);
        }
    }
    let [plain, robust] = kinds;
    assert!(plain > 0 && robust > 0, "{plain} plain, {robust} robust");
}
