//! Poses of skinned meshes: the boxes of objects follow their poses, and only poses that a view may
//! show are uploaded.

use cull::{Aabb, Camera, ObjectId, Strategy};
use glam::{Affine3A, Quat, Vec3, vec3};
use gpu::{Device, Readback};
use render::{ChangeError, DebugOverlay, Error, FrameRequest, PoseError, RenderView, Renderer};
use scene::{MeshId, Object, ObjectChange, PoseUpdate, Scene, SceneUpdate, SkinnedMeshId};
use tests::walk::images_that_differ;
use tests::{Driver, run, run_on_all};

use crate::shading::skinning::{
    Pose, SIZE, WIDTH_M, camera, draw, options, pixels_far_apart, pose, scene, take, turns,
};

/// Returns the box of an object in the world.
fn bounds(renderer: &Renderer, object: u32) -> Aabb {
    let node = renderer.hierarchy().node_of(ObjectId(object)).unwrap();
    renderer.hierarchy().bounds(node)
}

#[test]
fn the_box_of_an_object_is_that_of_its_pose_wherever_it_is() {
    run_on_all(|device| {
        let scene = scene();
        let mut renderer = Renderer::new(device, &scene, &options(2)).unwrap();
        let is_near = |found: Aabb, expected: Aabb| {
            let apart = (found.min - expected.min).abs().max((found.max - expected.max).abs());
            assert!(apart.max_element() < 1e-3, "{found:?} for {expected:?}");
        };
        let at_rest = bounds(&renderer, 0);
        let others = bounds(&renderer, 4);
        let wide = Affine3A::from_scale(vec3(3.0, 1.0, 1.0));
        renderer.set_pose(SkinnedMeshId(0), &[wide; 3], &[0.0; 2]).unwrap();
        let mut posed = at_rest;
        posed.max.x = at_rest.min.x + 3.0 * WIDTH_M;
        is_near(bounds(&renderer, 0), posed);
        let aside = Affine3A::from_translation(vec3(0.0, 7.0, 0.0));
        let transform = aside * scene.objects[0].transform;
        let there = Aabb::new(posed.min + 7.0 * Vec3::Y, posed.max + 7.0 * Vec3::Y);
        renderer.update(&[ObjectChange::Move { object: ObjectId(0), transform }]).unwrap();
        is_near(bounds(&renderer, 0), there);
        // Both changes at once, the place first.
        let joints = vec![Affine3A::IDENTITY; 3];
        let update = SceneUpdate {
            objects: vec![ObjectChange::Move {
                object: ObjectId(0),
                transform: scene.objects[0].transform,
            }],
            poses: vec![PoseUpdate { skinned_mesh: SkinnedMeshId(0), joints: 0..3, weights: 0..2 }],
            joints,
            weights: vec![0.0; 2],
            ..SceneUpdate::default()
        };
        assert_eq!(renderer.apply(&update).unwrap().poses, 1);
        is_near(bounds(&renderer, 0), at_rest);
        assert_eq!(renderer.apply(&update).unwrap().poses, 0, "it has that pose");
        assert_eq!(bounds(&renderer, 4), others);
        // The box of a skinned mesh cannot belong to another object.
        renderer.set_pose(SkinnedMeshId(0), &[wide; 3], &[0.0; 2]).unwrap();
        let second = ObjectChange::Add { object: scene.objects[0] };
        let gone = ObjectChange::Remove { object: ObjectId(0) };
        assert!(renderer.update(&[second]).unwrap_err().to_string().contains("another object"));
        assert!(renderer.update(&[gone, second, second]).is_err());
        renderer.update(&[gone]).unwrap();
        renderer.set_pose(SkinnedMeshId(0), &[Affine3A::IDENTITY; 3], &[0.0; 2]).unwrap();
        renderer.set_pose(SkinnedMeshId(0), &[wide; 3], &[0.0; 2]).unwrap();
        let added = renderer.update(&[second]).unwrap().added;
        is_near(bounds(&renderer, added[0].0), posed);
    });
}

