//! Tests that no vertex is outside of the box of its pose: for rigs, clips and meshes of all kinds,
//! sampled densely, alone, mixed and faded, and for poses that no clip produces.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod any_pose;
mod fox;
mod rigs;

use animation::{
    Clip, ClipId, Extents, Playback, Player, Pose, RigNodeId, Skeleton, WeightRanges, Workspace,
};
use cull::Aabb;
use glam::{Affine3A, Vec3};
use proptest::prelude::*;
use scene::PoseBounds;

use rigs::{Animated, animated};

/// A mesh that is posed and checked against its box.
struct Mover<'a> {
    animated: &'a Animated,
    skeleton: Option<Skeleton>,
    bounds: PoseBounds,
    /// The box that it never leaves in any mix of these clips.
    reach: Aabb,
    matrices: Vec<Affine3A>,
}

impl<'a> Mover<'a> {
    fn new(animated: &'a Animated, is_skinned: bool, clips: &[&Clip]) -> Self {
        let skeleton = is_skinned.then(|| animated.skeleton());
        let bounds = animated.bounds(is_skinned);
        let weights = WeightRanges::new(&animated.rig, clips.iter().copied());
        let weights = weights.of(&animated.rig, RigNodeId(0));
        let parts: Vec<_> = bounds.parts(&weights).collect();
        let reach = match &skeleton {
            Some(skeleton) => {
                let boxes = parts.into_iter().filter_map(|(joint, part)| Some((joint?, part)));
                Extents::new(&animated.rig, clips.iter().copied()).reach(skeleton, boxes)
            }
            None => parts[0].1.enlarged(1e-4),
        };
        Self { animated, skeleton, bounds, reach, matrices: Vec::new() }
    }

    /// Returns a vertex that is outside of the box of its pose or of its reach.
    fn outside(&mut self, pose: &Pose) -> Option<(Vec3, Aabb)> {
        let matrices = self.skeleton.as_ref().map(|skeleton| {
            skeleton.joint_matrices(&self.animated.rig, pose, &mut self.matrices);
            self.matrices.as_slice()
        });
        let weights = pose.weights(RigNodeId(0));
        let bounds = self.bounds.bounds(matrices.unwrap_or_default(), weights).unwrap();
        let vertices = self.animated.vertices(matrices, pose);
        let holds = |at: &Vec3| bounds.contains_point(*at) && self.reach.contains_point(*at);
        Some((vertices.into_iter().find(|at| !holds(at))?, bounds))
    }
}

/// Returns times from the beginning to the end of a clip, including both.
fn times_s(clip: &Clip, steps: usize) -> impl Iterator<Item = f32> + use<> {
    let duration_s = clip.duration_s();
    (0..=steps).map(move |step| duration_s * (step as f32 / steps as f32))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn no_vertex_leaves_the_box_of_a_clip(animated in animated(), is_skinned: bool) {
        let mut pose = Pose::new(&animated.rig);
        let mut mover = Mover::new(&animated, is_skinned, &[]);
        prop_assert_eq!(mover.outside(&pose), None);
        for clip in &animated.clips {
            let mut mover = Mover::new(&animated, is_skinned, &[clip]);
            let keys_s = clip.channels.iter().flat_map(|channel| &channel.track.times_s).copied();
            for time_s in times_s(clip, 400).chain(keys_s) {
                pose.reset(&animated.rig);
                pose.sample(clip, time_s);
                prop_assert_eq!(mover.outside(&pose), None, "at {}", time_s);
            }
        }
    }

    #[test]
    fn no_vertex_leaves_the_box_of_a_blend(animated in animated(), is_skinned: bool) {
        let rest = Clip { name: String::new(), channels: Vec::new() };
        let a = &animated.clips[0];
let b = animated.clips.get(1).unwrap_or(&rest);
        let mut mover = Mover::new(&animated, is_skinned, &[a, b]);
        let mut pose = Pose::new(&animated.rig);
let mut other = Pose::new(&animated.rig);
        for a_s in times_s(a, 12) {
            for b_s in times_s(b, 12) {
                for weight in 0..=8 {
                    pose.reset(&animated.rig);
                    other.reset(&animated.rig);
                    pose.sample(a, a_s);
                    other.sample(b, b_s);
                    pose.blend(&other, weight as f32 / 8.0);
                    prop_assert_eq!(mover.outside(&pose), None);
                }
            }
        }
    }

    /// Checks everything that a player can do with its clips: fades during fades, layers over
    /// layers.
    #[test]
    fn no_vertex_leaves_the_box_of_a_player(
        animated in animated(),
        plays in prop::collection::vec((0_u32..4, 0.0_f64..3.0, -1.0_f32..2.0, any::<bool>()), 1..5)
    ) {
        let clips: Vec<&Clip> = animated.clips.iter().collect();
        let mut mover = Mover::new(&animated, true, &clips);
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
        let mut workspace = Workspace::new(&animated.rig);
let mut pose = Pose::new(&animated.rig);
        for step in 0..200 {
            let now_s = f64::from(step) * 0.03;
            player.pose_at(&animated.rig, &animated.clips, now_s, &mut workspace, &mut pose);
            prop_assert_eq!(mover.outside(&pose), None);
        }
    }

    /// Checks that the matrices are those of the specification, relative to the object's node.
    #[test]
    fn joints_are_where_the_world_has_them(animated in animated(), time_s in 0.0_f32..3.0) {
        let rig = &animated.rig;
let skeleton = animated.skeleton();
        let mut pose = Pose::new(rig);
let mut world = Vec::new();
let mut matrices = Vec::new();
        pose.sample(&animated.clips[0], time_s);
        rig.world(&pose, &mut world);
        skeleton.joint_matrices(rig, &pose, &mut matrices);
        let at = |node: RigNodeId| world[node.0 as usize];
        let object = skeleton.space().map_or(Affine3A::IDENTITY, at);
        let joints = animated.skin.joints.iter().zip(&animated.skin.inverse_bind);
        for ((joint, bind), matrix) in joints.zip(&matrices) {
            let found = object * *matrix;
let expected = at(*joint) * *bind;
            prop_assert!(matrix.is_finite());
            prop_assert!(found.abs_diff_eq(expected, 1e-3), "{:?} for {:?}", found, expected);
        }
    }

    /// Checks that all moving nodes are listed, and that updating only these equals updating all
    /// nodes.
    #[test]
    fn only_what_moves_needs_to_be_updated(
        animated in animated(), times_s in prop::collection::vec(0.0_f32..3.0, 1..4)
    ) {
        let rig = &animated.rig;
        let moved = rig.moved_by(&animated.clips);
        let mut pose = Pose::new(rig);
let mut world = Vec::new();
let mut all = Vec::new();
        rig.world(&pose, &mut world);
        for time_s in times_s {
            pose.reset(rig);
            for clip in &animated.clips {
                pose.sample(clip, time_s);
            }
            rig.update_world(&moved, &pose, &mut world);
            rig.world(&pose, &mut all);
            prop_assert_eq!(&world, &all);
        }
    }
}
