//! Skinned and morphed meshes on the GPU: their vertices equal the formulas of glTF 2.0 on the CPU.
//! Images are exact while the meshes hide other objects and are hidden.

use cull::{Camera, Projection, Strategy};
use glam::{Affine3A, Mat3A, Quat, Vec3, vec3};
use gpu::{PredicationMode, Readback};
use render::{CostModel, FrameRequest, Renderer, RendererOptions};
use scene::{
    Encoding, Image, ImageId, LightKind, Material, MaterialId, Mesh, MeshId, MorphTarget, Object,
    PunctualLight, Sampler, Scene, SkinWeights, SkinnedMesh, SkinnedMeshId, Surfaces, Texture,
    TextureId, TextureUse, bounds_of_vertices, pack_normal, pack_unorm, unpack_normal,
};
use tests::run_on_all;
use tests::shapes::{box_scene, cube, surface_of};
use tests::walk::images_that_differ;

pub const SIZE: [u32; 2] = [160, 90];

/// The width of a slab that bends about two joints along its width and bulges.
pub const WIDTH_M: f32 = 4.0;

fn slab(colour: [f32; 4]) -> Mesh {
    let mut mesh = cube(pack_unorm(colour), 12);
    for vertex in &mut mesh.vertices {
        let [x, y, z] = vertex.position;
        vertex.position = [x * WIDTH_M, y * 3.0, z * 0.3];
    }
    mesh.bounds = bounds_of_vertices(&mesh.vertices);
    mesh
}

fn skinned_mesh(number: u32, mesh: &Mesh) -> SkinnedMesh {
    let along = |vertex: &scene::Vertex| vertex.position[0] / WIDTH_M;
    let second = |vertex| (along(vertex) * 2.0 - 0.5_f32).clamp(0.0, 1.0);
    // Two groups of joints, of which the first alone would suffice.
    let joints = mesh.vertices.iter().flat_map(|_| [[0, 1, 0, 0], [2, 0, 0, 0]]);
    let weights = mesh.vertices.iter().flat_map(|vertex| {
        let second = second(vertex);
        let third = along(vertex) * 0.25;
        let rest = 1.0 - third;
        [[(1.0 - second) * rest, second * rest, 0.0, 0.0], [third, 0.0, 0.0, 0.0]]
    });
    let bulge = |vertex: &scene::Vertex| (along(vertex) * std::f32::consts::PI).sin();
    SkinnedMesh {
        mesh: MeshId(number),
        skin: Some(SkinWeights {
            joint_count: 3,
            joints: joints.collect(),
            weights: weights.collect(),
            sets: 2,
        }),
        targets: vec![
            MorphTarget {
                positions: mesh.vertices.iter().map(|vertex| [0.0, 0.0, bulge(vertex)]).collect(),
                ..MorphTarget::default()
            },
            MorphTarget {
                positions: mesh.vertices.iter().map(|vertex| [0.0, -bulge(vertex), 0.0]).collect(),
                normals: mesh
                    .vertices
                    .iter()
                    .map(|vertex| [0.4 * along(vertex), 0.1, 0.0])
                    .collect(),
                tangents: mesh.vertices.iter().map(|_| [0.0, 0.3, 0.1]).collect(),
            },
        ],
    }
}

/// The pose of a frame.
pub struct Pose {
    pub joints: [Affine3A; 3],
    pub weights: [f32; 2],
}

pub fn pose(turn: f32) -> Pose {
    let about = |point: Vec3, turn: Quat| {
        Affine3A::from_translation(point)
            * Affine3A::from_quat(turn)
            * Affine3A::from_translation(-point)
    };
    let first = about(Vec3::ZERO, Quat::from_rotation_y(turn * 0.5));
    let second = first * about(vec3(2.0, 0.0, 0.0), Quat::from_rotation_y(turn));
    let third = first * Affine3A::from_scale(vec3(1.0, 1.2, 0.7));
    Pose { joints: [first, second, third], weights: [(turn * 3.0).sin(), 0.0_f32.max(turn * 0.2)] }
}