/// Returns the work for poses in a frame that is seen along `forward`.
fn skinned(renderer: &mut Renderer, view: &mut RenderView, forward: Vec3) -> (u32, u64) {
    let camera = Camera { forward, ..camera() };
    // Without a test, everything in the frustum is certainly drawn.
    let report = renderer.render(view, FrameRequest::new(Strategy::FRUSTUM, camera)).unwrap();
    (report.poses, report.skinned_vertices)
}

#[test]
fn poses_wait_until_a_view_may_show_them() {
    run_on_all(|device| {
        let scene = scene();
        let vertices = scene.meshes[0].vertices.len() as u64;
        let mut renderer = Renderer::new(device, &scene, &options(2)).unwrap();
        let mut view = renderer.new_view().unwrap();
        let there = camera().forward;
        let away = -camera().forward;
        let mut look = |renderer: &mut Renderer, forward| skinned(renderer, &mut view, forward);
        assert_eq!(look(&mut renderer, there), (0, 0), "there was no pose");
        take(&mut renderer, [0.5, 0.7]);
        assert_eq!(look(&mut renderer, away), (0, 0), "nobody sees it");
        take(&mut renderer, [0.6, 0.9]);
        assert_eq!(look(&mut renderer, there), (2, 2 * vertices), "the newest of each");
        assert_eq!(look(&mut renderer, there), (0, 0), "it is there");
        // An object leaves the view. Its vertices on the GPU are still in the visible place, so its
        // pose is uploaded.
        let Pose { joints, weights } = pose(0.2);
        let far = |by: f32| joints.map(|joint| Affine3A::from_translation(Vec3::Z * by) * joint);
        renderer.set_pose(SkinnedMeshId(0), &far(50.0), &weights).unwrap();
        assert_eq!(look(&mut renderer, there), (1, vertices));
        renderer.set_pose(SkinnedMeshId(0), &far(60.0), &weights).unwrap();
        assert_eq!(look(&mut renderer, there), (0, 0), "neither is seen");
        // Behind the camera, the last visible pose stays.
        assert_eq!(look(&mut renderer, away), (1, vertices));
        renderer.update(&[ObjectChange::Remove { object: ObjectId(0) }]).unwrap();
        renderer.set_pose(SkinnedMeshId(0), &far(10.0), &weights).unwrap();
        assert_eq!(look(&mut renderer, away), (0, 0), "no object has it");
        renderer.wait_idle(&mut view).unwrap();
    });
}

#[test]
fn what_stays_hidden_is_not_skinned() {
    run_on_all(|device| {
        let scene = scene();
        let vertices = scene.meshes[1].vertices.len() as u64;
        for strategy in [Strategy::ANTUMBRA, Strategy::ANTUMBRA_QUERIES] {
            let mut renderer = Renderer::new(device, &scene, &options(2)).unwrap();
            let mut reference = Renderer::new(device, &scene, &options(2)).unwrap();
            let mut view = renderer.new_view().unwrap();
            let mut frame = |turn: f32, offset: Vec3| {
                let Pose { joints, weights } = pose(turn);
                let joints = joints.map(|joint| Affine3A::from_translation(offset) * joint);
                for renderer in [&mut renderer, &mut reference] {
                    renderer.set_pose(SkinnedMeshId(1), &joints, &weights).unwrap();
                }
                let image = Readback::new(device, SIZE).unwrap();
                let request =
                    FrameRequest { image: Some(&image), ..FrameRequest::new(strategy, camera()) };
                let report = renderer.render(&mut view, request).unwrap();
                renderer.wait_idle(&mut view).unwrap();
                let expected = draw(&mut reference, Strategy::FRUSTUM);
                let wrong = images_that_differ(&expected, &image);
                assert_eq!(wrong, 0, "{strategy}, turn {turn}");
                report
            };
            // Behind the wall, which is not yet known to be in front.
            for number in 0..8 {
                frame(0.02 * number as f32, Vec3::ZERO);
            }
            for number in 0..8 {
                let report = frame(0.01 + 0.02 * number as f32, Vec3::ZERO);
                assert_eq!((report.poses, report.skinned_vertices), (1, 0), "{strategy}");
                assert!(report.predicated_vertices >= vertices, "{strategy}");
                assert_eq!(report.revealed_vertices, 0, "{strategy}: it was skinned");
            }
            // The object jumps above the wall: a test reveals it, and then it counts as visible.
            let above = |number| frame(0.1 * number as f32, vec3(0.0, 4.0, 0.0));
            let reports: Vec<_> = (0..6).map(above).collect();
            assert!(reports[0].predicated_vertices >= vertices, "{strategy}");
            assert!(reports[1].revealed_vertices >= vertices, "{strategy}: nobody skinned it");
            assert!(
                reports[2..].iter().any(|report| report.skinned_vertices == vertices),
                "{strategy}"
            );
        }
    });
}

