//! Meshes and materials that do not fit, or that a scene cannot show.

use glam::{Affine2, Vec2, Vec3};
use render::{
    Error, MaterialError, MeshError, Renderer, SpareCapacity, TextureCapacity, TextureError,
};
use scene::{
    Alpha, Encoding, Image, Material, MaterialId, MeshId, Object, ObjectChange, PreparedMesh,
    PreparedTexture, Sampler, TextureId, TextureUse,
};
use tests::window_fixture::Random;
use tests::{Driver, run};

use super::scenes::{
    Kind, SPARE, first_scene, object, options, rooms, some_mesh, spare, surface_of,
};

/// Returns the index of a refused mesh, and the reason.
fn of_mesh(error: Error) -> (usize, MeshError) {
    match error {
        Error::Mesh { index, reason } => (index, reason),
        other => panic!("{other}"),
    }
}

/// Returns the index of a refused material, and the reason.
fn of_material(error: Error) -> (usize, MaterialError) {
    match error {
        Error::Material { index, reason } => (index, reason),
        other => panic!("{other}"),
    }
}

#[test]
fn a_mesh_that_does_not_fit_is_refused_by_name_and_changes_nothing() {
    run(Driver::Lavapipe, |device| {
        let mut random = Random::new(5);
        let spare = SpareCapacity { meshes: 1, ..SPARE };
        let [plain, surfaces] = [Kind::Plain, Kind::Surfaces].map(first_scene);
        let mut plain = Renderer::new(device, &plain, &options(spare.clone())).unwrap();
        let mut lit = Renderer::new(device, &surfaces, &options(spare)).unwrap();
        let [bare, whole] =
            [Kind::Plain, Kind::Surfaces].map(|kind| some_mesh(&mut random, kind, MaterialId(0)));
        let of = |material| {
            let surface = surface_of(whole.mesh(), MaterialId(material));
            PreparedMesh::with_surface(whole.mesh().clone(), surface, Vec::new()).unwrap()
        };
        let refused = |renderer: &mut Renderer, meshes: Vec<PreparedMesh>, reason: &str| {
            let error = renderer.add_meshes(meshes).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        };
        let error = plain.add_meshes(vec![whole.clone()]).unwrap_err();
        assert_eq!(of_mesh(error), (0, MeshError::NoSurfaces));
        let error = lit.add_meshes(vec![whole.clone(), bare.clone()]).unwrap_err();
        assert_eq!(of_mesh(error), (1, MeshError::SurfaceMissing));
        let error = lit.add_meshes(vec![of(2)]).unwrap_err();
        assert_eq!(of_mesh(error), (0, MeshError::Transparent));
        let error = lit.add_meshes(vec![of(3)]).unwrap_err();
        assert_eq!(of_mesh(error), (0, MeshError::UnknownMaterial));
        refused(&mut plain, vec![bare.clone(); 2], "no room for 1 meshes");
        let added = plain.add_meshes(vec![bare.clone()]).unwrap();
        refused(&mut plain, vec![bare.clone()], "RendererOptions::spare");
        let twice = plain.remove_meshes(&[added[0], added[0]]).unwrap_err();
        assert_eq!(of_mesh(twice), (1, MeshError::NamedTwice));
        let unknown = plain.remove_meshes(&[added[0], MeshId(77)]).unwrap_err();
        assert_eq!(of_mesh(unknown), (1, MeshError::UnknownMesh));
        let scene = first_scene(Kind::Surfaces);
        for (spare, reason) in [
            (SpareCapacity { meshes: u32::MAX, ..SPARE }, "no memory for meshes"),
            (SpareCapacity { levels: u32::MAX, ..SPARE }, "no memory for meshes"),
            (SpareCapacity { vertices: u32::MAX, ..SPARE }, "vertices, with room"),
            (SpareCapacity { indices: u32::MAX, ..SPARE }, "indices, with room"),
            (SpareCapacity { lights: u32::MAX, ..SPARE }, "lights"),
            (SpareCapacity { materials: u32::MAX, ..SPARE }, "materials, with room"),
        ] {
            let error = Renderer::new(device, &scene, &options(spare)).err().unwrap().to_string();
            assert!(error.contains(reason), "{error}");
        }
        plain.remove_meshes(&added).unwrap();
        assert!(!plain.is_uploading() && !plain.is_resident(added[0]));
        let gone = Object { mesh: added[0], ..object(0, Vec3::ZERO) };
        let error = plain.update(&[ObjectChange::Add { object: gone }]).unwrap_err().to_string();
        assert!(error.contains("no such mesh"), "{error}");
        assert_eq!(plain.add_meshes(vec![bare]).unwrap(), added);
    });
}

