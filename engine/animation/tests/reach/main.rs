//! Boxes hold: for scenes of all kinds, sampled densely, nothing is outside.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use antumbra_animation::{
    Clip, ClipId, DeformedMesh, Excerpt, Extents, NodeId, Playback, Player, Pose, Reach,
    ReachError, Rig, Skeleton, Workspace, weight_ranges,
};
use cull::Aabb;
use glam::{Affine3A, Vec3};
use proptest::prelude::*;
use proptest::strategy::ValueTree;

mod scene;

use scene::{Scene, scene};

/// Moves the mesh and tells whether all of it is in the box.
struct Mover<'a> {
    scene: &'a Scene,
    skeleton: Option<&'a Skeleton>,
    matrices: Vec<Affine3A>,
}

impl<'a> Mover<'a> {
    fn new(scene: &'a Scene, skeleton: Option<&'a Skeleton>) -> Self {
        Self { scene, skeleton, matrices: Vec::new() }
    }

    fn outside(&mut self, pose: &Pose, bounds: &Aabb) -> Option<Vec3> {
        let matrices = self.skeleton.map(|skeleton| {
            skeleton.joint_matrices(&self.scene.rig, pose, &mut self.matrices);
            self.matrices.as_slice()
        });
        let vertices = self.scene.vertices(matrices, pose);
        vertices.into_iter().find(|vertex| !bounds.contains_point(*vertex))
    }
}

/// Times from the beginning to the end of a clip, both among them.
fn times_s(clip: &Clip, steps: usize) -> impl Iterator<Item = f32> + use<> {
    let duration_s = clip.duration_s();
    (0..=steps).map(move |step| duration_s * (step as f32 / steps as f32))
}