#[test]
fn a_pose_that_came_behind_a_wall_shows_when_the_wall_goes() {
    run_on_all(|device| {
        let Pose { joints, weights } = pose(0.1);
        let mut renderer = Renderer::new(device, &scene(), &options(2)).unwrap();
        let mut view = renderer.new_view().unwrap();
        let mut frame = |renderer: &mut Renderer| {
            let image = Readback::new(device, SIZE).unwrap();
            let request = FrameRequest::new(Strategy::ANTUMBRA, camera());
            let request = FrameRequest { image: Some(&image), ..request };
            let report = renderer.render(&mut view, request).unwrap();
            renderer.wait_idle(&mut view).unwrap();
            (report, image)
        };
        for _ in 0..8 {
            frame(&mut renderer);
        }
        renderer.set_pose(SkinnedMeshId(1), &joints, &weights).unwrap();
        for _ in 0..4 {
            let (report, _) = frame(&mut renderer);
            assert_eq!(report.skinned_vertices, 0, "it is hidden");
        }
        let wall = ObjectChange::Remove { object: ObjectId(2) };
        renderer.update(&[wall]).unwrap();
        let (_, found) = frame(&mut renderer);
        let mut reference = Renderer::new(device, &scene(), &options(2)).unwrap();
        reference.update(&[wall]).unwrap();
        reference.set_pose(SkinnedMeshId(1), &joints, &weights).unwrap();
        let expected = draw(&mut reference, Strategy::FRUSTUM);
        assert_eq!(images_that_differ(&expected, &found), 0);
    });
}

/// Returns all frames of a camera that looks around. With `sees_all`, all poses are uploaded in
/// each frame.
fn looking_about(device: &Device, strategy: Strategy, sees_all: bool) -> Vec<Readback> {
    let mut renderer = Renderer::new(device, &scene(), &options(2)).unwrap();
    if sees_all {
        let debug_overlay = DebugOverlay { has_boxes: true, ..DebugOverlay::default() };
        renderer.set_debug_overlay(debug_overlay).unwrap();
    }
    let mut view = renderer.new_view().unwrap();
    let frame = |frame: u32| {
        take(&mut renderer, turns(frame));
        let turn = Quat::from_rotation_y(frame as f32 * 0.8);
        let camera = Camera { forward: turn * camera().forward, ..camera() };
        let image = Readback::new(device, SIZE).unwrap();
        let request =
            FrameRequest { scene_image: Some(&image), ..FrameRequest::new(strategy, camera) };
        renderer.render(&mut view, request).unwrap();
        image
    };
    let images = (0..20).map(frame).collect();
    renderer.wait_idle(&mut view).unwrap();
    images
}

#[test]
fn who_looks_about_sees_the_newest_poses() {
    run_on_all(|device| {
        let expected = looking_about(device, Strategy::FRUSTUM, true);
        for strategy in [Strategy::FRUSTUM, methods::HZB, Strategy::ANTUMBRA] {
            let found = looking_about(device, strategy, false);
            for (frame, (expected, found)) in expected.iter().zip(&found).enumerate() {
                let wrong = images_that_differ(expected, found);
                assert_eq!(wrong, 0, "{strategy}, frame {frame}");
            }
        }
    });
}

