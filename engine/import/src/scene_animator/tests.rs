//! Tests of the animator's changes at each time, without a device.

use animation::{
    Channel, Clip, Interpolation, Rest, Rig, RigNode, RigNodeId, Skin, Track, Trs, Values,
};
use cull::{Aabb, CullView, ObjectId};
use glam::{Affine3A, Quat, Vec3, Vec3A};
use scene::{
    LightId, LightKind, Mesh, MeshId, MorphTarget, Object, ObjectChange, PunctualLight, Scene,
    SkinWeights, SkinnedMesh, SkinnedMeshId, SurfaceMesh, Surfaces, TransparentId,
};

use super::*;
use crate::gltf_scene::NodeAttachment;

const REST: Trs = Trs { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE };

fn node(name: &str, parent: Option<u32>, translation: Vec3, weights: &[f32]) -> RigNode {
    RigNode {
        name: name.to_owned(),
        parent: parent.map(RigNodeId),
        rest: Rest::Parts(Trs { translation, ..REST }),
        weights: weights.to_vec(),
    }
}

fn track(node: u32, values: Values) -> Channel {
    let interpolation = Interpolation::Linear;
    Channel {
        node: RigNodeId(node),
        track: Track { interpolation, times_s: vec![0.0, 1.0], values },
    }
}

fn clip(name: &str, channels: Vec<Channel>) -> Clip {
    Clip { name: name.to_owned(), channels }
}

fn along(node: u32, to: Vec3) -> Channel {
    track(node, Values::Translation(vec![Vec3::ZERO, to]))
}

fn unit_box(scale: f32) -> Aabb {
    Aabb { min: Vec3::splat(-scale), max: Vec3::splat(scale) }
}

fn rigid(node: u32, placed: PlacedNode) -> NodeAttachment {
    NodeAttachment {
        node: RigNodeId(node),
        placed,
        local: Affine3A::from_translation(Vec3::Y),
        skinned_mesh: None,
        seen_at_rest: Aabb::EMPTY,
        reach: Aabb::EMPTY,
    }
}

/// Returns a pivot (0) with an arm (1) that has a camera (2), a joint (3) with a joint below it
/// (4), a morphed face (5), and a part that never moves (6).
fn imported() -> GltfScene {
    let nodes = vec![
        node("pivot", None, Vec3::ZERO, &[]),
        node("arm", Some(0), Vec3::X, &[]),
        node("camera", Some(1), Vec3::Z, &[]),
        node("hip", None, Vec3::ZERO, &[]),
        node("knee", Some(3), Vec3::NEG_Y, &[]),
        node("face", None, Vec3::ZERO, &[0.0]),
        node("stone", None, Vec3::ZERO, &[]),
    ];
    let mesh = Mesh::of_triangles("triangle", &[([0.0; 3], [1.0; 3]); 3]);
    let mut scene = Scene::single(mesh.clone());
    scene.meshes = vec![mesh; 3];
    let object = |mesh| Object { mesh: MeshId(mesh), transform: Affine3A::IDENTITY, tint: 0 };
    scene.objects = [0, 1, 2, 0].map(object).to_vec();
    let look = SurfaceMesh { vertices: Vec::new(), material: scene::MaterialId(0) };
    let weights = SkinWeights {
        joint_count: 2,
        joints: vec![[0, 1, 0, 0]; 3],
        weights: vec![[0.5, 0.5, 0.0, 0.0]; 3],
        sets: 1,
    };
    let target = MorphTarget { positions: vec![[0.0, 1.0, 0.0]; 3], ..Default::default() };
    let lamp = PunctualLight {
        kind: LightKind::Point,
        colour: [1.0; 3],
        intensity: 7.0,
        range_m: None,
        position: Vec3::ZERO,
        direction: Vec3::NEG_Z,
        cookie: None,
    };
    scene.surfaces = Some(Surfaces {
        meshes: vec![look; 3],
        skinned_meshes: vec![
            SkinnedMesh { mesh: MeshId(1), skin: Some(weights), targets: Vec::new() },
            SkinnedMesh { mesh: MeshId(2), skin: None, targets: vec![target] },
        ],
        lights: vec![lamp],
        transparent: vec![object(0)],
        ..Surfaces::default()
    });
    let formed = |node, object, skinned_mesh, skin| NodeAttachment {
        local: Affine3A::IDENTITY,
        skinned_mesh: Some((SkinnedMeshId(skinned_mesh), skin)),
        seen_at_rest: unit_box(1.0),
        reach: unit_box(3.0),
        ..rigid(node, PlacedNode::Object(ObjectId(object)))
    };
    let clips = vec![
        clip("swing", vec![along(0, Vec3::X * 4.0)]),
        clip("walk", vec![along(3, Vec3::Z * 4.0), along(4, Vec3::Z)]),
        clip("smile", vec![track(5, Values::Weights(vec![0.0, 1.0]))]),
        clip("camera", vec![along(2, Vec3::Z)]),
        clip("kick", vec![along(4, Vec3::X)]),
    ];
    GltfScene {
        scene,
        origin_m: glam::DVec3::ZERO,
        rig: Rig::new(nodes).unwrap(),
        object_nodes: Vec::new(),
        clips,
        skins: vec![Skin {
            joints: vec![RigNodeId(3), RigNodeId(4)],
            inverse_bind: vec![Affine3A::IDENTITY; 2],
        }],
        placements: vec![
            rigid(1, PlacedNode::Object(ObjectId(0))),
            formed(6, 1, 0, Some(0)),
            formed(5, 2, 1, None),
            rigid(6, PlacedNode::Object(ObjectId(3))),
            rigid(1, PlacedNode::Light(LightId(0))),
            rigid(0, PlacedNode::Transparent(TransparentId(0))),
        ],
        cameras: vec![SceneCamera {
            name: "camera".to_owned(),
            node: RigNodeId(2),
            projection: cull::Projection::perspective(1.0),
            aspect_ratio: None,
            near_m: 0.1,
        }],
        notes: vec![crate::Note::new("scene", "a note")],
    }
}

