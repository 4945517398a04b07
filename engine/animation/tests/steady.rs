//! Tests that a frame does not allocate, and that its work is proportional to the number of moving
//! nodes: two doors in a scene of 34,000 nodes.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use allocation_counter::measure;
use antumbra_animation::{
    Channel, Clip, ClipId, Interpolation, Playback, Player, Pose, Rest, Rig, RigNode, RigNodeId,
    Skeleton, Skin, Track, Trs, Values, Workspace,
};
use glam::{Affine3A, Quat, Vec3};

const NODES: u32 = 34_000;

/// Returns a rig in which each tenth node has no parent, and the parent of every other node is the
/// previous node.
fn rig() -> Rig {
    let node = |id: u32| RigNode {
        name: String::new(),
        parent: id.checked_sub(1).filter(|_| !id.is_multiple_of(10)).map(RigNodeId),
        rest: Rest::Parts(Trs { translation: Vec3::X, ..Trs::IDENTITY }),
        weights: vec![0.0; 2],
    };
    Rig::new((0..NODES).map(node).collect()).unwrap()
}

fn turns(node: u32, rig: &Rig) -> Clip {
    let turns = [0.0, 1.0, 2.0].map(Quat::from_rotation_y).to_vec();
    let interpolation = Interpolation::Linear;
    let times_s = vec![0.0, 1.0, 2.0];
    let turn = Track { interpolation, times_s: times_s.clone(), values: Values::Rotation(turns) };
    let weights = Track { interpolation, times_s, values: Values::Weights(vec![0.5; 6]) };
    let channel = |track| Channel { node: RigNodeId(node), track };
    Clip::new("turns".into(), vec![channel(turn), channel(weights)], rig).unwrap()
}

#[test]
fn frames_allocate_nothing_and_touch_what_moves() {
    let rig = rig();
    let clips = [turns(5005, &rig), turns(20_008, &rig)];
    let skin = Skin {
        joints: vec![RigNodeId(5005), RigNodeId(5009)],
        inverse_bind: vec![Affine3A::IDENTITY; 2],
    };
    let skeleton = Skeleton::new(&rig, &skin, &[]).unwrap();
    let moved = rig.moved_by(&clips);
    let mut sorted = moved.clone();
    sorted.sort();
    assert_eq!(sorted, [5005, 5006, 5007, 5008, 5009, 20_008, 20_009].map(RigNodeId));

    let mut player = Player::new();
    player.play(Playback::looped(ClipId(0), 0.0));
    let layer = player.play(Playback::looped(ClipId(1), 0.0));
    player.cross_fade(layer, Playback::looped(ClipId(0), 1.0), 1.0, 1.0);
    let mut workspace = Workspace::new(&rig);
    let mut pose = Pose::new(&rig);
    let mut world = Vec::new();
    let mut matrices = Vec::new();
    rig.world(&pose, &mut world);
    let mut frame = |now_s: f64| {
        player.pose_at(&rig, &clips, now_s, &mut workspace, &mut pose);
        rig.update_world(&moved, &pose, &mut world);
        skeleton.joint_matrices(&rig, &pose, &mut matrices);
        (pose.moved().len(), player.playing(now_s).count())
    };
    // Each clip has played once.
    let warm = [frame(0.5), frame(1.5), frame(3.0)];
    assert_eq!(warm, [(2, 2), (2, 3), (1, 2)]);
    let allocated = measure(|| {
        for number in 0..1000 {
            frame(f64::from(number) * 0.01);
        }
    });
    assert_eq!(allocated.count_total, 0);
}