#[test]
fn what_is_blended_is_where_its_pose_brings_it() {
    run_on_all(|device| {
        let mut scene = scene();
        scene.objects.drain(1..2);
        let surfaces = scene.surfaces.as_mut().unwrap();
        surfaces.skinned_meshes.remove(0);
        // Far behind the camera at rest.
        let transform = Affine3A::from_translation(vec3(-1.0, 0.0, 40.0));
        surfaces.transparent = vec![Object { mesh: MeshId(1), transform, tint: u32::MAX }];
        let mut renderer = Renderer::new(device, &scene, &options(2)).unwrap();
        let before = draw(&mut renderer, Strategy::ANTUMBRA);
        let near = Affine3A::from_translation(vec3(0.0, 0.0, -44.0));
        renderer.set_pose(SkinnedMeshId(0), &[near; 3], &[0.0; 2]).unwrap();
        let after = draw(&mut renderer, Strategy::ANTUMBRA);
        assert!(pixels_far_apart(&before, &after) > 500, "it is before the camera now");
        let exact = draw(&mut renderer, Strategy::FRUSTUM);
        assert_eq!(images_that_differ(&exact, &after), 0);
    });
}

#[test]
fn bad_poses_are_refused_and_change_nothing() {
    run(Driver::Lavapipe, |device| {
        let scene = scene();
        let mut renderer = Renderer::new(device, &scene, &options(2)).unwrap();
        let before = draw(&mut renderer, Strategy::FRUSTUM);
        let Pose { joints, weights } = pose(0.4);
        let nowhere = Affine3A::from_translation(Vec3::splat(f32::NAN));
        let mut refuse = |skinned_mesh, joints: &[Affine3A], weights: &[f32], expected| {
            let skinned_mesh = SkinnedMeshId(skinned_mesh);
            match renderer.set_pose(skinned_mesh, joints, weights).unwrap_err() {
                Error::Pose { skinned_mesh: refused, reason } => {
                    assert_eq!((refused, reason), (skinned_mesh, expected));
                }
                other => panic!("{other}"),
            }
        };
        refuse(2, &joints, &weights, PoseError::UnknownSkinnedMesh);
        refuse(0, &joints[..2], &weights, PoseError::JointCount { joints: 3, given: 2 });
        refuse(0, &joints, &weights[..1], PoseError::TargetCount { targets: 2, given: 1 });
        let torn = [joints[0], nowhere, joints[2]];
        refuse(1, &torn, &weights, PoseError::JointNotFinite { joint: 1 });
        refuse(1, &joints, &[0.0, f32::INFINITY], PoseError::WeightNotFinite { target: 1 });
        let far = Affine3A::from_translation(Vec3::splat(2e15));
        refuse(1, &[joints[0], far, joints[2]], &weights, PoseError::MeshOutOfRange);
        refuse(1, &joints, &[0.0, f32::MAX], PoseError::MeshOutOfRange);
        let grows = Affine3A::from_scale(Vec3::splat(1e9));
        let change = ObjectChange::Move { object: ObjectId(1), transform: grows };
        renderer.update(&[change]).unwrap();
        let error = renderer.set_pose(SkinnedMeshId(1), &[grows; 3], &weights).unwrap_err();
        assert!(
            matches!(error, Error::Pose { reason: PoseError::ObjectOutOfRange, .. }),
            "{error}"
        );
        let twin = ObjectChange::Add { object: scene.objects[1] };
        let error = renderer.update(&[twin]).unwrap_err();
        let mesh = scene.objects[1].mesh;
        let expected = ChangeError::SkinnedMeshInUse { mesh };
        assert!(matches!(&error, Error::Change { reason, .. } if *reason == expected), "{error}");
        let transform = scene.objects[1].transform;
        renderer.update(&[ObjectChange::Move { object: ObjectId(1), transform }]).unwrap();
        let after = draw(&mut renderer, Strategy::FRUSTUM);
        assert_eq!(images_that_differ(&before, &after), 0);
        let plain = Scene { surfaces: None, ..scene };
        let mut renderer = Renderer::new(device, &plain, &options(2)).unwrap();
        assert!(renderer.set_pose(SkinnedMeshId(0), &joints, &weights).is_err());
    });
}
