//! Frames in which some kind of work is empty: skinned meshes that are not drawn, empty views,
//! lights without casters, rounds without tests. Commands must wait for every clear even if nothing
//! writes after it, which synchronization validation checks.

use cull::{Camera, Strategy};
use glam::{Affine3A, Quat, Vec3, vec3};
use gpu::{Device, Readback};
use render::{Rect, RenderView, Renderer, RendererOptions, ViewRequest, ViewsRequest};
use scene::{
    Alpha, LightKind, Material, MaterialId, MeshId, Object, PunctualLight, Scene, Surfaces,
};
use shadows::{ShadowMethod, ShadowOptions};
use tests::shapes::{box_scene, surface_of};
use tests::walk::images_that_differ;
use tests::{Driver, run};

use crate::shading::skinning;

const SIZE: [u32; 2] = [96, 54];

/// The direction of a camera, which decides about the visible objects.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Sight {
    /// A wall that hides all skinned and transparent objects: their work waits for tests, and they
    /// are not drawn.
    Wall,
    /// Nothing.
    Nothing,
    /// Everything but the wall.
    All,
}

impl Sight {
    /// Returns the camera.
    fn camera(self) -> Camera {
        let (eye, forward) = match self {
            Self::Wall => (vec3(0.0, 1.0, 4.0), Vec3::NEG_Z),
            Self::Nothing => (vec3(0.0, 1.0, 4.0), Vec3::Z),
            Self::All => (vec3(0.0, 1.0, -14.0), Vec3::Z),
        };
        Camera { eye, forward, ..skinning::camera() }
    }
}

/// A sequence in which each sight follows each other sight.
const SIGHTS: [Sight; 7] =
    [Sight::Wall, Sight::Wall, Sight::Nothing, Sight::All, Sight::Wall, Sight::All, Sight::Nothing];

/// Returns a wall, two skinned slabs and a pane behind it.
fn scene(lights: &[PunctualLight]) -> Scene {
    let skinned = skinning::scene();
    let surfaces = skinned.surfaces.unwrap();
    let mut meshes = skinned.meshes;
    meshes.push(meshes[2].clone());
    let at = |mesh, low: Vec3, size: Vec3| {
        let transform = Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, low);
        Object { mesh: MeshId(mesh), transform, tint: u32::MAX }
    };
    let pane = MaterialId(1);
    let opaque = Material { metallic: 0.0, ..Material::default() };
    let glass =
        Material { alpha: Alpha::Blend, base_colour: [0.2, 0.8, 0.3, 0.5], ..opaque.clone() };
    let mut surface_meshes: Vec<_> =
        meshes.iter().map(|mesh| surface_of(mesh, MaterialId(0))).collect();
    surface_meshes[4] = surface_of(&meshes[4], pane);
    let surfaces = Surfaces {
        meshes: surface_meshes,
        materials: vec![opaque, glass],
        lights: lights.to_vec(),
        transparent: vec![at(4, vec3(-0.5, 0.0, -8.5), vec3(1.0, 2.0, 0.2))],
        skinned_meshes: surfaces.skinned_meshes,
        ..Surfaces::default()
    };
    let objects = vec![
        at(0, vec3(-3.0, -0.5, -6.0), Vec3::splat(0.5)),
        at(1, vec3(1.0, -0.5, -7.0), Vec3::splat(0.5)),
        at(2, vec3(-12.0, -6.0, -2.0), vec3(24.0, 16.0, 0.5)),
    ];
    Scene { meshes, objects, surfaces: Some(surfaces), ..box_scene(&[]) }
}

/// Returns a sun and a lamp that reach everything, or a lamp that reaches nothing.
fn lights(meets_objects: bool) -> Vec<PunctualLight> {
    let light = |kind, position, range_m| PunctualLight {
        kind,
        colour: [1.0; 3],
        intensity: 2.0,
        range_m,
        position,
        direction: vec3(-0.3, -0.8, -0.6).normalize(),
        cookie: None,
    };
    if meets_objects {
        vec![
            light(LightKind::Directional, Vec3::ZERO, None),
            light(LightKind::Point, vec3(0.0, 3.0, -9.0), Some(20.0)),
        ]
    } else {
        vec![light(LightKind::Point, vec3(0.0, 500.0, 0.0), Some(2.0))]
    }
}