fn animator() -> SceneAnimator {
    let (_, animator, cameras, notes) = SceneAnimator::of(imported());
    assert_eq!((cameras.len(), notes.len()), (1, 1));
    animator
}

/// Returns the object of a change, and its new transform.
fn parts(change: &ObjectChange) -> (ObjectId, Affine3A) {
    match *change {
        ObjectChange::Move { object, transform } => (object, transform),
        other => panic!("files bring and take no objects: {other:?}"),
    }
}

/// Returns the objects that change at a time.
fn moved(animator: &mut SceneAnimator, seconds: f64) -> Vec<u32> {
    animator.changes(seconds).objects.iter().map(|moved| parts(moved).0.0).collect()
}

#[test]
fn at_first_only_what_has_no_form_yet_gets_one() {
    let mut animator = animator();
    let changes = animator.changes(0.0).clone();
    let skinned_meshes: Vec<u32> = changes.poses.iter().map(|pose| pose.skinned_mesh.0).collect();
    assert_eq!(skinned_meshes, [0, 1]);
    assert_eq!((changes.joints.len(), changes.weights.as_slice()), (2, &[0.0][..]));
    assert!(changes.objects.is_empty(), "they are where the scene has them");
    assert!(changes.lights.is_empty() && changes.transparent.is_empty());
    assert!(animator.changes(0.5).is_empty(), "nothing plays");
    assert_eq!(animator.moving_objects(), 0);
}

#[test]
fn what_hangs_on_a_node_goes_where_it_goes() {
    let mut animator = animator();
    animator.play(&[0], 0.0, 0.0);
    animator.changes(0.0);
    assert_eq!(animator.moving_objects(), 1);
    let changes = animator.changes(0.5).clone();
    let at = Vec3::new(3.0, 1.0, 0.0);
    let [moved] = changes.objects.as_slice() else { panic!("{changes:?}") };
    let (object, transform) = parts(moved);
    assert_eq!(object, ObjectId(0));
    assert_eq!(Vec3::from(transform.translation), at);
    let [light] = changes.lights.as_slice() else { panic!("{changes:?}") };
    assert_eq!((light.to.position, light.to.intensity), (at, 7.0));
    let [transparent] = changes.transparent.as_slice() else { panic!("{changes:?}") };
    assert_eq!(transparent.transform.translation.x, 2.0);
    assert!(changes.poses.is_empty());
    assert!(animator.changes(0.5).is_empty(), "it is there already");
    let (_, _, cameras, _) = SceneAnimator::of(imported());
    assert_eq!(animator.seen_by(&cameras[0], [3, 2]).eye, Vec3::new(3.0, 0.0, 1.0));
}

