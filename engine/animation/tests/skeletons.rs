//! Where objects with skins hang, and that their boxes are not much too large, with a rig made by hand: two legs
//! of three bones that walk and run.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use antumbra_animation::{
    Binding, Channel, Clip, DeformedMesh, Interpolation, Node, NodeId, Pose, Reach, Rest, Rig,
    Skeleton, Skin, SkinError, Track, Trs, Values,
};
use cull::Aabb;
use glam::{Affine3A, Quat, Vec3};

/// A root that walks away, below it hips, below them two legs: thighs, shins and feet.
fn rig() -> Rig {
    let node = |parent: Option<u32>, translation| Node {
        name: String::new(),
        parent: parent.map(NodeId),
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
    Skin { joints: JOINTS.map(NodeId).to_vec(), inverse_bind: JOINTS.map(bind).to_vec() }
}

/// Legs that swing by an angle, knees that bend by another, while the root goes far away.
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
        node: NodeId(node),
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
    // Hips alone are rigid: only their place changes, and that is in the transform.
    assert!(!walks(&[true, false, false, false, false, false, false]));
}

#[test]
fn roots_without_an_ancestor_in_common_hang_on_the_world() {
    let node = |x| Node {
        name: String::new(),
        parent: None,
        rest: Rest::Parts(Trs { translation: Vec3::X * x, ..Trs::IDENTITY }),
        weights: Vec::new(),
    };
    let rig = Rig::new(vec![node(1.0), node(2.0)]).unwrap();
    let skin =
        Skin { joints: vec![NodeId(0), NodeId(1)], inverse_bind: vec![Affine3A::IDENTITY; 2] };
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
        let joints = joints.into_iter().map(NodeId).collect();
        Skeleton::new(&rig, &Skin { joints, inverse_bind }, &[]).map(|_| ()).unwrap_err()
    };
    let still = Affine3A::IDENTITY;
    assert_eq!(of(vec![], vec![]), SkinError::Empty);
    assert_eq!(of(vec![1], vec![]), SkinError::Count { joints: 1, matrices: 0 });
    assert_eq!(of(vec![1, 99], vec![still; 2]), SkinError::NoNode { joint: 1, node: 99 });
    let wild = Affine3A::from_translation(Vec3::splat(f32::NAN));
    assert_eq!(of(vec![1], vec![wild]), SkinError::NotFinite { joint: 0 });
}

struct Legs {
    positions: Vec<[f32; 3]>,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
}

/// Boxes around the legs' bones, with weights that go over from each bone to the next.
fn legs() -> Legs {
    let (mut positions, mut joints, mut weights) = (Vec::new(), Vec::new(), Vec::new());
    for (side, first) in [(-0.2, 1_u16), (0.2, 4)] {
        for step in 0..=20 {
            let down = step as f32 / 20.0;
            for (x, z) in [(-0.1, -0.1), (0.1, -0.1), (-0.1, 0.1), (0.1, 0.1)] {
                positions.push([side + x, 1.0 - down * 1.2, z]);
                let (along, bone) = ((down * 2.0).fract(), (down * 2.0) as u16);
                let over = if bone < 2 { along * along } else { 0.0 };
                joints.push([first + bone, first + (bone + 1).min(2), 0, 0]);
                weights.push([1.0 - over, over, 0.0, 0.0]);
            }
        }
    }
    Legs { positions, joints, weights }
}

#[test]
fn boxes_hold_and_are_not_much_too_large() {
    let rig = rig();
    let skin = skin(&rig);
    let skeleton = Skeleton::new(&rig, &skin, &[]).unwrap();
    let Legs { positions, joints, weights } = legs();
    let binding = Binding { skeleton: &skeleton, joints: &joints, weights: &weights, sets: 1 };
    let mesh = DeformedMesh {
        positions: &positions,
        targets: &[],
        node: NodeId(0),
        binding: Some(binding),
    };
    let reach = Reach::new(&rig, mesh).unwrap();
    let [walk, run] = [gait(&rig, 1.0, 0.4, 0.3), gait(&rig, 0.6, 0.9, 0.8)];
    let mut matrices = Vec::new();
    let mut tight = |steps: [i32; 3]| {
        let mut bounds = Aabb::EMPTY;
        let (mut pose, mut other) = (Pose::new(&rig), Pose::new(&rig));
        let share = |step: i32, axis: usize| step as f32 / steps[axis].max(1) as f32;
        for (a, b) in (0..=steps[0]).flat_map(|a| (0..=steps[1]).map(move |b| (a, b))) {
            for weight in 0..=steps[2] {
                pose.reset(&rig);
                other.reset(&rig);
                pose.sample(&walk, share(a, 0) * 1.0);
                other.sample(&run, share(b, 1) * 0.6);
                pose.blend(&other, share(weight, 2));
                skeleton.joint_matrices(&rig, &pose, &mut matrices);
                for ((position, joints), weights) in positions.iter().zip(&joints).zip(&weights) {
                    let at =
                        |j: u16| matrices[usize::from(j)].transform_point3(Vec3::from(*position));
                    let vertex = joints.iter().zip(weights).map(|(j, w)| at(*j) * *w).sum();
                    bounds = bounds.union(&Aabb::new(vertex, vertex));
                }
            }
        }
        bounds
    };
    let alone = (reach.clip_bounds(&walk).unwrap(), tight([500, 0, 0]));
    let mixed = (reach.blend_bounds(&[&walk, &run]).unwrap(), tight([32, 32, 6]));
    for ((bounds, tight), most) in [(alone, 1.3), (mixed, 2.0)] {
        assert!(bounds.contains(&tight), "{bounds:?} does not hold {tight:?}");
        let ratio = (bounds.max - bounds.min) / (tight.max - tight.min);
        assert!(ratio.max_element() < most, "{bounds:?} is {ratio} of {tight:?}");
    }
}