/// The box that is found without looking at how bones turn.
fn coarse_bounds(scene: &Scene, skeleton: Option<&Skeleton>, clips: &[&Clip]) -> Aabb {
    let targets = scene.targets();
    let mesh = scene.mesh(skeleton, &targets);
    let excerpts: Vec<Excerpt> = clips.iter().map(|clip| Excerpt::from(*clip)).collect();
    let weights = weight_ranges(&scene.rig, mesh.node, &excerpts.iter().collect::<Vec<_>>());
    Extents::new(&scene.rig, clips.iter().copied()).bounds(&mesh, &weights).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn no_vertex_leaves_the_box_of_a_clip(scene in scene(), is_skinned: bool) {
        let skeleton = is_skinned.then(|| scene.skeleton());
        let targets = scene.targets();
        let reach = Reach::new(&scene.rig, scene.mesh(skeleton.as_ref(), &targets)).unwrap();
        let mut mover = Mover::new(&scene, skeleton.as_ref());
        let mut pose = Pose::new(&scene.rig);
        prop_assert_eq!(mover.outside(&pose, &reach.rest_bounds().unwrap()), None);
        for clip in &scene.clips {
            let bounds = reach.clip_bounds(clip).unwrap();
            let keys_s = clip.channels.iter().flat_map(|channel| &channel.track.times_s).copied();
            for time_s in times_s(clip, 400).chain(keys_s) {
                pose.reset(&scene.rig);
                pose.sample(clip, time_s);
                prop_assert_eq!(mover.outside(&pose, &bounds), None, "{:?} at {}", bounds, time_s);
            }
        }
    }

    #[test]
    fn no_vertex_leaves_the_box_of_a_blend(scene in scene(), is_skinned: bool) {
        let skeleton = is_skinned.then(|| scene.skeleton());
        let targets = scene.targets();
        let reach = Reach::new(&scene.rig, scene.mesh(skeleton.as_ref(), &targets)).unwrap();
        let mut mover = Mover::new(&scene, skeleton.as_ref());
        let rest = Clip { name: String::new(), channels: Vec::new() };
        let (a, b) = (&scene.clips[0], scene.clips.get(1).unwrap_or(&rest));
        let bounds = reach.blend_bounds(&[a, b]).unwrap();
        let coarse = coarse_bounds(&scene, skeleton.as_ref(), &[a, b]);
        let (mut pose, mut other) = (Pose::new(&scene.rig), Pose::new(&scene.rig));
        for a_s in times_s(a, 12) {
            for b_s in times_s(b, 12) {
                for weight in 0..=8 {
                    pose.reset(&scene.rig);
                    other.reset(&scene.rig);
                    pose.sample(a, a_s);
                    other.sample(b, b_s);
                    pose.blend(&other, weight as f32 / 8.0);
                    prop_assert_eq!(mover.outside(&pose, &bounds), None, "{:?}", bounds);
                    prop_assert_eq!(mover.outside(&pose, &coarse), None, "{:?}", coarse);
                }
            }
        }
    }

    /// Whatever a player does with its clips: fades into fades, layers over layers.
    #[test]
    fn no_vertex_leaves_the_box_of_a_player(
        scene in scene(),
        plays in prop::collection::vec((0_u32..4, 0.0_f64..3.0, -1.0_f32..2.0, any::<bool>()), 1..5)
    ) {
        let skeleton = scene.skeleton();
        let targets = scene.targets();
        let reach = Reach::new(&scene.rig, scene.mesh(Some(&skeleton), &targets)).unwrap();
        let mut mover = Mover::new(&scene, Some(&skeleton));
        let rest = Clip { name: String::new(), channels: Vec::new() };
        let clips: Vec<&Clip> = scene.clips.iter().chain([&rest]).collect();
        let bounds = reach.blend_bounds(&clips).unwrap();
        let mut player = Player::new();
        let mut layer = player.play(Playback::looped(ClipId(0), 0.0));
        for (clip, start_s, speed, is_fade) in plays {
            let playback = Playback { speed, ..Playback::looped(ClipId(clip), start_s) };
            if is_fade {
                player.cross_fade(layer, playback, start_s, 2.0);
            } else {
                layer = player.play(playback);
            }
        }
        let (mut workspace, mut pose) = (Workspace::new(&scene.rig), Pose::new(&scene.rig));
        for step in 0..200 {
            let now_s = f64::from(step) * 0.03;
            player.pose_at(&scene.rig, &scene.clips, now_s, &mut workspace, &mut pose);
            prop_assert_eq!(mover.outside(&pose, &bounds), None, "{:?}", bounds);
        }
    }

    /// The matrices are those of the specification, seen from the object's node.
    #[test]
    fn joints_are_where_the_world_has_them(scene in scene(), time_s in 0.0_f32..3.0) {
        let skeleton = scene.skeleton();
        let (mut pose, mut world, mut matrices) = (Pose::new(&scene.rig), Vec::new(), Vec::new());
        pose.sample(&scene.clips[0], time_s);
        scene.rig.world(&pose, &mut world);
        skeleton.joint_matrices(&scene.rig, &pose, &mut matrices);
        let at = |node: NodeId| world[node.0 as usize];
        let object = skeleton.space().map_or(Affine3A::IDENTITY, at);
        let joints = scene.skin.joints.iter().zip(&scene.skin.inverse_bind);
        for ((joint, bind), matrix) in joints.zip(&matrices) {
            let (found, expected) = (object * *matrix, at(*joint) * *bind);
            prop_assert!(matrix.is_finite());
            prop_assert!(found.abs_diff_eq(expected, 1e-3), "{:?} for {:?}", found, expected);
        }
    }

    /// What moves is listed, and updating it alone is as good as updating all.
    #[test]
    fn only_what_moves_needs_to_be_updated(scene in scene(), times_s in prop::collection::vec(0.0_f32..3.0, 1..4)) {
        let moved = scene.rig.moved_by(&scene.clips);
        let (mut pose, mut world, mut all) = (Pose::new(&scene.rig), Vec::new(), Vec::new());
        scene.rig.world(&pose, &mut world);
        for time_s in times_s {
            pose.reset(&scene.rig);
            for clip in &scene.clips {
                pose.sample(clip, time_s);
            }
            scene.rig.update_world(&moved, &pose, &mut world);
            scene.rig.world(&pose, &mut all);
            prop_assert_eq!(&world, &all);
        }
    }
}

