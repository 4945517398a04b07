//! Changes while shadow volumes are drawn: the image equals a new renderer of the changed scene.

use cull::{Aabb, Camera, ObjectId, Strategy};
use glam::{Affine3A, Vec3, vec3};
use gpu::Device;
use render::{CostModel, Renderer, RendererOptions, SpareCapacity};
use scene::{
    Alpha, LodLevel, Material, MaterialId, MeshId, Object, ObjectChange, PoseUpdate, PreparedMesh,
    Scene, SceneUpdate, SkinnedMeshId, SurfaceMesh,
};
use shadows::{ShadowMethod, ShadowOptions};
use tests::walk::pixels_that_differ;
use tests::{run_on_all, shadow_scene, shapes};

use super::{SIZE, fresh, image, renderer, volumes};
use crate::shadows::shadow_maps::cache::{FIGURE, scene as scene_with_figure};
use crate::shadows::shadow_maps::shadows as maps;

#[test]
fn methods_are_switched_and_each_is_as_if_it_had_always_been() {
    run_on_all(|device| {
        let scene = scene_with_figure();
        let options = |method| ShadowOptions { method, ..maps() };
        let expected = ShadowMethod::ALL
            .map(|method| fresh(device, &scene, options(method), shadow_scene::camera()));
        for (number, image) in expected.iter().enumerate() {
            assert!(!expected[..number].contains(image), "the methods look different");
        }
        let mut renderer = renderer(device, &scene, options(ShadowMethod::Maps));
        let mut view = renderer.new_view().unwrap();
        for number in [2, 1, 2, 0, 2, 0, 1] {
            renderer.set_shadows(options(ShadowMethod::ALL[number])).unwrap();
            for _ in 0..2 {
                let found =
                    image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
                assert_eq!(pixels_that_differ(&expected[number], &found), 0, "method {number}");
            }
        }
    });
}

#[test]
fn movers_and_objects_that_come_and_go_have_their_volumes() {
    run_on_all(|device| {
        let boxes = shadow_scene::boxes();
        let mut renderer =
            renderer(device, &shadow_scene::scene(&boxes, &shadow_scene::lights()), volumes());
        let mut view = renderer.new_view().unwrap();
        for frame in 0..6 {
            let away = vec3(0.4, 0.1, 0.2) * frame as f32;
            let mut now = boxes.clone();
            now[3] = Aabb::new(now[3].min + away, now[3].max + away);
            let new = Aabb::new(vec3(-4.0, 1.0, 3.0) + away, vec3(-3.0, 1.5, 4.0) + away);
            let moved = ObjectChange::Move {
                object: ObjectId(3),
                transform: shadow_scene::transform_of(&now[3]),
            };
            let object = Object {
                mesh: MeshId(0),
                transform: shadow_scene::transform_of(&new),
                tint: u32::MAX,
            };
            let added = renderer.update(&[moved, ObjectChange::Add { object }]).unwrap().added;
            now.push(new);
            let found = image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
            let scene = shadow_scene::scene(&now, &shadow_scene::lights());
            let expected = fresh(device, &scene, volumes(), shadow_scene::camera());
            assert_eq!(pixels_that_differ(&expected, &found), 0, "frame {frame}");
            renderer.update(&[ObjectChange::Remove { object: added[0] }]).unwrap();
        }
        let back = shadow_scene::transform_of(&boxes[3]);
        renderer.update(&[ObjectChange::Move { object: ObjectId(3), transform: back }]).unwrap();
        let found = image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
        let first = shadow_scene::scene(&boxes, &shadow_scene::lights());
        assert!(found == fresh(device, &first, volumes(), shadow_scene::camera()));
    });
}

/// Returns a pose of the figure: its upper joint turned and moved, and its bump as high as `bump`.
fn pose(frame: u32, bump: f32) -> SceneUpdate {
    let turn = Affine3A::from_rotation_y(frame as f32 * 0.4);
    let aside = Affine3A::from_translation(vec3(0.25 * frame as f32, 0.0, 0.0));
    SceneUpdate {
        joints: vec![Affine3A::IDENTITY, aside * turn],
        weights: vec![bump],
        poses: vec![PoseUpdate { skinned_mesh: SkinnedMeshId(0), joints: 0..2, weights: 0..1 }],
        ..SceneUpdate::default()
    }
}

