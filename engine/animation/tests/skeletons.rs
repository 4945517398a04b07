//! Tests of the spaces and reach of skinned objects, with a rig made by hand: two legs of three
//! bones that walk and run.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use antumbra_animation::{
    Channel, Clip, Extents, Interpolation, Pose, Rest, Rig, RigNode, RigNodeId, Skeleton, Skin,
    SkinError, Track, Trs, Values, WeightRanges,
};
use cull::Aabb;
use glam::{Affine3A, Quat, Vec3};

/// Returns a root that walks away, with hips below it and two legs of thighs, shins and feet.
fn rig() -> Rig {
    let node = |parent: Option<u32>, translation| RigNode {
        name: String::new(),
        parent: parent.map(RigNodeId),
        rest: Rest::Parts(Trs { translation, ..Trs::IDENTITY }),
        weights: Vec::new(),
    };
    let mut nodes = vec![node(None, Vec3::ZERO), node(Some(0), Vec3::Y)];
    for side in [-0.2, 0.2] {
        nodes.push(node(Some(1), Vec3::X * side));
        for _ in 0..2 {
            nodes.push(node(Some(nodes.len() as u32 - 1), Vec3::NEG_Y * 0.5));
        }
    }
    Rig::new(nodes).unwrap()
}

const JOINTS: [u32; 7] = [1, 2, 3, 4, 5, 6, 7];

fn skin(rig: &Rig) -> Skin {
    let mut world = Vec::new();
    rig.world(&Pose::new(rig), &mut world);
    let bind = |node: u32| world[node as usize].inverse();
    Skin { joints: JOINTS.map(RigNodeId).to_vec(), inverse_bind: JOINTS.map(bind).to_vec() }
}

/// Returns a clip in which the legs swing by one angle and the knees bend by another, while the
/// root walks far away.
fn gait(rig: &Rig, duration_s: f32, swing: f32, bend: f32) -> Clip {
    let times_s: Vec<f32> = (0..=8).map(|key| duration_s * key as f32 / 8.0).collect();
    let turn = |phase: f32, size: f32, middle: f32| {
        let angle =
            |key: i32| middle + size * (phase + key as f32 / 8.0 * std::f32::consts::TAU).sin();
        Values::Rotation((0..=8).map(|key| Quat::from_rotation_x(angle(key))).collect())
    };
    let away = Values::Translation((0..=8).map(|key| Vec3::Z * key as f32 * 20.0).collect());
    let mut moves = vec![(0, away)];
    for (thigh, phase) in [(2, 0.0), (5, std::f32::consts::PI)] {
        moves.push((thigh, turn(phase, swing, 0.0)));
        moves.push((thigh + 1, turn(phase + 1.0, bend, bend)));
        moves.push((thigh + 2, turn(phase + 2.0, bend * 0.5, 0.0)));
    }
    let channels = moves.into_iter().map(|(node, values)| Channel {
        node: RigNodeId(node),
        track: Track { interpolation: Interpolation::Linear, times_s: times_s.clone(), values },
    });
    Clip::new("gait".into(), channels.collect(), rig).unwrap()
}

#[test]
fn objects_hang_on_the_deepest_node_that_moves_all_joints() {
    let rig = rig();
    let skin = skin(&rig);
    let space =
        |used: &[bool]| Skeleton::new(&rig, &skin, used).unwrap().space().map(|node| node.0);
    assert_eq!(space(&[]), Some(1));
    assert_eq!(space(&[false, false, true, true, false, false, false]), Some(3));
    assert_eq!(space(&[false, false, false, true, true, false, false]), Some(1));
    assert_eq!(space(&[false, false, false, false, true, false, false]), Some(5));
    assert_eq!(space(&[false; 7]), None);

    let clip = gait(&rig, 1.0, 0.5, 0.3);
    let walks = |used: &[bool]| Skeleton::new(&rig, &skin, used).unwrap().is_moved_by(&clip);
    assert!(walks(&[]));
    // Hips alone are rigid: they only change the object's transform.
    assert!(!walks(&[true, false, false, false, false, false, false]));
}

#[test]
fn roots_without_an_ancestor_in_common_hang_on_the_world() {
    let node = |x| RigNode {
        name: String::new(),
        parent: None,
        rest: Rest::Parts(Trs { translation: Vec3::X * x, ..Trs::IDENTITY }),
        weights: Vec::new(),
    };
    let rig = Rig::new(vec![node(1.0), node(2.0)]).unwrap();
    let skin = Skin {
        joints: vec![RigNodeId(0), RigNodeId(1)],
        inverse_bind: vec![Affine3A::IDENTITY; 2],
    };
    let skeleton = Skeleton::new(&rig, &skin, &[]).unwrap();
    assert_eq!(skeleton.space(), None);
    let mut matrices = Vec::new();
    skeleton.joint_matrices(&rig, &Pose::new(&rig), &mut matrices);
    assert_eq!(matrices, [1.0, 2.0].map(|x| Affine3A::from_translation(Vec3::X * x)));
}

#[test]
fn what_is_no_skin_is_refused_with_the_reason() {
    let rig = rig();
    let of = |joints: Vec<u32>, inverse_bind| {
        let joints = joints.into_iter().map(RigNodeId).collect();
        Skeleton::new(&rig, &Skin { joints, inverse_bind }, &[]).map(|_| ()).unwrap_err()
    };
    let still = Affine3A::IDENTITY;
    assert_eq!(of(vec![], vec![]), SkinError::Empty);
    assert_eq!(of(vec![1], vec![]), SkinError::Count { joints: 1, matrices: 0 });
    assert_eq!(of(vec![1, 99], vec![still; 2]), SkinError::NoNode { joint: 1, node: 99 });
    let wild = Affine3A::from_translation(Vec3::splat(f32::NAN));
    assert_eq!(of(vec![1], vec![wild]), SkinError::NotFinite { joint: 0 });
}