#[test]
fn what_does_not_fit_is_refused_with_the_reason() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let scene = scene().new_tree(&mut runner).unwrap().current();
    let skeleton = scene.skeleton();
    let mesh = scene.mesh(Some(&skeleton), &[]);
    let binding = mesh.binding.unwrap();
    let vertices = mesh.positions.len();
    let refused = |mesh: DeformedMesh| Reach::new(&scene.rig, mesh).map(|_| ()).unwrap_err();
    let bound = |binding| DeformedMesh { binding: Some(binding), ..mesh };
    assert_eq!(refused(DeformedMesh { positions: &[], ..mesh }), ReachError::Empty);
    let short: [&[[f32; 3]]; 1] = [&vec![[0.0; 3]; vertices + 1]];
    let error = ReachError::Target { target: 0, deltas: vertices + 1, vertices };
    assert_eq!(refused(DeformedMesh { targets: &short, ..mesh }), error);
    let wild = vec![[f32::NAN; 3]; vertices];
    assert_eq!(refused(DeformedMesh { positions: &wild, ..mesh }), ReachError::Unbounded);
    let sets = antumbra_animation::Binding { sets: u32::MAX, ..binding };
    assert!(matches!(refused(bound(sets)), ReachError::Count { .. }));
    let joints = vec![[999; 4]; vertices];
    let nowhere = antumbra_animation::Binding { joints: &joints, ..binding };
    assert_eq!(refused(bound(nowhere)), ReachError::NoJoint { vertex: 0, joint: 999 });
    let weights = vec![[0.5, 0.0, 0.0, 0.0]; vertices];
    let half = antumbra_animation::Binding { weights: &weights, ..binding };
    assert_eq!(refused(bound(half)), ReachError::Weights { vertex: 0 });
}

/// A chain of 60,000 bones is bounded in reasonable time, numbers that overflow have no box, and neither
/// panics.
#[test]
fn deep_and_wild_rigs_end() {
    use antumbra_animation::{Binding, Node, Rest, Skin, Trs};
    let chain = |count: u32, scale: f32| {
        let node = |id: u32| Node {
            name: String::new(),
            parent: id.checked_sub(1).map(NodeId),
            rest: Rest::Parts(Trs {
                translation: Vec3::X,
                scale: Vec3::splat(scale),
                ..Trs::IDENTITY
            }),
            weights: Vec::new(),
        };
        Rig::new((0..count).map(node).collect()).unwrap()
    };
    let bounds = |rig: &Rig| {
        let count = rig.nodes().len();
        let skin = Skin {
            joints: (0..count as u32).map(NodeId).collect(),
            inverse_bind: vec![Affine3A::IDENTITY; count],
        };
        let skeleton = Skeleton::new(rig, &skin, &[]).unwrap();
        let joints: Vec<_> = (0..count as u16).map(|joint| [joint, 0, 0, 0]).collect();
        let weights = vec![[1.0, 0.0, 0.0, 0.0]; count];
        let positions = vec![[0.0, 1.0, 0.0]; count];
        let binding =
            Some(Binding { skeleton: &skeleton, joints: &joints, weights: &weights, sets: 1 });
        let mesh = DeformedMesh { positions: &positions, targets: &[], node: NodeId(0), binding };
        let mut matrices = Vec::new();
        skeleton.joint_matrices(rig, &Pose::new(rig), &mut matrices);
        assert!(matrices.iter().all(Affine3A::is_finite));
        let reach = Reach::new(rig, mesh).unwrap();
        (reach.rest_bounds(), reach.blend_bounds(&[]))
    };
    let (rest, mixed) = bounds(&chain(60_000, 1.0));
    assert!((rest.unwrap().max.x - 59_999.0).abs() < 60.0);
    assert!(mixed.unwrap().max.x >= 59_999.0);
    assert_eq!(bounds(&chain(300, 10.0)), (Err(ReachError::Unbounded), Err(ReachError::Unbounded)));
}
