//! Changing lights, and objects that move under them: frames look as if the scene had always been
//! so.

use cull::{Camera, ObjectId, Projection, Strategy};
use glam::{Affine3A, Vec3, vec3};
use gpu::{Device, Readback};
use render::{Error, FrameRequest, Renderer, RendererOptions, ViewState};
use scene::{
    Alpha, LightId, LightKind, Material, MaterialId, MeshId, Object, ObjectChange, PunctualLight,
    Scene, SurfaceVertex, Surfaces,
};
use tests::studio::{mesh, scene, snorm16};
use tests::{run_on_all, shapes};

const SIZE: [u32; 2] = [128, 96];

/// Returns cubes side by side, panes before them, and bulbs between.
fn room() -> Scene {
    let cube = shapes::box_scene(&[]).meshes.remove(0);
    let positions: Vec<Vec3> =
        cube.vertices.iter().map(|vertex| Vec3::from_array(vertex.position)).collect();
    let vertex = |vertex: &scene::Vertex| SurfaceVertex {
        normal: snorm16(scene::unpack_normal(vertex.normal).normalize(), 0),
        tangent: snorm16(Vec3::X, 1),
        uv: [[0.0; 2]; 2],
        colour: [u16::MAX; 4],
    };
    let vertices: Vec<SurfaceVertex> = cube.vertices.iter().map(vertex).collect();
    let meshes =
        [0, 1].map(|material| mesh(&positions, vertices.clone(), cube.indices.clone(), material));
    let matt = Material { metallic: 0.0, ..Material::default() };
    let pane = Material { alpha: Alpha::Blend, base_colour: [1.0, 1.0, 1.0, 0.4], ..matt.clone() };
    let lights = (0..30)
        .map(|number| bulb(vec3((number % 6) as f32 * 3.0, 1.5, -3.0 * (number / 6) as f32)))
        .collect();
    let surfaces = Surfaces { materials: vec![matt, pane], lights, ..Surfaces::default() };
    let mut scene = scene(meshes.to_vec(), &[], surfaces);
    let object = |mesh, place: Vec3| Object {
        mesh: MeshId(mesh),
        transform: Affine3A::from_translation(place),
        tint: 0,
    };
    let cubes = (0..64)
        .map(|number| object(0, vec3((number % 8) as f32 * 2.0, 0.0, -2.0 * (number / 8) as f32)));
    scene.objects = cubes.collect();
    let panes = (0..4).map(|number| object(1, vec3(number as f32 * 4.0, 1.2, 0.5)));
    scene.surfaces.as_mut().unwrap().transparent = panes.collect();
    scene
}

fn bulb(position: Vec3) -> PunctualLight {
    PunctualLight {
        kind: LightKind::Point,
        colour: [1.0, 0.8, 0.6],
        intensity: 2.0,
        range_m: Some(4.0),
        position,
        direction: Vec3::NEG_Z,
    }
}

fn image(renderer: &mut Renderer, view: &mut ViewState) -> Vec<u8> {
    let camera = Camera {
        eye: vec3(8.0, 6.0, 8.0),
        forward: vec3(0.0, -0.5, -1.0),
        up: Vec3::Y,
        projection: Projection::perspective(1.0),
        near: 0.1,
    };
    let image = Readback::new(renderer.device(), SIZE).unwrap();
    let request =
        FrameRequest { image: Some(&image), ..FrameRequest::new(Strategy::ANTUMBRA, camera) };
    renderer.render(view, &request).unwrap();
    renderer.drain(view).unwrap();
    image.rgba8().unwrap().to_vec()
}

fn renderer(device: &Device, scene: &Scene) -> Renderer {
    Renderer::new(device, scene, &RendererOptions { size: SIZE, ..RendererOptions::default() })
        .unwrap()
}

fn fresh(device: &Device, scene: &Scene) -> Vec<u8> {
    let mut renderer = renderer(device, scene);
    let mut view = renderer.new_view().unwrap();
    image(&mut renderer, &mut view)
}

#[test]
fn lights_and_objects_move_as_if_they_had_always_been_there() {
    run_on_all(|device| {
        let mut scene = room();
        let mut renderer = renderer(device, &scene);
        let mut view = renderer.new_view().unwrap();
        let mut before = image(&mut renderer, &mut view);
        assert_eq!(before, fresh(device, &scene));
        for step in 0..6_u32 {
            let light = LightId(step * 5 % 30);
            let to = match step % 3 {
                0 => bulb(vec3(14.0 - 2.0 * step as f32, 1.0, 1.0)),
                1 => PunctualLight { intensity: 0.0, ..bulb(Vec3::ZERO) },
                _ => PunctualLight { range_m: None, ..bulb(vec3(2.0, 3.0, 0.0)) },
            };
            renderer.set_light(light, to).unwrap();
            scene.surfaces.as_mut().unwrap().lights[light.0 as usize] = to;
            let object = ObjectId(step * 9 % 64);
            let transform = Affine3A::from_translation(vec3(3.0 * step as f32, 1.5, -1.0));
            renderer.update(&[ObjectChange::Move { object, transform }]).unwrap();
            scene.objects[object.0 as usize].transform = transform;
            let now = image(&mut renderer, &mut view);
            assert_ne!(now, before, "step {step} shows");
            let other = fresh(device, &scene);
            let wrong = now.chunks(4).zip(other.chunks(4)).filter(|(a, b)| a != b).count();
            assert_eq!(wrong, 0, "pixels in step {step}");
            before = now;
        }
    });
}

#[test]
fn lights_that_cannot_be_are_refused() {
    run_on_all(|device| {
        let scene = room();
        let mut renderer = renderer(device, &scene);
        let sun = PunctualLight { kind: LightKind::Directional, ..bulb(Vec3::ZERO) };
        for (light, to) in [(0, sun), (30, bulb(Vec3::ZERO))] {
            let refused = renderer.set_light(LightId(light), to);
            assert!(matches!(refused, Err(Error::Light { light: LightId(it), .. }) if it == light));
        }
        renderer.set_light(LightId(0), bulb(Vec3::NAN)).unwrap();
        assert_eq!(scene.surfaces.unwrap().meshes[0].material, MaterialId(0));
    });
}