#[test]
fn figures_cast_the_volumes_of_their_poses_also_if_no_view_shows_them() {
    run_on_all(|device| {
        let mut scene = scene_with_figure();
        let figure = scene.objects[FIGURE.0 as usize];
        let [sun, ..] = shadow_scene::lights();
        scene.surfaces.as_mut().unwrap().lights = vec![sun];
        // High above the ground ahead, behind and above the eye, so that only the shadow is
        // visible.
        let high = Affine3A::from_translation(vec3(1.5, 7.5, 3.0)) * figure.transform;
        scene.objects[FIGURE.0 as usize].transform = high;
        let camera = Camera {
            eye: vec3(-2.0, 4.0, 2.0),
            forward: vec3(-0.1, -0.9, -0.3).normalize(),
            ..shadow_scene::camera()
        };
        let mut moving = renderer(device, &scene, volumes());
        let mut view = moving.new_view().unwrap();
        let mut images = Vec::new();
        for frame in 0..4 {
            let update = pose(frame, frame as f32 * 0.2);
            moving.apply(&update).unwrap();
            let found = image(&mut moving, &mut view, Strategy::ANTUMBRA, camera);
            let mut other = renderer(device, &scene, volumes());
            other.apply(&update).unwrap();
            let mut its_view = other.new_view().unwrap();
            let expected = image(&mut other, &mut its_view, Strategy::FRUSTUM, camera);
            assert_eq!(pixels_that_differ(&expected, &found), 0, "frame {frame}");
            images.push(found);
        }
        let mut posed_mesh = posed_as_a_mesh(&scene, &pose(3, 3.0 * 0.2));
        posed_mesh.surfaces.as_mut().unwrap().skinned_meshes.clear();
        let expected = fresh(device, &posed_mesh, volumes(), camera);
        let wrong = pixels_that_differ(&expected, &images[3]);
        assert!(wrong < 16, "{wrong} pixels differ from a mesh of that shape");
        let moved = pixels_that_differ(&images[0], &images[3]);
        assert!(moved > 40, "its shadow changed at {moved} pixels");
    });
}

/// Returns the scene with a posed mesh in the place of the figure.
fn posed_as_a_mesh(scene: &Scene, update: &SceneUpdate) -> Scene {
    let mut posed = scene.clone();
    let skinned = &scene.surfaces.as_ref().unwrap().skinned_meshes[0];
    let skin = skinned.skin.as_ref().unwrap();
    let mesh = &mut posed.meshes[1];
    for (number, vertex) in mesh.vertices.iter_mut().enumerate() {
        let by = Vec3::from(skinned.targets[0].positions[number]) * update.weights[0];
        let joint = update.joints[usize::from(skin.joints[number][0])];
        vertex.position = joint.transform_point3(Vec3::from(vertex.position) + by).to_array();
    }
    let places = mesh.vertices.iter().map(|vertex| Vec3::from(vertex.position));
    mesh.bounds = places.fold(Aabb::EMPTY, |all, at| all.union(&Aabb::new(at, at)));
    posed
}

/// Returns the yard without its small boxes, and the camera over it.
fn streamed(device: &Device, scene: &Scene, shadows: ShadowOptions) -> Renderer {
    let spare = SpareCapacity {
        meshes: 1,
        vertices: 300,
        indices: 1200,
        levels: 1,
        ..SpareCapacity::default()
    };
    let options = RendererOptions {
        size: SIZE,
        cost_model: CostModel::Off,
        spare_objects: 2,
        spare,
        upload_bytes_per_frame: 1500,
        methods: methods::all(),
        shadows,
        ..RendererOptions::default()
    };
    Renderer::new(device, scene, &options).unwrap()
}

#[test]
fn meshes_that_come_later_cast_volumes_when_they_are_there() {
    run_on_all(|device| {
        let first = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let mesh = shapes::cube(u32::MAX, 4);
        let object = Object {
            mesh: MeshId(1),
            transform: shadow_scene::transform_of(&Aabb::new(
                vec3(-5.0, 1.0, 3.0),
                vec3(-3.0, 2.0, 5.0),
            )),
            tint: u32::MAX,
        };
        let mut whole = first.clone();
        let surface = shapes::surface_of(&mesh, MaterialId(0));
        whole.meshes.push(mesh.clone());
        whole.surfaces.as_mut().unwrap().meshes.push(surface.clone());
        whole.objects.push(object);
        let expected = fresh(device, &whole, volumes(), shadow_scene::camera());
        let without = fresh(device, &first, volumes(), shadow_scene::camera());
        // Volumes from the start, and volumes that are switched on, off and on again during the
        // upload of the mesh.
        for switches in [&[][..], &[1], &[1, 2, 3], &[3, 4, 5]] {
            let begins = if switches.is_empty() { volumes() } else { ShadowOptions::default() };
            let mut renderer = streamed(device, &first, begins);
            let mut view = renderer.new_view().unwrap();
            let level = LodLevel { indices: mesh.indices.clone(), error_m: 0.1 };
            let prepared = PreparedMesh::with_surface(mesh.clone(), surface.clone(), vec![level]);
            let ids = renderer.add_meshes(vec![prepared.unwrap()]).unwrap();
            assert_eq!(ids, [MeshId(1)]);
            renderer.update(&[ObjectChange::Add { object }]).unwrap();
            let mut frames = 0;
            while renderer.is_uploading() || frames < 8 {
                if switches.contains(&frames) {
                    let is_on = renderer.shadows().method == ShadowMethod::Volumes;
                    let next = if is_on { ShadowOptions::default() } else { volumes() };
                    renderer.set_shadows(next).unwrap();
                }
                let is_on = renderer.shadows().method == ShadowMethod::Volumes;
                let is_there = renderer.is_resident(ids[0]);
                let found =
                    image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
                let wanted = if is_there { &expected } else { &without };
                if is_on {
                    assert_eq!(
                        pixels_that_differ(wanted, &found),
                        0,
                        "{switches:?}, frame {frames}"
                    );
                }
                frames += 1;
            }
            assert!(frames > 5, "it came in pieces");
            assert_eq!(renderer.shadows().method, ShadowMethod::Volumes);
            assert!(renderer.is_resident(ids[0]));
        }
    });
}