#[test]
fn any_moment_can_follow_any_other() {
    let mut there = animator();
    there.play(&[0, 1, 2, 3], 0.0, 0.0);
    let state = |animator: &SceneAnimator| {
        (0..6).map(|part| animator.parts.shown(part)).collect::<Vec<_>>()
    };
    for seconds in [0.0, 0.25, 0.9, 0.1, 7.3, 0.25] {
        there.changes(seconds);
        let mut fresh = animator();
        fresh.play(&[0, 1, 2, 3], 0.0, 0.0);
        fresh.changes(seconds);
        assert!(state(&there) == state(&fresh), "{seconds}");
    }
}

#[test]
fn the_way_of_a_topmost_joint_is_in_the_transform_and_its_form_below_it() {
    let mut animator = animator();
    animator.changes(0.0);
    animator.play(&[1], 0.0, 0.0);
    let changes = animator.changes(0.5).clone();
    let [moved] = changes.objects.as_slice() else { panic!("{changes:?}") };
    assert_eq!(parts(moved).1.translation.z, 2.0);
    assert_eq!(changes.joints[0], Affine3A::IDENTITY);
    assert_eq!(changes.joints[1].translation.z, 0.5);
}

/// Returns the view along x from x = `eye`.
fn view_from(eye: f32) -> CullView {
    let camera = cull::Camera {
        eye: Vec3::X * eye,
        forward: Vec3::X,
        up: Vec3::Y,
        projection: cull::Projection::perspective(1.0),
        near: 0.1,
    };
    CullView::new(&camera, [4, 3], 8)
}

#[test]
fn who_is_in_no_view_goes_on_and_takes_no_pose_until_it_is() {
    let away = [view_from(9.0)];
    let there = [view_from(9.0), view_from(-9.0)];
    let mut animator = animator();
    animator.play(&[1, 2], 0.0, 0.0);
    let posed = |changes: &SceneUpdate| {
        changes.poses.iter().map(|pose| pose.skinned_mesh.0).collect::<Vec<_>>()
    };
    assert_eq!(posed(animator.changes_in(0.0, &away)), [0, 1], "what had no pose gets one");
    assert!(posed(animator.changes_in(0.25, &[])).is_empty(), "nobody looks");
    let unseen = animator.changes_in(0.5, &away).clone();
    assert!(posed(&unseen).is_empty() && unseen.joints.is_empty(), "{unseen:?}");
    assert_eq!(parts(&unseen.objects[0]).1.translation.z, 2.0, "it goes where it goes");
    let seen = animator.changes_in(0.5, &there).clone();
    assert_eq!((posed(&seen), seen.objects.len()), (vec![0, 1], 0));
    assert_eq!((seen.joints[1].translation.z, seen.weights[0]), (0.5, 0.5));
    assert!(posed(animator.changes_in(0.5, &there)).is_empty(), "it has that pose");
}

#[test]
fn who_comes_to_rest_unseen_is_at_rest_when_it_is_seen() {
    let away = [view_from(9.0)];
    let there = [view_from(-9.0)];
    let mut animator = animator();
    animator.play(&[1, 2], 0.0, 0.0);
    animator.changes_in(0.5, &there);
    animator.play(&[], 0.5, 0.0);
    assert!(animator.changes_in(0.6, &away).poses.is_empty());
    assert_eq!((animator.moving_objects(), animator.moving.len()), (0, 0), "nothing plays");
    animator.changes_in(0.7, &away);
    let seen = animator.changes_in(0.8, &there);
    assert_eq!((seen.poses.len(), seen.weights[0]), (2, 0.0), "{seen:?}");
    assert_eq!(seen.joints[1].translation, Vec3A::NEG_Y);
    assert!(animator.changes(0.9).is_empty());
}

#[test]
fn clips_fade_into_each_other_and_the_old_one_comes_to_rest() {
    let mut animator = animator();
    animator.play(&[1], 0.0, 0.0);
    animator.changes(0.5);
    animator.play(&[4], 0.5, 0.4);
    animator.changes(0.7);
    let half = animator.parts.shown(1).0.translation.z;
    assert!((half - 0.5 * 4.0 * 0.7).abs() < 1e-4, "{half}");
    assert_eq!(moved(&mut animator, 0.95), [1]);
    assert_eq!(animator.parts.shown(1).0.translation.z, 0.0);
    assert_eq!(animator.moving, [RigNodeId(4)], "who is at rest is not looked at");
}

