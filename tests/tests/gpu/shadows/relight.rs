//! Lights that change, are added or are removed, and objects that move under them. Frames equal
//! those of a new renderer of the changed scene.

use std::collections::BTreeMap;

use cull::{Camera, ObjectId, Projection, Strategy};
use glam::{Affine3A, Vec3, vec3};
use gpu::{Device, Readback};
use render::{
    CostModel, Error, FrameRequest, LightError, RenderView, Renderer, RendererOptions,
    SpareCapacity,
};
use scene::{
    Alpha, LightId, LightKind, Material, MaterialId, MeshId, Object, ObjectChange, PunctualLight,
    Scene, SurfaceVertex, Surfaces,
};
use tests::surface_fixture::{mesh, scene, snorm16};
use tests::{Driver, run, run_on_all, shapes};

const SIZE: [u32; 2] = [128, 96];

/// Returns cubes side by side, panes in front of them, and bulbs in between.
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
        cookie: None,
    }
}

fn image(renderer: &mut Renderer, view: &mut RenderView) -> Vec<u8> {
    let image = draw(renderer, view, Strategy::ANTUMBRA);
    renderer.wait_idle(view).unwrap();
    image.rgba8().unwrap().to_vec()
}

/// Draws a frame, which may still be in flight.
fn draw(renderer: &mut Renderer, view: &mut RenderView, strategy: Strategy) -> Readback {
    let camera = Camera {
        eye: vec3(8.0, 6.0, 8.0),
        forward: vec3(0.0, -0.5, -1.0),
        up: Vec3::Y,
        projection: Projection::perspective(1.0),
        near: 0.1,
    };
    let image = Readback::new(renderer.device(), SIZE).unwrap();
    let request = FrameRequest { image: Some(&image), ..FrameRequest::new(strategy, camera) };
    renderer.render(view, request).unwrap();
    image
}

fn options(spare: SpareCapacity) -> RendererOptions {
    let cost_model = CostModel::Off;
    RendererOptions { size: SIZE, frames_in_flight: 3, cost_model, spare, ..Default::default() }
}