/// Returns the mesh morphed and skinned by the specification: glTF 2.0, "Morph Targets", "Skins".
fn skinned(mesh: &Mesh, skinned_mesh: &SkinnedMesh, pose: &Pose) -> Mesh {
    let mut mesh = mesh.clone();
    let skin = skinned_mesh.skin.as_ref().unwrap();
    for (number, vertex) in mesh.vertices.iter_mut().enumerate() {
        let mut position = Vec3::from(vertex.position);
        let mut normal = unpack_normal(vertex.normal);
        for (target, weight) in skinned_mesh.targets.iter().zip(pose.weights) {
            position += weight * Vec3::from(target.positions[number]);
            if !target.normals.is_empty() {
                normal += weight * Vec3::from(target.normals[number]);
            }
        }
        let mut matrix = Mat3A::ZERO;
        let mut offset = Vec3::ZERO;
        let sets = skin.sets as usize;
        for set in number * sets..(number + 1) * sets {
            for (joint, weight) in skin.joints[set].iter().zip(skin.weights[set]) {
                let joint = &pose.joints[*joint as usize];
                matrix += joint.matrix3 * weight;
                offset += Vec3::from(joint.translation) * weight;
            }
        }
        vertex.position = (matrix * position + offset).to_array();
        vertex.normal = pack_normal((matrix.inverse().transpose() * normal).normalize());
    }
    mesh.bounds = bounds_of_vertices(&mesh.vertices);
    mesh
}

/// Returns two slabs that move in front of and behind other objects: objects 0 and 1, meshes 0 and
/// 1.
pub fn scene() -> Scene {
    let meshes = vec![
        slab([0.9, 0.3, 0.2, 1.0]),
        slab([0.2, 0.5, 0.9, 1.0]),
        cube(pack_unorm([0.8, 0.8, 0.3, 1.0]), 1),
        cube(pack_unorm([0.3, 0.8, 0.4, 1.0]), 1),
    ];
    let at = |mesh, low: Vec3, size: Vec3| {
        let transform = Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, low);
        Object { mesh: MeshId(mesh), transform, tint: u32::MAX }
    };
    let mut objects = vec![
        // A door, and a figure that leans out from behind a wall.
        at(0, vec3(-2.0, 0.0, -5.0), Vec3::ONE),
        at(1, vec3(3.0, 0.0, -9.0), Vec3::ONE),
        at(2, vec3(2.5, -1.0, -8.0), vec3(6.0, 6.0, 0.5)),
    ];
    for number in 0..60 {
        let place = vec3((number % 10) as f32 * 1.3 - 8.0, (number / 10) as f32 * 0.9 - 1.0, -12.0);
        let forth = vec3(0.0, 0.0, -3.0 * (number % 3) as f32);
        objects.push(at(2 + number % 2, place + forth, Vec3::splat(0.8)));
    }
    let skinned_meshes = [0, 1].map(|mesh| skinned_mesh(mesh, &meshes[mesh as usize]));
    let surfaces = Surfaces {
        meshes: meshes.iter().map(|mesh| surface_of(mesh, MaterialId(0))).collect(),
        materials: vec![Material { metallic: 0.0, ..Material::default() }],
        lights: vec![PunctualLight {
            kind: LightKind::Directional,
            colour: [1.0; 3],
            intensity: 3.0,
            range_m: None,
            position: Vec3::ZERO,
            direction: vec3(-0.3, -0.8, -0.6).normalize(),
            cookie: None,
        }],
        skinned_meshes: skinned_meshes.to_vec(),
        ..Surfaces::default()
    };
    Scene { meshes, objects, surfaces: Some(surfaces), ..box_scene(&[]) }
}

pub fn camera() -> Camera {
    let forward = vec3(0.1, 0.0, -1.0);
    let up = Vec3::Y;
    Camera {
        eye: vec3(0.0, 1.4, 0.0),
        forward,
        up,
        projection: Projection::perspective(1.2),
        near: 0.05,
    }
}

