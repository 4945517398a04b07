//! The invariants of a loaded scene, for any file.

use import::{GltfScene, PlacedNode};

/// Checks that every number is finite, every index in range, and every box valid.
pub fn check(imported: &GltfScene) {
    imported.scene.validate().expect("it can be drawn");
    check_surfaces(imported);
    check_placements(imported);
    let rig = &imported.rig;
    if !rig.nodes().is_empty() {
        assert_eq!(imported.object_nodes.len(), imported.scene.objects.len());
    }
    assert!(imported.object_nodes.iter().all(|node| (node.0 as usize) < rig.nodes().len()));
    for skin in &imported.skins {
        assert_eq!(skin.joints.len(), skin.inverse_bind.len());
        assert!(skin.joints.iter().all(|joint| (joint.0 as usize) < rig.nodes().len()));
    }
    for clip in &imported.clips {
        assert!(clip.duration_s().is_finite() && !clip.channels.is_empty(), "{}", clip.name);
    }
    let camera = imported.default_camera([3, 2]);
    assert!(camera.eye.is_finite() && camera.near.is_finite() && camera.forward.is_finite());
    assert!(camera.forward.length() > 0.5, "{camera:?}");
}

fn check_surfaces(imported: &GltfScene) {
    let scene = &imported.scene;
    let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
    assert_eq!(scene.meshes.len(), surfaces.meshes.len());
    let sprites: Vec<usize> =
        surfaces.sprites.iter().map(|sprite| sprite.mesh.0 as usize).collect();
    for (place, (mesh, surface)) in scene.meshes.iter().zip(&surfaces.meshes).enumerate() {
        assert_eq!(mesh.vertices.len(), surface.vertices.len());
        let is_seen = !mesh.indices.is_empty() || sprites.binary_search(&place).is_ok();
        assert!(is_seen, "{} draws nothing", mesh.name);
        assert!((surface.material.0 as usize) < surfaces.materials.len());
        for vertex in &surface.vertices {
            let is_unit = |[x, y, z, _]: [i16; 4]| {
                let square = |part: i16| f64::from(part).powi(2);
                let length = (square(x) + square(y) + square(z)).sqrt() / 32767.0;
                (length - 1.0).abs() < 1e-3
            };
            assert!(is_unit(vertex.normal) && is_unit(vertex.tangent), "{vertex:?}");
            assert!(vertex.tangent[3].abs() == 32767);
            assert!(vertex.uv.as_flattened().iter().all(|part| part.is_finite()));
        }
    }
    for material in &surfaces.materials {
        let factors = material.base_colour.iter().chain(&material.emission);
        let others = [material.metallic, material.roughness, material.occlusion_strength];
        assert!(factors.chain(&others).all(|factor| factor.is_finite() && *factor >= 0.0));
        let textures = [
            material.base_colour_texture,
            material.metallic_roughness_texture,
            material.normal_texture,
            material.occlusion_texture,
            material.emission_texture,
        ];
        for used in textures.into_iter().flatten() {
            assert!((used.texture.0 as usize) < surfaces.textures.len() && used.uv_set < 2);
            assert!(used.transform.is_finite());
        }
    }
    assert!(
        surfaces.textures.iter().all(|texture| (texture.image.0 as usize) < surfaces.images.len())
    );
    assert!(!surfaces.lights.is_empty());
    for light in &surfaces.lights {
        assert!(light.position.is_finite() && light.direction.is_normalized(), "{light:?}");
        assert!(light.intensity.is_finite() && light.intensity >= 0.0, "{light:?}");
    }
    for skinned_mesh in &surfaces.skinned_meshes {
        let vertices = scene.meshes[skinned_mesh.mesh.0 as usize].vertices.len();
        for target in &skinned_mesh.targets {
            for list in [&target.positions, &target.normals, &target.tangents] {
                assert!(list.is_empty() || list.len() == vertices);
                assert!(list.as_flattened().iter().all(|part| part.is_finite()));
            }
        }
        let Some(skin) = &skinned_mesh.skin else { continue };
        let sets = skin.sets as usize;
        assert_eq!((skin.joints.len(), skin.weights.len()), (vertices * sets, vertices * sets));
        assert!(
            skin.joints.as_flattened().iter().all(|joint| u32::from(*joint) < skin.joint_count)
        );
        for weights in skin.weights.chunks(sets.max(1)) {
            let sum: f32 = weights.as_flattened().iter().sum();
            assert!((sum - 1.0).abs() < 1e-5, "{weights:?}");
        }
    }
}

fn check_placements(imported: &GltfScene) {
    let scene = &imported.scene;
    let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
    let mut is_skinned = vec![false; scene.meshes.len()];
    for skinned_mesh in &surfaces.skinned_meshes {
        is_skinned[skinned_mesh.mesh.0 as usize] = true;
    }
    for object in scene.objects.iter().chain(&surfaces.transparent) {
        assert!(object.transform.is_finite());
        let bounds = scene.bounds_of(object).expect("its mesh is there");
        assert!(is_skinned[object.mesh.0 as usize] || bounds.is_usable(), "{bounds:?}");
    }
    for placement in &imported.placements {
        assert!((placement.node.0 as usize) < imported.rig.nodes().len());
        assert!(placement.local.is_finite());
        let count = match placement.placed {
            PlacedNode::Object(id) => scene.objects.len() > id.0 as usize,
            PlacedNode::Transparent(id) => surfaces.transparent.len() > id.0 as usize,
            PlacedNode::Light(id) => surfaces.lights.len() > id.0 as usize,
        };
        assert!(count, "{:?}", placement.placed);
        if let Some((skinned_mesh, skin)) = placement.skinned_mesh {
            assert!((skinned_mesh.0 as usize) < surfaces.skinned_meshes.len());
            assert!(skin.is_none_or(|skin| skin < imported.skins.len()));
            assert!(placement.reach.is_usable() && placement.seen_at_rest.is_usable());
        } else {
            assert!(placement.reach.is_empty() && placement.seen_at_rest.is_empty());
        }
    }
}
