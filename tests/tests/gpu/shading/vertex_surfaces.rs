//! Scenes with surfaces whose colours are in the vertices: they look the same as without surfaces,
//! including their tints, even while lights are added and removed.

use cull::{Camera, ObjectId, Strategy};
use glam::{Affine3A, Vec3, vec3};
use gpu::{Device, Readback};
use render::{CostModel, Error, FrameRequest, Renderer, RendererOptions};
use scene::{
    Alpha, Light, LightKind, Material, MaterialId, MeshId, Object, ObjectChange, PunctualLight,
    Scene, pack_unorm,
};
use scenes::{CameraPath, PathKind};
use tests::run_on_all;
use tests::shapes::{box_scene, cube};

const SIZE: [u32; 2] = [160, 96];

fn renderer(device: &Device, scene: &Scene) -> Renderer {
    let options = RendererOptions { size: SIZE, cost_model: CostModel::Off, ..Default::default() };
    Renderer::new(device, scene, &options).unwrap()
}

fn image(renderer: &mut Renderer, camera: Camera) -> Vec<u8> {
    let mut view = renderer.new_view().unwrap();
    let image = Readback::new(renderer.device(), SIZE).unwrap();
    let request =
        FrameRequest { image: Some(&image), ..FrameRequest::new(Strategy::FRUSTUM, camera) };
    renderer.render(&mut view, request).unwrap();
    renderer.wait_idle(&mut view).unwrap();
    image.rgba8().unwrap().to_vec()
}

fn camera() -> Camera {
    Camera {
        eye: vec3(4.0, 3.0, 9.0),
        forward: vec3(0.0, -0.2, -1.0),
        up: Vec3::Y,
        projection: cull::Projection::perspective(1.0),
        near: 0.1,
    }
}

const TINTS: [u32; 4] = [0xFF_3060F0, 0xFF_20D040, 0x00_E08010, 0xFF_FFFFFF];

/// Returns four cubes in a row, with these colours of vertices and these tints.
fn cubes(colours: [u32; 4], tints: [u32; 4]) -> Scene {
    let place = |number: usize| Affine3A::from_translation(vec3(number as f32 * 2.2, 0.0, 0.0));
    let object = |(number, tint): (usize, &u32)| Object {
        mesh: MeshId(number as u32),
        transform: place(number),
        tint: *tint,
    };
    Scene {
        meshes: colours.iter().map(|colour| cube(*colour, 3)).collect(),
        objects: tints.iter().enumerate().map(object).collect(),
        ..box_scene(&[])
    }
}

/// Returns the mean difference of the channels of two images, of 255.
fn mean_difference(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    let sum: u64 = a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.len() as f64
}

#[test]
fn a_tint_is_a_factor_of_the_vertex_colours_by_their_share() {
    run_on_all(|device| {
        let white = pack_unorm([1.0; 4]);
        let tinted = cubes([white; 4], TINTS).with_surfaces();
        let share = |colour: u32, share: u32| colour & 0xFF_FFFF | share << 24;
        // Vertices without a share of the tint keep their colour, whatever the tint of the object.
        let coloured = cubes(TINTS.map(|tint| share(tint, 0)), [0; 4]).with_surfaces();
        let plain = cubes([share(white, 0); 4], TINTS).with_surfaces();
        let [tinted, coloured, plain] =
            [tinted, coloured, plain].map(|scene| image(&mut renderer(device, &scene), camera()));
        assert_eq!(tinted, coloured);
        assert!(mean_difference(&tinted, &plain) > 1.0);
    });
}

#[test]
fn tints_stay_while_lights_come_and_go() {
    run_on_all(|device| {
        let mut scene = cubes([pack_unorm([1.0; 4]); 4], TINTS).with_surfaces();
        scene.surfaces.as_mut().unwrap().lights.push(PunctualLight {
            kind: LightKind::Point,
            colour: [1.0; 3],
            intensity: 4.0,
            range_m: Some(3.0),
            position: vec3(0.5, 0.5, 2.0),
            direction: Vec3::NEG_Z,
            cookie: None,
        });
        let mut moved = renderer(device, &scene);
        let before = image(&mut moved, camera());
        // The first cube leaves the range of the light, the last one enters it.
        for (object, x) in [(0, 6.6), (3, 0.0)] {
            let transform = Affine3A::from_translation(vec3(x, 0.0, 0.0));
            moved.update(&[ObjectChange::Move { object: ObjectId(object), transform }]).unwrap();
            scene.objects[object as usize].transform = transform;
        }
        let now = image(&mut moved, camera());
        assert!(mean_difference(&before, &now) > 1.0);
        assert_eq!(now, image(&mut renderer(device, &scene), camera()));
    });
}

#[test]
fn the_sky_and_a_material_change_as_if_they_had_always_been_so() {
    run_on_all(|device| {
        let mut scene = cubes([0xFF_FFFFFF; 4], TINTS).with_surfaces();
        let mut changed = renderer(device, &scene);
        let before = image(&mut changed, camera());
        let ambient_above = [0.1, 0.3, 0.2];
        scene.light = Light { ambient_above, sky: [0.2, 0.0, 0.1], ..scene.light };
        let material = &mut scene.surfaces.as_mut().unwrap().materials[0];
        material.base_colour = [0.5, 0.9, 0.4, 1.0];
        changed.set_scene_light(scene.light);
        changed.set_material(MaterialId(0), material).unwrap();
        let bright = Material { emission: [1.0; 3], ..material.clone() };
        let masked = Material { alpha: Alpha::Mask { cutoff: 0.5 }, ..material.clone() };
        let broken = Material { roughness: f32::NAN, ..material.clone() };
        for (id, refused) in [(0, bright), (0, masked), (0, broken), (9, material.clone())] {
            let refused = changed.set_material(MaterialId(id), &refused).unwrap_err();
            assert!(matches!(refused, Error::Material { .. }), "{refused}");
        }
        let now = image(&mut changed, camera());
        assert!(mean_difference(&before, &now) > 1.0);
        assert_eq!(now, image(&mut renderer(device, &scene), camera()));
    });
}

#[test]
fn a_city_with_surfaces_is_as_bright_as_without() {
    run_on_all(|device| {
        let city = scenes::city(300, 3).unwrap();
        let path = CameraPath::new(PathKind::Street, &city.routes).unwrap();
        let lit = city.scene.clone().with_surfaces();
        assert_eq!(lit.validate(), Ok(()));
        for frame in [0, 400] {
            let [plain, lit] = [&city.scene, &lit]
                .map(|scene| image(&mut renderer(device, scene), path.camera(frame)));
            let difference = mean_difference(&plain, &lit);
            assert!(difference < 8.0, "frame {frame}: {difference}");
            assert!(difference > 0.0, "they are shaded by different passes");
        }
    });
}