#[test]
fn what_hangs_on_legs_reaches_as_far_as_they_are_long() {
    let rig = rig();
    let skeleton = Skeleton::new(&rig, &skin(&rig), &[]).unwrap();
    // A box around the sole of the left foot, which is joint 3, and a box around the hips.
    let around = |at: Vec3| Aabb::new(at - 0.1, at + 0.1);
    let boxes = [(3, around(Vec3::new(-0.2, 0.0, 0.0))), (0, around(Vec3::Y)), (99, Aabb::EMPTY)];
    let reach = |clips: &[Clip]| Extents::new(&rig, clips).reach(&skeleton, boxes).max;
    let still = reach(&[]);
    let expected = 0.2 + 0.5 + 0.5 + 0.03_f32.sqrt();
    assert!((still - expected).abs().max_element() < 0.02, "{still} for {expected}");
    assert_eq!(reach(&[gait(&rig, 1.0, 2.0, 0.3)]), still, "turning and running makes none longer");
    let grows = |node, values| {
        let track = Track { interpolation: Interpolation::Linear, times_s: vec![0.0, 1.0], values };
        Clip::new("it".into(), vec![Channel { node: RigNodeId(node), track }], &rig).unwrap()
    };
    let stretched = grows(3, Values::Scale(vec![Vec3::ONE, Vec3::new(1.0, -3.0, 1.0)]));
    let longer = reach(std::slice::from_ref(&stretched)).x - still.x;
    assert!((longer - 2.0 * (0.5 + 0.03_f32.sqrt())).abs() < 0.02, "{longer} more");
    let torn = grows(4, Values::Translation(vec![Vec3::ZERO, Vec3::X * 7.0]));
    assert!((reach(&[torn]).x - still.x - 6.5).abs() < 0.02);
}

/// Checks that a chain of 60,000 bones is bounded in reasonable time, and that overflowing numbers
/// give no usable box. Neither may panic.
#[test]
fn deep_and_wild_rigs_end() {
    let reach = |count: u32, scale: f32| {
        let node = |id: u32| RigNode {
            name: String::new(),
            parent: id.checked_sub(1).map(RigNodeId),
            rest: Rest::Parts(Trs {
                translation: Vec3::X,
                scale: Vec3::splat(scale),
                ..Trs::IDENTITY
            }),
            weights: Vec::new(),
        };
        let rig = Rig::new((0..count).map(node).collect()).unwrap();
        let skin = Skin {
            joints: (0..count).map(RigNodeId).collect(),
            inverse_bind: vec![Affine3A::IDENTITY; count as usize],
        };
        let skeleton = Skeleton::new(&rig, &skin, &[]).unwrap();
        let mut matrices = Vec::new();
        skeleton.joint_matrices(&rig, &Pose::new(&rig), &mut matrices);
        assert!(matrices.iter().all(Affine3A::is_finite));
        let boxes = (0..count as u16).map(|joint| (joint, Aabb::new(Vec3::Y, Vec3::Y)));
        Extents::new(&rig, []).reach(&skeleton, boxes)
    };
    let deep = reach(60_000, 1.0);
    assert!(deep.is_usable() && deep.max.x >= 59_999.0 && deep.max.x < 61_000.0, "{deep:?}");
    assert!(!reach(300, 10.0).is_usable());
}

#[test]
fn weights_are_between_the_least_and_the_largest_of_all_clips_and_the_rest() {
    let node = |weights: &[f32]| RigNode {
        name: String::new(),
        parent: None,
        rest: Rest::Parts(Trs::IDENTITY),
        weights: weights.to_vec(),
    };
    let rig = Rig::new(vec![node(&[0.5, -0.5]), node(&[0.25])]).unwrap();
    let clip = |interpolation, values: &[f32]| {
        let values = Values::Weights(values.to_vec());
        let track = Track { interpolation, times_s: vec![0.0, 1.0], values };
        Clip::new("it".into(), vec![Channel { node: RigNodeId(0), track }], &rig).unwrap()
    };
    let linear = clip(Interpolation::Linear, &[0.0, 0.0, 1.0, -2.0]);
    // Its slope at 0 is 3 per second, so it may reach 1 before it is at 0 again.
    let cubic =
        clip(Interpolation::Cubic, &[0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let of =
        |clips: &[Clip], node| WeightRanges::new(&rig, clips).of(&rig, RigNodeId(node)).to_vec();
    assert_eq!(of(&[], 0), [[0.5, 0.5], [-0.5, -0.5]]);
    assert_eq!(of(std::slice::from_ref(&linear), 0), [[0.0, 1.0], [-2.0, 0.0]]);
    assert_eq!(of(std::slice::from_ref(&cubic), 0), [[0.0, 1.0], [-0.5, 0.0]]);
    assert_eq!(of(&[linear, cubic], 1), [[0.25, 0.25]]);
}

#[test]
fn what_hangs_on_a_moved_node_moves_with_it() {
    let rig = rig();
    let values = Values::Translation(vec![Vec3::X; 2]);
    let track = Track { interpolation: Interpolation::Linear, times_s: vec![0.0, 1.0], values };
    let channel = Channel { node: RigNodeId(2), track };
    let clip = Clip::new("kick".into(), vec![channel], &rig).unwrap();
    assert_eq!(rig.moved_by([&clip]), [2, 3, 4].map(RigNodeId));
}
