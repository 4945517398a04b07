//! Tests of the smallest scene, and of error messages that name the surface that cannot be drawn.

use glam::{Affine2, Affine3A, Vec2, Vec3};

use super::*;

/// Returns a scene with a skinned and morphed triangle, as an object and as a transparent object.
fn scene() -> Scene {
    let vertex = |x: f32, y: f32| Vertex {
        position: [x, y, 0.0],
        normal: pack_normal(Vec3::Z),
        colour: u32::MAX,
    };
    let vertices = vec![vertex(0.0, 0.0), vertex(1.0, 0.0), vertex(0.0, 1.0)];
    let bounds = bounds_of_vertices(&vertices);
    let mesh = |name: &str| Mesh {
        name: name.to_owned(),
        vertices: vertices.clone(),
        indices: vec![0, 1, 2],
        bounds,
        has_backs: false,
    };
    let object =
        |mesh| Object { mesh: MeshId(mesh), transform: Affine3A::IDENTITY, tint: u32::MAX };
    let surface_vertex = SurfaceVertex {
        normal: [0, 0, 32767, 0],
        tangent: [32767, 0, 0, 32767],
        uv: [[0.0; 2]; 2],
        colour: [u16::MAX; 4],
    };
    let surface = || SurfaceMesh { vertices: vec![surface_vertex; 3], material: MaterialId(0) };
    let texture = TextureUse { texture: TextureId(0), uv_set: 1, transform: Affine2::IDENTITY };
    let skin = SkinWeights {
        joint_count: 2,
        joints: vec![[0, 1, 9, 9]; 3],
        weights: vec![[0.5, 0.5, 0.0, 0.0]; 3],
        sets: 1,
    };
    let target = MorphTarget { positions: vec![[0.0; 3]; 3], ..MorphTarget::default() };
    let surfaces = Surfaces {
        meshes: vec![surface(), surface()],
        materials: vec![Material { base_colour_texture: Some(texture), ..Material::default() }],
        textures: vec![Texture {
            image: ImageId(0),
            encoding: Encoding::Srgb,
            sampler: Sampler::default(),
        }],
        images: vec![Image::of_rgba8("", [1, 1], vec![255; 4])],
        transparent: vec![object(1)],
        skinned_meshes: vec![SkinnedMesh {
            mesh: MeshId(0),
            skin: Some(skin),
            targets: vec![target],
        }],
        ..Surfaces::default()
    };
    Scene {
        meshes: vec![mesh("bent"), mesh("glass")],
        surfaces: Some(surfaces),
        ..Scene::single(mesh("bent"))
    }
}

#[test]
fn whole_surfaces_are_accepted() {
    assert_eq!(scene().validate(), Ok(()));
}

#[test]
fn broken_surfaces_are_refused_by_name() {
    type Break = fn(&mut Scene, &mut Surfaces);
    let cases: [(&str, Break); 24] = [
        ("as many as the scene has meshes", |_, surfaces| surfaces.meshes.truncate(1)),
        ("as many surface vertices", |_, surfaces| surfaces.meshes[1].vertices.truncate(2)),
        ("texture coordinate", |_, surfaces| surfaces.meshes[0].vertices[2].uv[1][0] = f32::NAN),
        ("its image", |_, surfaces| surfaces.textures[0].image = ImageId(1)),
        ("one of its textures", |_, surfaces| surfaces.textures.clear()),
        ("another set of coordinates", |_, surfaces| {
            surfaces.materials[0].base_colour_texture.as_mut().unwrap().uv_set = 2;
        }),
        ("transform of a texture", |_, surfaces| {
            let texture = surfaces.materials[0].base_colour_texture.as_mut().unwrap();
            texture.transform = Affine2::from_translation(Vec2::splat(f32::INFINITY));
        }),
        ("numbers is not finite", |_, surfaces| surfaces.materials[0].roughness = f32::NAN),
        ("numbers is not finite", |_, surfaces| surfaces.materials[0].emission[2] = f32::INFINITY),
        ("numbers is not finite", |_, surfaces| {
            surfaces.materials[0].alpha = Alpha::Mask { cutoff: f32::NAN };
        }),
        ("exposure", |_, surfaces| surfaces.exposure = f32::NAN),
        ("transparent object 0", |_, surfaces| surfaces.transparent[0].mesh = MeshId(2)),
        ("takes it nowhere", |_, surfaces| {
            surfaces.transparent[0].transform = Affine3A::from_translation(Vec3::splat(f32::NAN));
        }),
        ("skinned mesh 0", |_, surfaces| surfaces.skinned_meshes[0].mesh = MeshId(7)),
        ("several objects", |scene, _| scene.objects.push(scene.objects[0])),
        ("several objects", |_, surfaces| surfaces.transparent[0].mesh = MeshId(0)),
        ("another one", |_, surfaces| {
            surfaces.skinned_meshes.push(surfaces.skinned_meshes[0].clone())
        }),
        ("as long as", |_, surfaces| {
            surfaces.skinned_meshes[0].targets[0].normals = vec![[0.0; 3]; 2]
        }),
        ("morph target has a number", |_, surfaces| {
            surfaces.skinned_meshes[0].targets[0].positions[1] = [f32::NAN; 3];
        }),
        ("joints and weights", |_, surfaces| skin(surfaces).sets = 0),
        ("joints and weights", |_, surfaces| skin(surfaces).weights.truncate(2)),
        ("not a positive finite", |_, surfaces| skin(surfaces).weights[0] = [1.5, -0.5, 0.0, 0.0]),
        ("not 1 together", |_, surfaces| skin(surfaces).weights[1] = [0.5, 0.0, 0.0, 0.0]),
        ("does not have", |_, surfaces| skin(surfaces).joints[2] = [2, 0, 0, 0]),
    ];
    for (says, break_it) in cases {
        let mut scene = scene();
        let mut surfaces = scene.surfaces.take().unwrap();
        break_it(&mut scene, &mut surfaces);
        scene.surfaces = Some(surfaces);
        let error = scene.validate().expect_err(says).to_string();
        assert!(error.contains(says), "{says}: {error}");
    }
}