#[test]
fn a_fade_into_a_fade_goes_on_where_that_was() {
    let mut animator = animator();
    animator.play(&[1], 0.0, 0.0);
    animator.changes(0.5);
    animator.play(&[4], 0.5, 0.4);
    let place = |animator: &mut SceneAnimator, seconds| {
        animator.changes(seconds);
        let (transform, joints, _) = animator.parts.shown(1);
        (transform.translation, joints[1].translation)
    };
    let before = place(&mut animator, 0.7);
    assert!(before.0.z > 0.5 && before.1.x > 0.1, "amid of both: {before:?}");
    animator.play(&[0], 0.7, 0.2);
    let after = place(&mut animator, 0.7);
    assert!((before.0 - after.0).length() < 1e-5 && (before.1 - after.1).length() < 1e-5);
    let half = place(&mut animator, 0.8);
    assert!((half.0 - before.0 * 0.5).length() < 1e-5, "{half:?} of {before:?}");
    // A further change, to no clips.
    animator.play(&[], 0.8, 0.2);
    assert!((place(&mut animator, 0.8).0 - half.0).length() < 1e-5);
    assert_eq!(place(&mut animator, 1.1).0.length(), 0.0);
    assert!(animator.moving.is_empty());
}

#[test]
fn what_hangs_on_the_same_joints_is_looked_at_once() {
    let mut imported = imported();
    let skinned = imported.placements[1].clone();
    let surfaces = imported.scene.surfaces.as_mut().unwrap();
    for object in 4..104 {
        let skinned_mesh = SkinnedMeshId(surfaces.skinned_meshes.len() as u32);
        surfaces.skinned_meshes.push(surfaces.skinned_meshes[0].clone());
        imported.placements.push(NodeAttachment {
            placed: PlacedNode::Object(ObjectId(object)),
            skinned_mesh: Some((skinned_mesh, Some(0))),
            ..skinned.clone()
        });
    }
    let (_, mut animator, _, _) = SceneAnimator::of(imported);
    assert_eq!(animator.parts.skeletons(), 1);
    animator.play(&[1], 0.0, 0.0);
    let changes = animator.changes(0.5);
    assert_eq!((changes.poses.len(), changes.joints.len()), (102, 2), "{changes:?}");
    let shared = changes.poses.iter().filter(|pose| pose.joints == (0..2));
    assert_eq!(shared.count(), 101, "all but the face");
    assert!(animator.changes(0.5).is_empty());
}

#[test]
fn clips_that_move_the_same_do_not_play_together() {
    let animator = animator();
    assert_eq!(animator.compatible(None), [0, 1, 2, 3]);
    assert_eq!(animator.compatible(Some(4)), [0, 2, 3, 4]);
    assert_eq!(animator.compatible(Some(99)), [0, 1, 2, 3]);
}

#[test]
fn the_clip_of_a_camera_is_the_one_with_its_name() {
    let (_, animator, cameras, _) = SceneAnimator::of(imported());
    assert_eq!(animator.clip_of(&cameras[0]), Some(3));
    let other = SceneCamera { name: "other".to_owned(), ..cameras[0].clone() };
    assert_eq!(animator.clip_of(&other), Some(0), "the first that moves it, by its ancestors too");
    let still = SceneCamera { node: RigNodeId(6), ..other };
    assert_eq!(animator.clip_of(&still), None);
    assert_eq!((animator.duration_s(0), animator.duration_s(9)), (Some(1.0), None));
}

#[test]
fn squashed_and_turned_nodes_still_see() {
    let (_, mut animator, cameras, _) = SceneAnimator::of(imported());
    for matrix in [
        Affine3A::from_scale(Vec3::ZERO),
        Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0)),
        Affine3A::from_scale(Vec3::new(-2.0, 3.0, -0.5)),
        Affine3A::from_rotation_x(1.0),
    ] {
        animator.world[2] = matrix;
        let camera = animator.seen_by(&cameras[0], [3, 2]);
        assert!((camera.forward.length() - 1.0).abs() < 1e-5 && camera.up.is_normalized());
        assert!(camera.forward.dot(camera.up).abs() < 1e-5);
    }
}

#[test]
fn the_room_of_a_scene_is_that_of_its_clips_and_looking_at_it_leaves_no_trace() {
    let (scene, mut animator, ..) = SceneAnimator::of(imported());
    let at_rest = animator.bounds_playing(&scene);
    assert!(at_rest.max.x < 4.0, "{at_rest:?}");
    animator.play(&[0], 0.0, 0.0);
    let playing = animator.bounds_playing(&scene);
    assert!(playing.max.x > 4.5, "the arm swings that far: {playing:?}");
    let mut other = SceneAnimator::of(imported()).1;
    other.play(&[0], 0.0, 0.0);
    assert_eq!(animator.changes(0.25), other.changes(0.25));
}