#[test]
fn masked_and_coarse_objects_shade_nothing_that_they_should_not() {
    run_on_all(|device| {
        let mut scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let surfaces = scene.surfaces.as_mut().unwrap();
        // The coarsest possible level: a different shape that is drawn and extruded instead.
        let a = 0;
        let b = 1;
        let c = 2;
        let d = 3;
        let level = LodLevel { indices: vec![a, b, c, a, c, d], error_m: 0.5 };
        let finest = scene.meshes[0].indices.clone();
        surfaces.levels = vec![vec![LodLevel { indices: finest, ..level }]];
        let plain = fresh(device, &scene, volumes(), shadow_scene::camera());
        let mut coarse = renderer(device, &scene, volumes());
        let policy = cull::DetailPolicy { error_pixels: 1.0e6, hysteresis: 0.0, by_samples: None };
        assert!(coarse.choose_detail(&[shadow_scene::camera()], &policy) > 0);
        let mut view = coarse.new_view().unwrap();
        let found = image(&mut coarse, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
        assert!(found == plain, "a level of the same triangles casts the same shadows");
        let surfaces = scene.surfaces.as_mut().unwrap();
        surfaces.levels.clear();
        let material =
            Material { alpha: Alpha::Mask { cutoff: 0.5 }, ..surfaces.materials[0].clone() };
        surfaces.materials[0] = material;
        let mut masked = renderer(device, &scene, volumes());
        let mut view = masked.new_view().unwrap();
        let found = image(&mut masked, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
        let lit = fresh(device, &scene, ShadowOptions::default(), shadow_scene::camera());
        let differ = found.iter().zip(&lit).filter(|(a, b)| a.abs_diff(**b) > 1).count();
        assert_eq!((differ, masked.shadow_stats().casters), (0, 0), "holes cast no volumes");
    });
}

#[test]
fn what_is_transparent_or_drawn_from_elsewhere_has_no_volumes() {
    run_on_all(|device| {
        let mut scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let mut glass = scene.meshes[0].clone();
        glass.name = "glass".to_owned();
        scene.meshes.push(glass);
        let surfaces = scene.surfaces.as_mut().unwrap();
        let surface = SurfaceMesh { material: MaterialId(1), ..surfaces.meshes[0].clone() };
        surfaces.meshes.push(surface);
        let base_colour = [0.9, 0.3, 0.2, 0.5];
        let glass = Material { alpha: Alpha::Blend, base_colour, ..surfaces.materials[0].clone() };
        surfaces.materials.push(glass);
        // Under the roof, and over the ground before it.
        let pane = Aabb::new(vec3(5.5, 0.2, 1.0), vec3(8.5, 2.2, 1.2));
        let transform = shadow_scene::transform_of(&pane);
        surfaces.transparent = vec![Object { mesh: MeshId(1), transform, tint: u32::MAX }];
        let [mut lit, mut shadowed] = [ShadowOptions::default(), volumes()].map(|options| {
            let renderer = renderer(device, &scene, options);
            let view = renderer.new_view().unwrap();
            (renderer, view)
        });
        let looks = [Strategy::FRUSTUM, Strategy::ANTUMBRA].map(|strategy| {
            image(&mut shadowed.0, &mut shadowed.1, strategy, shadow_scene::camera())
        });
        assert_eq!(pixels_that_differ(&looks[0], &looks[1]), 0);
        let before = image(&mut lit.0, &mut lit.1, Strategy::ANTUMBRA, shadow_scene::camera());
        assert!(pixels_that_differ(&before, &looks[0]) > 500, "there are shadows");
        let [a, b] = [lit, shadowed].map(|(mut renderer, mut view)| {
            let seen = renderer.view_of(&shadow_scene::camera());
            let moment = renderer.snapshot(&mut view, seen).unwrap();
            let image = gpu::Readback::new(device, SIZE).unwrap();
            let camera = Camera { eye: vec3(0.0, 14.0, 9.0), ..shadow_scene::camera() };
            renderer.render_snapshot(&moment, camera, Some(&image), None).unwrap();
            device.wait_idle().unwrap();
            image.rgba8().unwrap().to_vec()
        });
        // The two passes are compiled separately, so the last bit may be rounded differently.
        let differ = a.iter().zip(&b).filter(|(a, b)| a.abs_diff(**b) > 1).count();
        assert_eq!(differ, 0, "a view without a mask is lit");
    });
}