fn skin(surfaces: &mut Surfaces) -> &mut SkinWeights {
    surfaces.skinned_meshes[0].skin.as_mut().unwrap()
}

#[test]
fn three_corners_are_a_triangle() {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0; 3]];
    let mesh = Mesh::of_triangles("triangle", &corners.map(|corner| (corner, [1.0; 3])));
    assert_eq!((mesh.triangles(), mesh.vertices[0].normal), (1, pack_normal(Vec3::Z)));
    assert_eq!(mesh.bounds.max, Vec3::new(1.0, 1.0, 0.0));
    let scene = Scene::single(mesh);
    assert_eq!(scene.validate(), Ok(()));
    assert_eq!(scene.triangles(), 1);
    Scene::single(Mesh::of_triangles("nothing", &[])).validate().unwrap();
}

/// Returns a red triangle without surfaces.
fn plain_triangle() -> Scene {
    let red = [1.0, 0.2, 0.0];
    let corners = [([0.0, 0.0, 0.0], red), ([1.0, 0.0, 0.0], red), ([0.0, 1.0, 0.0], red)];
    Scene::single(Mesh::of_triangles("triangle", &corners))
}

#[test]
fn a_plain_scene_gets_its_colours_and_its_sun_as_surfaces() {
    let plain = plain_triangle();
    let lit = plain.clone().with_surfaces();
    assert_eq!(lit.validate(), Ok(()));
    assert_eq!((&lit.meshes, &lit.objects), (&plain.meshes, &plain.objects));
    let surfaces = lit.surfaces.as_ref().unwrap();
    let vertex = surfaces.meshes[0].vertices[0];
    assert_eq!(vertex.normal, [0, 0, i16::MAX, 0]);
    assert_eq!(vertex.colour, [u16::MAX, 51 * 257, 0, u16::MAX]);
    let [sun] = surfaces.lights.as_slice() else { panic!("one light") };
    assert_eq!(sun.kind, LightKind::Directional);
    assert!((sun.direction + plain.light.towards_sun).length() < 1e-6);
    let diffuse = sun.colour.map(|part| part * sun.intensity * vertex_surfaces::LET_THROUGH / PI);
    for (found, expected) in diffuse.into_iter().zip(plain.light.sun) {
        assert!((found - expected).abs() < 1e-5, "{diffuse:?}");
    }
    assert_eq!(lit.clone().with_surfaces(), lit, "surfaces that are there stay");
}

#[test]
fn a_sun_that_does_not_shine_is_no_light() {
    let plain = plain_triangle();
    for (towards_sun, sun) in [
        (Vec3::Y, [0.0; 3]),
        (Vec3::Y, [f32::NAN; 3]),
        (Vec3::Y, [f32::INFINITY, 1.0, 1.0]),
        (Vec3::ZERO, [1.0; 3]),
        (Vec3::NAN, [1.0; 3]),
    ] {
        let light = Light { towards_sun, sun, ..plain.light };
        let lit = Scene { light, ..plain.clone() }.with_surfaces();
        assert_eq!(lit.surfaces.unwrap().lights, [], "{towards_sun}, {sun:?}");
    }
}

#[test]
fn both_sides_of_a_mesh_are_kept() {
    let mut plain = plain_triangle();
    plain.meshes[0].has_backs = true;
    let surfaces = plain.with_surfaces().surfaces.unwrap();
    assert!(surfaces.meshes[0].vertices.iter().all(|vertex| vertex.normal[3] == i16::MAX));
}