#[test]
fn a_material_that_cannot_be_drawn_is_refused_by_name_and_changes_nothing() {
    run(Driver::Lavapipe, |device| {
        let scene = first_scene(Kind::Surfaces);
        let mut renderer = Renderer::new(device, &scene, &options(SPARE)).unwrap();
        let plain = first_scene(Kind::Plain);
        let mut plain = Renderer::new(device, &plain, &options(SPARE)).unwrap();
        let good = Material::default();
        let used = |texture, scale: f32| {
            let transform = Affine2::from_scale(Vec2::splat(scale));
            Some(TextureUse { texture: TextureId(texture), uv_set: 0, transform })
        };
        for (bad, reason) in [
            (Material { alpha: Alpha::Blend, ..good.clone() }, MaterialError::Transparent),
            (
                Material { base_colour_texture: used(2, 1.0), ..good.clone() },
                MaterialError::Broken { fault: "the scene does not have one of its textures" },
            ),
            (
                Material { base_colour_texture: used(1, 1.0), ..good.clone() },
                MaterialError::Encoding,
            ),
            (Material { normal_texture: used(0, 1.0), ..good.clone() }, MaterialError::Encoding),
        ] {
            let error = renderer.add_materials(&[good.clone(), bad]).unwrap_err();
            assert_eq!(of_material(error), (1, reason));
        }
        let rough = Material { roughness: f32::NAN, ..good.clone() };
        let error = renderer.add_materials(&[rough]).unwrap_err();
        assert!(error.to_string().contains("not finite"), "{error}");
        assert!(matches!(of_material(error), (0, MaterialError::Broken { .. })));
        let error = plain.add_materials(std::slice::from_ref(&good)).unwrap_err().to_string();
        assert!(error.contains("no surfaces"), "{error}");
        assert!(plain.add_materials(&[]).unwrap().is_empty());
        let many = vec![good.clone(); SPARE.materials as usize + 1];
        let error = renderer.add_materials(&many).unwrap_err().to_string();
        assert!(error.contains("no room for 1 materials"), "{error}");
        let added = renderer.add_materials(&many[1..]).unwrap();
        let twice = renderer.remove_materials(&[added[1], added[1]]).unwrap_err();
        assert_eq!(of_material(twice), (1, MaterialError::NamedTwice));
        let unknown = renderer.remove_materials(&[added[1], MaterialId(77)]).unwrap_err();
        assert_eq!(of_material(unknown), (1, MaterialError::UnknownMaterial));
        renderer.remove_materials(&added).unwrap();
        assert!(renderer.remove_materials(&added[..1]).is_err());
        // Texture transforms are removed with the last material that uses them: there is room for
        // 25.
        for round in 0..40 {
            let texture = used(0, 1.5 + round as f32);
            let scaled = Material { base_colour_texture: texture, ..good.clone() };
            let ids = renderer.add_materials(&[scaled]).unwrap();
            renderer.remove_materials(&ids).unwrap();
        }
    });
}

#[test]
fn a_texture_that_there_is_no_room_for_is_refused_by_name_and_changes_nothing() {
    run(Driver::Lavapipe, |device| {
        let scene = first_scene(Kind::Surfaces);
        let mut renderer = Renderer::new(device, &scene, &options(spare(Kind::Surfaces))).unwrap();
        let plain = first_scene(Kind::Plain);
        let mut plain = Renderer::new(device, &plain, &options(SPARE)).unwrap();
        let of = |size: [u32; 2], encoding| {
            let image = Image::of_rgba8("one", size, vec![200; 4 * 16]);
            PreparedTexture::new(image, encoding, Sampler::default())
        };
        let broken = of([4, 3], Encoding::Srgb).unwrap_err().to_string();
        assert!(broken.contains("four bytes for each pixel"), "{broken}");
        let good = of([4, 4], Encoding::Srgb).unwrap();
        for other in [of([8, 2], Encoding::Srgb), of([4, 4], Encoding::Linear)] {
            let error = renderer.add_textures(vec![good.clone(), other.unwrap()]).unwrap_err();
            let error = error.to_string();
            assert!(
                error.contains("texture 1") && error.contains("SpareCapacity::textures"),
                "{error}"
            );
        }
        let error = plain.add_textures(vec![good.clone()]).unwrap_err().to_string();
        assert!(error.contains("no surfaces"), "{error}");
        let error = renderer.add_textures(vec![good.clone(); 3]).unwrap_err().to_string();
        assert!(error.contains("no room for 1 textures of this kind"), "{error}");
        let added = renderer.add_textures(vec![good.clone(); 2]).unwrap();
        assert!(renderer.is_uploading());
        let refused = |renderer: &mut Renderer, ids: &[TextureId], expected| match renderer
            .remove_textures(ids)
            .unwrap_err()
        {
            Error::Texture { reason, .. } => assert_eq!(reason, expected),
            other => panic!("{other}"),
        };
        refused(&mut renderer, &[added[0], added[0]], TextureError::NamedTwice);
        refused(&mut renderer, &[added[0], TextureId(77)], TextureError::UnknownTexture);
        refused(&mut renderer, &[TextureId(0)], TextureError::Permanent);
        renderer.remove_textures(&added).unwrap();
        assert!(!renderer.is_uploading(), "it is on its way no more");
        refused(&mut renderer, &added[..1], TextureError::UnknownTexture);
        let gone = TextureUse { texture: added[0], uv_set: 0, transform: Affine2::IDENTITY };
        let material = Material { base_colour_texture: Some(gone), ..Material::default() };
        let error = renderer.add_materials(&[material]).unwrap_err().to_string();
        assert!(error.contains("not on the GPU"), "{error}");
        let room = |size, layers| TextureCapacity { size, layers, ..rooms()[0] };
        for (textures, reason) in [
            (vec![room([4, 4], 1); 12], "kinds of textures that may come"),
            (vec![room([4, 4], u32::MAX)], "textures of one kind"),
            (vec![room([0, 4], 1)], "the width of the texture"),
            (vec![room([4, 4], 0)], "the number of layers"),
        ] {
            let spare = SpareCapacity { textures, ..SPARE };
            let error = Renderer::new(device, &scene, &options(spare)).err().unwrap().to_string();
            assert!(error.contains(reason), "{error}");
        }
    });
}