fn renderer(device: &Device, scene: &Scene) -> Renderer {
    Renderer::new(device, scene, &options(SpareCapacity::default())).unwrap()
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
        for step in 0..4_u32 {
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
    run(Driver::Lavapipe, |device| {
        let scene = room();
        let mut renderer = renderer(device, &scene);
        let sun = PunctualLight { kind: LightKind::Directional, ..bulb(Vec3::ZERO) };
        for (light, to, expected) in
            [(0, sun, LightError::OtherKind), (30, bulb(Vec3::ZERO), LightError::UnknownLight)]
        {
            let error = renderer.set_light(LightId(light), to).unwrap_err();
            let Error::Light { light: refused, reason } = error else { panic!("{error}") };
            assert_eq!((refused, reason), (LightId(light), expected));
        }
        renderer.set_light(LightId(0), bulb(Vec3::NAN)).unwrap();
        assert_eq!(scene.surfaces.unwrap().meshes[0].material, MaterialId(0));
    });
}

/// Returns the light of a step: a lamp, a spot, or a sun that is weaker than the previous ones.
fn comer(step: u32) -> PunctualLight {
    let place = vec3(2.0 + 1.5 * step as f32, 2.5, 1.0 - step as f32);
    match step % 3 {
        0 => PunctualLight { colour: [0.2, 1.0, 0.3], range_m: None, ..bulb(place) },
        1 => PunctualLight {
            kind: LightKind::Spot { inner_rad: 0.3, outer_rad: 0.6 },
            intensity: 20.0,
            direction: Vec3::NEG_Y,
            ..bulb(place)
        },
        _ => PunctualLight {
            kind: LightKind::Directional,
            intensity: 1.0 / step as f32,
            direction: vec3(0.3, -1.0, -0.2 * step as f32),
            ..bulb(Vec3::ZERO)
        },
    }
}

#[test]
fn lights_come_and_go_as_if_they_had_always_been_there() {
    run_on_all(|device| {
        let mut scene = room();
        let mut there: BTreeMap<u32, PunctualLight> =
            (0..).zip(scene.surfaces.as_ref().unwrap().lights.iter().copied()).collect();
        let spare = SpareCapacity { lights: 2, directional_lights: 2, ..Default::default() };
        let mut renderer = Renderer::new(device, &scene, &options(spare)).unwrap();
        let mut views = [(); 2].map(|()| renderer.new_view().unwrap());
        let mut frames = Vec::new();
        for step in 0..7_u32 {
            let [light] = renderer.add_lights(&[comer(step)]).unwrap()[..] else { panic!() };
            assert_eq!(there.insert(light.0, comer(step)), None, "no light has another's id");
            if step > 0 {
                // A light of the scene, and one that was added.
                let mut gone = vec![LightId(step * 4)];
                gone.extend((step == 6).then_some(light));
                there.retain(|light, _| !gone.contains(&LightId(*light)));
                renderer.remove_lights(&gone).unwrap();
            }
            let moved = PunctualLight { position: vec3(step as f32, 1.0, 1.0), ..there[&0] };
            renderer.set_light(LightId(0), moved).unwrap();
            there.insert(0, moved);
            let strategies = [Strategy::ANTUMBRA, Strategy::FRUSTUM].into_iter().zip(&mut views);
            let images: Vec<Readback> =
                strategies.map(|(strategy, view)| draw(&mut renderer, view, strategy)).collect();
            frames.push((images, there.values().copied().collect::<Vec<_>>()));
            if step == 5 {
                renderer.remove_lights(&[light]).unwrap();
                there.remove(&light.0);
            }
        }
        views.iter_mut().for_each(|view| renderer.wait_idle(view).unwrap());
        let mut before = Vec::new();
        for (step, (images, lights)) in frames.into_iter().enumerate() {
            scene.surfaces.as_mut().unwrap().lights = lights;
            let expected = fresh(device, &scene);
            for image in images {
                let image = image.rgba8().unwrap().to_vec();
                let wrong = image.chunks(4).zip(expected.chunks(4)).filter(|(a, b)| a != b).count();
                assert_eq!(wrong, 0, "pixels in step {step}");
            }
            assert_ne!(expected, before, "step {step} shows");
            before = expected;
        }
    });
}

#[test]
fn the_first_lights_of_a_dark_room_shine_as_if_they_had_always_been_there() {
    run_on_all(|device| {
        let mut scene = room();
        scene.surfaces.as_mut().unwrap().lights.clear();
        let spare = SpareCapacity { lights: 2, directional_lights: 1, ..Default::default() };
        let mut renderer = Renderer::new(device, &scene, &options(spare)).unwrap();
        let mut view = renderer.new_view().unwrap();
        let mut before = image(&mut renderer, &mut view);
        assert_eq!(before, fresh(device, &scene));
        for light in [comer(0), comer(1), comer(2)] {
            renderer.add_lights(&[light]).unwrap();
            scene.surfaces.as_mut().unwrap().lights.push(light);
            let now = image(&mut renderer, &mut view);
            assert_ne!(now, before, "{light:?} shows");
            let expected = fresh(device, &scene);
            let wrong = now.chunks(4).zip(expected.chunks(4)).filter(|(a, b)| a != b).count();
            assert_eq!(wrong, 0, "{light:?}");
            before = now;
        }
    });
}

#[test]
fn lights_come_where_they_have_room_only() {
    run(Driver::Lavapipe, |device| {
        let [lamp, spot, sun] = [0, 1, 2].map(comer);
        let with = |scene: &Scene, lights, directional_lights| {
            Renderer::new(
                device,
                scene,
                &options(SpareCapacity { lights, directional_lights, ..Default::default() }),
            )
        };
        let no_room = |renderer: &mut Renderer, lights: &[PunctualLight]| {
            let error = renderer.add_lights(lights).unwrap_err();
            let Error::CapacityExceeded { what, wanted, left } = error else { panic!("{error}") };
            (what, wanted, left)
        };
        let mut renderer = with(&room(), 1, 1).unwrap();
        assert_eq!(no_room(&mut renderer, &[lamp, spot]), ("point and spot lights", 2, 1));
        assert_eq!(no_room(&mut renderer, &[lamp, sun, sun]), ("directional lights", 2, 1));
        let added = renderer.add_lights(&[sun, spot]).unwrap();
        assert_eq!(no_room(&mut renderer, &[lamp]), ("point and spot lights", 1, 0));
        assert!(matches!(renderer.set_light(added[0], lamp), Err(Error::Light { .. })));
        renderer.remove_lights(&added).unwrap();
        for light in [added[1], LightId(32)] {
            let refused = [renderer.set_light(light, spot), renderer.remove_lights(&[light])];
            for refused in refused {
                assert!(
                    matches!(refused, Err(Error::Light { light: refused, .. }) if refused == light)
                );
            }
        }

        // Pipelines without spot lights do not take one, even in the place of a lamp.
        let mut renderer = with(&room(), 0, 0).unwrap();
        renderer.remove_lights(&[LightId(3)]).unwrap();
        assert_eq!(no_room(&mut renderer, &[spot]), ("spot lights", 1, 0));
        assert_eq!(renderer.add_lights(&[lamp]).unwrap(), [LightId(3)]);

        let error = with(&room(), 0, 5).err().unwrap().to_string();
        assert!(error.contains("5 directional lights") && error.contains("at most 4"), "{error}");
        let error = with(&room(), 1 << 16, 0).err().unwrap().to_string();
        assert!(error.contains("65566 lights"), "{error}");

        let mut plain = with(&shapes::box_scene(&[]), 1, 1).unwrap();
        assert_eq!(no_room(&mut plain, &[lamp]).2, 0);
        assert!(plain.add_lights(&[]).unwrap().is_empty());
    });
}
