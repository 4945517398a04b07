//! The checks on every malformed file, here and by `cargo fuzz`.

use std::ops::ControlFlow;

use crate::{loaded, playback};
use import::{ImportError, Limits, LoadOptions, Source, load_bytes, read};

/// Limits that keep each try fast.
pub fn small_limits() -> Limits {
    const MIB: u64 = 1 << 20;
    Limits {
        json_memory_bytes: 16 * MIB,
        buffer_bytes: 16 * MIB,
        image_bytes: 16 * MIB,
        image_scratch_bytes: 16 * MIB,
        elements: 1 << 20,
        vertices: 1 << 20,
        listed_vertices: 1 << 20,
        corners: 1 << 20,
        nodes: 1 << 16,
        objects: 1 << 16,
        joints: 1 << 16,
        bones: 1 << 16,
        lights: 1 << 12,
        key_values: 1 << 20,
        morph_values: 1 << 20,
        ..Limits::default()
    }
}

/// Reads these bytes as a scene, with everything in it. No bytes may make it panic.
pub fn try_bytes(bytes: &[u8]) -> Result<(), ImportError> {
    let options = LoadOptions { limits: small_limits(), ..LoadOptions::default() };
    let source = read(bytes.to_vec(), None, &options)?;
    read_everything(&source);
    drop(source);
    // Well-formed files can still hold numbers of which no scene can be made.
    let progress_fn = &mut |_| ControlFlow::Continue(());
    if let Ok(imported) = load_bytes(bytes.to_vec(), None, &options, progress_fn) {
        loaded::check(&imported);
        playback::play(imported);
    }
    Ok(())
}

/// Visits all links of the document, by the methods that panic on a bad one.
fn read_everything(source: &Source) {
    let document = &source.document;
    for accessor in document.accessors() {
        let index = accessor.index();
        let count = accessor.count();
        let _ = accessor.view().map(|view| (view.buffer().index(), view.stride(), view.target()));
        let lengths = [
            source.floats::<1>(index).map(|all| all.len()),
            source.floats::<2>(index).map(|all| all.len()),
            source.floats::<3>(index).map(|all| all.len()),
            source.floats::<4>(index).map(|all| all.len()),
            source.floats::<9>(index).map(|all| all.len()),
            source.floats::<16>(index).map(|all| all.len()),
            source.integers::<1>(index).map(|all| all.len()),
            source.integers::<4>(index).map(|all| all.len()),
        ];
        assert!(lengths.iter().flatten().all(|&length| length == count), "accessor {index}");
        assert!(lengths.iter().any(Option::is_some), "accessor {index}");
    }
    read_meshes(source);
    read_nodes(source);
    for material in document.materials() {
        let metallic = material.pbr_metallic_roughness();
        let textures = [metallic.base_color_texture(), metallic.metallic_roughness_texture()];
        let textures = textures.into_iter().chain([material.emissive_texture()]).flatten();
        let indices = textures.map(|info| info.texture().index());
        let normal = material.normal_texture().map(|normal| normal.texture().index());
        let occlusion = material.occlusion_texture().map(|occlusion| occlusion.texture().index());
        for texture in indices.chain(normal).chain(occlusion) {
            let image = source.texture_images[texture].map(|image| &source.images[image]);
            assert!(image.is_none_or(Option::is_some), "texture {texture}");
        }
        let _ = (material.alpha_mode(), material.unlit(), material.emissive_strength());
    }
    for texture in document.textures() {
        let _ = (texture.sampler().wrap_s(), texture.sampler().min_filter(), texture.source());
    }
    for image in source.images.iter().flatten() {
        assert_eq!(image.check(), Ok(()));
    }
}

fn read_meshes(source: &Source) {
    for primitive in source.document.meshes().flat_map(|mesh| mesh.primitives()) {
        let _ = (primitive.mode(), primitive.material().index());
        let vertices = primitive.attributes().next().map(|(_, accessor)| accessor.count());
        for (semantic, accessor) in primitive.attributes() {
            assert_eq!(Some(accessor.count()), vertices, "{semantic:?}");
        }
        for target in primitive.morph_targets() {
            let parts = [target.positions(), target.normals(), target.tangents()];
            assert!(parts.iter().flatten().all(|accessor| Some(accessor.count()) == vertices));
        }
        if let (Some(indices), Some(vertices)) = (primitive.indices(), vertices) {
            let indices = source.integers::<1>(indices.index()).expect("indices are integers");
            // The greatest of its type begins a new strip.
            let is_restart = |index: u32| [0xFF, 0xFFFF, u32::MAX].contains(&index);
            let is_there = |index: u32| (index as usize) < vertices || is_restart(index);
            assert!(indices.iter().all(|&[index]| is_there(index)));
        }
    }
}

fn read_nodes(source: &Source) {
    let document = &source.document;
    let mut seen = vec![false; document.nodes().len()];
    for scene in document.scenes() {
        seen.fill(false);
        let mut waiting: Vec<_> = scene.nodes().collect();
        while let Some(node) = waiting.pop() {
            assert!(
                !std::mem::replace(&mut seen[node.index()], true),
                "node {} twice",
                node.index()
            );
            let _ = (node.mesh().map(|mesh| mesh.index()), node.light().map(|light| light.kind()));
            let _ = node.transform().matrix();
            if let Some(camera) = node.camera() {
                let _ = camera.projection();
            }
            waiting.extend(node.children());
        }
    }
    for channel in
        document.animations().flat_map(|animation| animation.channels().collect::<Vec<_>>())
    {
        let sampler = channel.sampler();
        let _ =
            (channel.target().property(), channel.target().node().index(), sampler.interpolation());
        assert!(source.floats::<1>(sampler.input().index()).is_some(), "keys are at times");
    }
    let _ = document.default_scene();
    for light in document.lights().into_iter().flatten() {
        let _ = (light.kind(), light.range());
    }
}