pub fn options(frames_in_flight: usize) -> RendererOptions {
    RendererOptions {
        methods: methods::all(),
        size: SIZE,
        frames_in_flight,
        cost_model: CostModel::Off,
        ..Default::default()
    }
}

/// Returns the scene with both slabs posed on the CPU.
fn bent(scene: &Scene, turns: [f32; 2]) -> Scene {
    let mut bent = scene.clone();
    for (mesh, turn) in turns.into_iter().enumerate() {
        let skinned_meshes = &scene.surfaces.as_ref().unwrap().skinned_meshes;
        bent.meshes[mesh] = skinned(&scene.meshes[mesh], &skinned_meshes[mesh], &pose(turn));
        let surfaces = bent.surfaces.as_mut().unwrap();
        surfaces.meshes[mesh] = surface_of(&bent.meshes[mesh], MaterialId(0));
        surfaces.skinned_meshes.clear();
    }
    bent
}

/// Sets the poses in a renderer.
pub fn take(renderer: &mut Renderer, turns: [f32; 2]) {
    for (number, turn) in (0..).zip(turns) {
        let Pose { joints, weights } = pose(turn);
        renderer.set_pose(SkinnedMeshId(number), &joints, &weights).unwrap();
    }
}

pub fn turns(frame: u32) -> [f32; 2] {
    let time = frame as f32 * 0.35;
    [1.2 * time.sin().abs(), 1.0 - time.cos()]
}

pub fn draw(renderer: &mut Renderer, strategy: Strategy) -> Readback {
    let image = Readback::new(renderer.device(), SIZE).unwrap();
    let mut view = renderer.new_view().unwrap();
    let request = FrameRequest { image: Some(&image), ..FrameRequest::new(strategy, camera()) };
    renderer.render(&mut view, request).unwrap();
    renderer.wait_idle(&mut view).unwrap();
    image
}

/// Returns the number of pixels that differ by more than rounding.
pub fn pixels_far_apart(a: &Readback, b: &Readback) -> usize {
    let far = |(a, b): (&[u8], &[u8])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 8);
    a.rgba8()
        .unwrap()
        .chunks_exact(4)
        .zip(b.rgba8().unwrap().chunks_exact(4))
        .filter(|pixels| far(*pixels))
        .count()
}

#[test]
fn forms_are_those_of_the_specification() {
    run_on_all(|device| {
        let scene = scene();
        let mut moving = Renderer::new(device, &scene, &options(2)).unwrap();
        let at_rest = draw(&mut moving, Strategy::FRUSTUM);
        let mut moved = 0;
        for frame in [0, 1, 2, 3, 5, 8] {
            take(&mut moving, turns(frame));
            let found = draw(&mut moving, Strategy::FRUSTUM);
            let mut still =
                Renderer::new(device, &bent(&scene, turns(frame)), &options(2)).unwrap();
            let expected = draw(&mut still, Strategy::FRUSTUM);
            let wrong = pixels_far_apart(&expected, &found);
            // Along edges, where rounding decides about the pixel.
            assert!(wrong <= 30, "frame {frame}: {wrong} pixels");
            moved = moved.max(pixels_far_apart(&at_rest, &found));
        }
        assert!(moved > 500, "{moved} pixels of something that moves");
    });
}

/// Returns a mirrored slab whose normals lean along its bitangents.
fn leaning() -> Scene {
    let mut mesh = slab([0.9, 0.9, 0.9, 1.0]);
    for triangle in mesh.indices.chunks_exact_mut(3) {
        triangle.swap(1, 2);
    }
    let texel = Image::of_rgba8("leaning", [1, 1], vec![128, 230, 200, 255]);
    let texture =
        Texture { image: ImageId(0), encoding: Encoding::Linear, sampler: Sampler::default() };
    let used = TextureUse { texture: TextureId(0), uv_set: 0, transform: glam::Affine2::IDENTITY };
    let scene = scene();
    let surfaces = Surfaces {
        meshes: vec![surface_of(&mesh, MaterialId(0))],
        materials: vec![Material {
            metallic: 0.0,
            normal_texture: Some(used),
            ..Material::default()
        }],
        images: vec![texel],
        textures: vec![texture],
        lights: scene.surfaces.unwrap().lights,
        ..Surfaces::default()
    };
    let transform = Affine3A::from_translation(vec3(0.0, 0.0, -5.0));
    let objects = vec![Object { mesh: MeshId(0), transform, tint: u32::MAX }];
    Scene { meshes: vec![mesh], objects, surfaces: Some(surfaces), ..box_scene(&[]) }
}