/// Renders all frames with one strategy, with one or two views. The second view looks where the
/// first view looked in the previous frame.
fn film(renderer: &mut Renderer, strategy: Strategy, view_count: usize) -> Vec<Readback> {
    let mut finder = renderer.new_view().unwrap();
    let mut states: Vec<RenderView> =
        (0..view_count).map(|_| renderer.new_view().unwrap()).collect();
    let areas: Vec<Rect> = Rect::side_by_side(SIZE, view_count as u32).collect();
    let mut images = Vec::new();
    for frame in 0..SIGHTS.len() {
        // A new pose in each frame, whose work waits for the test of its object.
        skinning::take(renderer, skinning::turns(frame as u32));
        let cameras: Vec<Camera> = (0..view_count)
            .map(|view| SIGHTS[(frame + SIGHTS.len() - view) % SIGHTS.len()].camera())
            .collect();
        let image = Readback::new(renderer.device(), SIZE).unwrap();
        let sets: Vec<_> = cameras
            .iter()
            .zip(&areas)
            .map(|(camera, area)| {
                let is_wanted = strategy == methods::IDEAL;
                is_wanted.then(|| renderer.visible_set(&mut finder, *camera, *area).unwrap())
            })
            .collect();
        let mut targets: Vec<ViewRequest<'_>> = states
            .iter_mut()
            .zip(&cameras)
            .zip(areas.iter().zip(&sets))
            .map(|((state, camera), (area, set))| ViewRequest {
                state,
                viewpoint: (*camera).into(),
                visible: set.as_ref(),
                rect: *area,
            })
            .collect();
        let request = ViewsRequest { strategy, image: Some(&image), overlay: None, after: None };
        renderer.render_views(&mut targets, &request).unwrap();
        images.push(image);
    }
    for state in &mut states {
        renderer.wait_idle(state).unwrap();
    }
    images
}

/// Walks with every strategy that the device supports. Exact strategies draw the images of plain
/// frustum culling.
fn check(device: &Device, lights: &[PunctualLight], method: ShadowMethod) {
    let scene = scene(lights);
    // Room for the maps of all lights and views, so that maps do not depend on earlier frames.
    let shadows = ShadowOptions { method, sun_side: 256, layers_max: 16, ..Default::default() };
    let options = RendererOptions { size: SIZE, shadows, ..skinning::options(2) };
    let mut renderer = Renderer::new(device, &scene, &options).unwrap();
    let strategies: Vec<Strategy> = methods::strategies()
        .into_iter()
        .filter(|strategy| renderer.supports(*strategy).is_ok())
        .collect();
    for view_count in [1, 2] {
        let expected = film(&mut renderer, Strategy::FRUSTUM, view_count);
        for strategy in strategies.iter().filter(|strategy| **strategy != Strategy::FRUSTUM) {
            let images = film(&mut renderer, *strategy, view_count);
            for (frame, (expected, image)) in expected.iter().zip(&images).enumerate() {
                let wrong = images_that_differ(expected, image);
                assert!(
                    wrong == 0 || !strategy.is_exact(),
                    "{strategy}, {view_count} views, frame {frame}: {wrong} pixels"
                );
            }
        }
    }
}

#[test]
fn without_lights() {
    run(Driver::Lavapipe, |device| check(device, &[], ShadowMethod::Off));
}

#[test]
fn with_shadow_maps() {
    run(Driver::Lavapipe, |device| {
        for meets_objects in [false, true] {
            check(device, &lights(meets_objects), ShadowMethod::Maps);
        }
    });
}

#[test]
fn with_shadow_volumes() {
    run(Driver::Lavapipe, |device| {
        for meets_objects in [false, true] {
            check(device, &lights(meets_objects), ShadowMethod::Volumes);
        }
    });
}
