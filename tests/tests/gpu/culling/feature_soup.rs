//! All features of a scene at once: moving lamps, holes, panes, a skinned mesh, an opening door.
//! The images are the same with every strategy.

use cull::{Camera, ObjectId, Projection, Strategy};
use glam::{Affine3A, Quat, Vec3, vec3};
use gpu::{Device, Readback};
use render::{CostModel, FrameRequest, Rect, Renderer, RendererOptions};
use scene::{
    Alpha, LightId, LightKind, Material, MaterialId, MeshId, MorphTarget, Object, ObjectChange,
    PunctualLight, Scene, SkinnedMesh, SkinnedMeshId, TransparentId, pack_unorm,
};
use tests::run_on_all;
use tests::shapes::{coloured_cubes, cube, surface_of};
use tests::walk::images_that_differ;

pub(crate) const SIZE: [u32; 2] = [160, 90];
const COLOURS: u32 = 4;
/// The mesh with holes.
const HOLES: u32 = 1;
const GLASS: u32 = COLOURS;
/// The skinned mesh.
const SOFT: u32 = COLOURS + 1;
pub(crate) const FRAMES: u32 = 8;
pub(crate) const LAMPS: u32 = 40;

fn object(mesh: u32, low: Vec3, size: Vec3) -> Object {
    let transform = Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, low);
    Object { mesh: MeshId(mesh), transform, tint: u32::MAX }
}

pub(crate) fn lamp(number: u32, frame: u32) -> PunctualLight {
    let turn = number as f32 * 0.7 + frame as f32 * 0.2;
    let spot = LightKind::Spot { inner_rad: 0.3, outer_rad: 0.8 };
    PunctualLight {
        kind: if number.is_multiple_of(3) { spot } else { LightKind::Point },
        colour: [1.0, 0.7, 0.4 + 0.01 * number as f32],
        intensity: 1.5,
        range_m: number.is_multiple_of(2).then_some(6.0),
        position: vec3(5.0 * turn.sin(), 1.0, -0.4 * number as f32),
        direction: vec3(turn.cos(), -0.5, turn.sin()).normalize(),
        cookie: None,
    }
}

/// Returns walls with doors, one behind the other and some with holes, objects between them, and a
/// skinned mesh at the side.
pub(crate) fn scene() -> Scene {
    let mut objects = vec![object(SOFT, vec3(1.0, -1.0, -4.0), vec3(2.0, 2.0, 0.5))];
    for wall in 0..4_u32 {
        let z = -5.5 - 3.0 * wall as f32;
        let door = wall as f32 * 1.5 - 3.0;
        objects.push(object(wall % COLOURS, vec3(-8.0, -2.0, z), vec3(8.0 + door, 5.0, 0.4)));
        let low = vec3(door + 1.5, -2.0, z);
        objects.push(object((wall + 1) % COLOURS, low, vec3(8.0 - door, 5.0, 0.4)));
        for thing in 0..8 {
            let low = vec3(thing as f32 * 1.9 - 7.0, -2.0, z - 2.0);
            objects.push(object((thing + wall) % COLOURS, low, Vec3::splat(0.7)));
        }
    }
    let mut scene = coloured_cubes(COLOURS, objects);
    let surfaces = scene.surfaces.as_mut().unwrap();
    for material in &mut surfaces.materials {
        *material = Material { is_unlit: false, metallic: 0.0, ..material.clone() };
    }
    surfaces.materials[HOLES as usize].alpha = Alpha::Mask { cutoff: 0.5 };
    for (corner, vertex) in surfaces.meshes[HOLES as usize].vertices.iter_mut().enumerate() {
        vertex.colour[3] = if corner % 2 == 0 { u16::MAX } else { 0 };
    }
    let soft = cube(pack_unorm([0.8, 0.6, 0.9, 1.0]), 6);
    for (mesh, alpha) in [(scene.meshes[0].clone(), Alpha::Blend), (soft, Alpha::Opaque)] {
        let material = MaterialId(surfaces.materials.len() as u32);
        surfaces.meshes.push(surface_of(&mesh, material));
        scene.meshes.push(mesh);
        let base_colour = if alpha == Alpha::Blend { [0.3, 0.8, 0.7, 0.4] } else { [1.0; 4] };
        surfaces.materials.push(Material {
            base_colour,
            alpha,
            metallic: 0.0,
            ..Material::default()
        });
    }
    let bulge = |vertex: &scene::Vertex| [0.0, vertex.position[0] * 1.5, 0.0];
    let positions = scene.meshes[SOFT as usize].vertices.iter().map(bulge).collect();
    surfaces.skinned_meshes = vec![SkinnedMesh {
        mesh: MeshId(SOFT),
        skin: None,
        targets: vec![MorphTarget { positions, ..MorphTarget::default() }],
    }];
    surfaces.transparent = (0..12).map(pane).collect();
    surfaces.lights = (0..LAMPS).map(|number| lamp(number, 0)).collect();
    scene
}