#[test]
fn joints_that_mirror_turn_bitangents_as_objects_do() {
    run_on_all(|device| {
        let mirror = Affine3A::from_scale(vec3(-1.0, 1.0, 1.0));
        let scene = leaning();
        let mut rigid = scene.clone();
        rigid.objects[0].transform = scene.objects[0].transform * mirror;
        let expected =
            draw(&mut Renderer::new(device, &rigid, &options(2)).unwrap(), Strategy::FRUSTUM);

        let mut skinned = scene.clone();
        let vertices = scene.meshes[0].vertices.len();
        skinned.surfaces.as_mut().unwrap().skinned_meshes = vec![SkinnedMesh {
            mesh: MeshId(0),
            skin: Some(SkinWeights {
                joint_count: 1,
                joints: vec![[0; 4]; vertices],
                weights: vec![[1.0, 0.0, 0.0, 0.0]; vertices],
                sets: 1,
            }),
            targets: Vec::new(),
        }];
        let mut renderer = Renderer::new(device, &skinned, &options(2)).unwrap();
        let unposed = draw(&mut renderer, Strategy::FRUSTUM);
        renderer.set_pose(SkinnedMeshId(0), &[mirror], &[]).unwrap();
        let found = draw(&mut renderer, Strategy::FRUSTUM);
        assert_eq!(pixels_far_apart(&expected, &found), 0);
        assert!(pixels_far_apart(&expected, &unposed) > 500, "it is somewhere else");
    });
}

/// Returns all frames with one strategy, drawn without a wait in between.
fn film(renderer: &mut Renderer, strategy: Strategy) -> Vec<Readback> {
    let mut view = renderer.new_view().unwrap();
    let frame = |frame| {
        take(renderer, turns(frame));
        let image = Readback::new(renderer.device(), SIZE).unwrap();
        let request = FrameRequest { image: Some(&image), ..FrameRequest::new(strategy, camera()) };
        renderer.render(&mut view, request).unwrap();
        image
    };
    let images = (0..9).map(frame).collect();
    renderer.wait_idle(&mut view).unwrap();
    images
}

/// Compares each frame.
fn check_film(expected: &[Readback], found: &[Readback], what: &str) {
    for (frame, (expected, found)) in expected.iter().zip(found).enumerate() {
        let wrong = images_that_differ(expected, found);
        assert_eq!(wrong, 0, "{what}, frame {frame}");
    }
}

#[test]
fn what_changes_its_form_hides_and_is_hidden_exactly() {
    run_on_all(|device| {
        let mut renderer = Renderer::new(device, &scene(), &options(1)).unwrap();
        let expected = film(&mut renderer, Strategy::FRUSTUM);
        let strategies = [
            methods::BATCHED,
            methods::CHC,
            methods::HZB,
            Strategy::ANTUMBRA,
            Strategy::ANTUMBRA_QUERIES,
        ];
        for (strategy, in_flight) in strategies.into_iter().zip([1, 2, 3, 3, 1]) {
            renderer.set_frames_in_flight(in_flight).unwrap();
            let found = film(&mut renderer, strategy);
            check_film(&expected, &found, &format!("{strategy}, {in_flight} in flight"));
        }
        let compacted = Some(PredicationMode::Compacted);
        if PredicationMode::choose(device, compacted, 0, 0).is_ok() {
            let options = RendererOptions { predication: compacted, ..options(2) };
            let mut renderer = Renderer::new(device, &scene(), &options).unwrap();
            check_film(&expected, &film(&mut renderer, Strategy::ANTUMBRA), "compacted");
        }
    });
}
