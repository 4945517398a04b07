//! Meshes and materials that do not fit, or that a scene cannot show.

use glam::{Affine2, Vec2, Vec3};
use render::{Renderer, SpareCapacity, TextureCapacity};
use scene::{
    Alpha, Encoding, Image, Material, MaterialId, MeshId, Object, ObjectChange, PreparedMesh,
    PreparedTexture, Sampler, TextureId, TextureUse,
};
use tests::run_on_all;
use tests::window_fixture::Random;

use super::scenes::{
    Kind, SPARE, first_scene, object, options, rooms, some_mesh, spare, surface_of,
};

#[test]
fn a_mesh_that_does_not_fit_is_refused_by_name_and_changes_nothing() {
    run_on_all(|device| {
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
        refused(&mut plain, vec![whole.clone()], "mesh 0 of those named");
        refused(&mut lit, vec![whole.clone(), bare.clone()], "mesh 1 of those named");
        refused(&mut lit, vec![of(2)], "blends");
        refused(&mut lit, vec![of(3)], "does not have its material");
        refused(&mut plain, vec![bare.clone(); 2], "no room for 1 meshes");
        let added = plain.add_meshes(vec![bare.clone()]).unwrap();
        refused(&mut plain, vec![bare.clone()], "RendererOptions::spare");
        let twice = plain.remove_meshes(&[added[0], added[0]]).unwrap_err().to_string();
        assert!(twice.contains("named twice"), "{twice}");
        let unknown = plain.remove_meshes(&[added[0], MeshId(77)]).unwrap_err().to_string();
        assert!(unknown.contains("no such mesh"), "{unknown}");
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
    run_on_all(|device| {
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
            (Material { alpha: Alpha::Blend, ..good.clone() }, "it blends"),
            (Material { roughness: f32::NAN, ..good.clone() }, "not finite"),
            (Material { base_colour_texture: used(2, 1.0), ..good.clone() }, "one of its textures"),
            (Material { base_colour_texture: used(1, 1.0), ..good.clone() }, "Encoding::Srgb"),
            (Material { normal_texture: used(0, 1.0), ..good.clone() }, "Encoding::Linear"),
        ] {
            let error = renderer.add_materials(&[good.clone(), bad]).unwrap_err().to_string();
            assert!(error.contains("material 1") && error.contains(reason), "{error}");
        }
        let error = plain.add_materials(std::slice::from_ref(&good)).unwrap_err().to_string();
        assert!(error.contains("no surfaces"), "{error}");
        assert!(plain.add_materials(&[]).unwrap().is_empty());
        let many = vec![good.clone(); SPARE.materials as usize + 1];
        let error = renderer.add_materials(&many).unwrap_err().to_string();
        assert!(error.contains("no room for 1 materials"), "{error}");
        let added = renderer.add_materials(&many[1..]).unwrap();
        let twice = renderer.remove_materials(&[added[1], added[1]]).unwrap_err().to_string();
        assert!(twice.contains("named twice"), "{twice}");
        let unknown = renderer.remove_materials(&[added[1], MaterialId(77)]).unwrap_err();
        assert!(unknown.to_string().contains("no such material"), "{unknown}");
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
    run_on_all(|device| {
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
        let refused = |renderer: &mut Renderer, ids: &[TextureId], reason: &str| {
            let error = renderer.remove_textures(ids).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        };
        refused(&mut renderer, &[added[0], added[0]], "named twice");
        refused(&mut renderer, &[added[0], TextureId(77)], "no such texture");
        refused(&mut renderer, &[TextureId(0)], "began with");
        renderer.remove_textures(&added).unwrap();
        assert!(!renderer.is_uploading(), "it is on its way no more");
        refused(&mut renderer, &added[..1], "no such texture");
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