fn pane(number: u32) -> Object {
    let row = number / 4;
    let column = number % 4;
    let low = vec3(column as f32 * 1.9 - 4.0, -1.0, -4.0 - 3.0 * row as f32);
    object(
        GLASS,
        low,
        if number.is_multiple_of(2) { vec3(2.0, 2.0, 0.1) } else { vec3(0.2, 2.5, 3.5) },
    )
}

pub(crate) fn camera(frame: u32) -> Camera {
    let time = frame as f32 * 0.4;
    Camera {
        eye: vec3(2.0 * time.sin(), 0.3, -0.4 * frame as f32),
        forward: vec3(0.4 * (time * 1.3).sin(), -0.05, -1.0),
        up: Vec3::Y,
        projection: Projection::perspective(1.0),
        near: 0.05,
    }
}

/// Moves everything to its place in a frame.
pub(crate) fn live(renderer: &mut Renderer, scene: &Scene, frame: u32) {
    for number in (frame % 3..LAMPS).step_by(3) {
        renderer.set_light(LightId(number), lamp(number, frame)).unwrap();
    }
    let weight = (frame as f32 * 0.9).sin();
    renderer.set_pose(SkinnedMeshId(0), &[], &[weight]).unwrap();
    let slide = Affine3A::from_translation(vec3(0.0, (frame % 4) as f32 * 1.5, 0.0));
    let transform = slide * scene.objects[1].transform;
    renderer.update(&[ObjectChange::Move { object: ObjectId(1), transform }]).unwrap();
    for number in (frame % 3..12).step_by(4) {
        let fly = Affine3A::from_translation(vec3(0.2 * frame as f32, 0.0, 0.3));
        let transform = fly * pane(number).transform;
        renderer.move_transparent(TransparentId(number), transform).unwrap();
    }
}

fn renderer(device: &Device, scene: &Scene, cost_model: CostModel) -> Renderer {
    let options =
        RendererOptions { methods: methods::all(), size: SIZE, cost_model, ..Default::default() };
    Renderer::new(device, scene, &options).unwrap()
}

/// Moves back what does not move in each frame.
fn rewind(renderer: &mut Renderer) {
    for number in 0..LAMPS {
        renderer.set_light(LightId(number), lamp(number, 0)).unwrap();
    }
    for number in 0..12 {
        renderer.move_transparent(TransparentId(number), pane(number).transform).unwrap();
    }
}

/// Returns all frames, drawn without a wait in between from an empty history.
fn film(renderer: &mut Renderer, scene: &Scene, strategy: Strategy) -> Vec<Readback> {
    rewind(renderer);
    let mut view = renderer.new_view().unwrap();
    let mut finding = renderer.new_view().unwrap();
    let frame = |frame: u32| {
        live(renderer, scene, frame);
        let visible = (strategy == methods::IDEAL)
            .then(|| renderer.visible_set(&mut finding, camera(frame), Rect::whole(SIZE)).unwrap());
        let image = Readback::new(renderer.device(), SIZE).unwrap();
        let request = FrameRequest {
            image: Some(&image),
            visible: visible.as_ref(),
            ..FrameRequest::new(strategy, camera(frame))
        };
        renderer.render(&mut view, request).unwrap();
        image
    };
    let images = (0..FRAMES).map(frame).collect();
    renderer.wait_idle(&mut view).unwrap();
    assert!(renderer.degradations().crowded_objects > 0, "some leave lamps out");
    images
}

#[test]
fn every_exact_strategy_shows_the_same_life() {
    run_on_all(|device| {
        let scene = scene();
        let mut ignoring = renderer(device, &scene, CostModel::Off);
        let expected = film(&mut ignoring, &scene, Strategy::FRUSTUM);
        let lives = |pair: &[Readback]| images_that_differ(&pair[0], &pair[1]) > 500;
        assert!(expected.windows(2).all(lives), "something moves in each frame");
        let check = |renderer: &mut Renderer, strategy| {
            let found = film(renderer, &scene, strategy);
            for (frame, (expected, found)) in expected.iter().zip(&found).enumerate() {
                let wrong = images_that_differ(expected, found);
                assert_eq!(wrong, 0, "{strategy}, frame {frame}");
            }
        };
        for strategy in methods::strategies().into_iter().filter(|strategy| strategy.is_exact()) {
            check(&mut ignoring, strategy);
        }
        check(&mut renderer(device, &scene, CostModel::Measured), Strategy::ANTUMBRA);
    });
}
