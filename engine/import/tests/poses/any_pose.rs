//! Tests of poses that no clip produces: arbitrary matrices and weights, and meshes far from the
//! place where they are shown.

use cull::Aabb;
use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use proptest::prelude::*;
use scene::{MorphTarget, PoseBounds, SkinWeights};

const JOINTS: u32 = 5;
const TARGETS: usize = 3;

#[derive(Clone, Debug)]
struct Posed {
    positions: Vec<Vec3>,
    skin: Option<SkinWeights>,
    targets: Vec<MorphTarget>,
    joints: Vec<Affine3A>,
    weights: Vec<f32>,
}

impl Posed {
    fn bounds(&self) -> Option<Aabb> {
        let positions = self.positions.iter().copied();
        let bounds = PoseBounds::new(positions, self.skin.as_ref(), &self.targets);
        bounds.bounds(&self.joints, &self.weights)
    }

    /// Returns the position of a vertex in single precision, as in `skinning.comp`, or with fused
    /// multiplication.
    fn vertex(&self, number: usize, is_fused: bool) -> Vec3 {
        let add = |sum: f32, a: f32, b: f32| if is_fused { a.mul_add(b, sum) } else { sum + a * b };
        let mut at = self.positions[number].to_array();
        for (target, weight) in self.targets.iter().zip(&self.weights) {
            let Some(displacement) = target.positions.get(number) else { continue };
            at = std::array::from_fn(|axis| add(at[axis], *weight, displacement[axis]));
        }
        let Some(skin) = &self.skin else { return at.into() };
        let mut rows = [[0.0_f32; 4]; 3];
        let sets = skin.sets as usize;
        for set in number * sets..(number + 1) * sets {
            for (joint, weight) in skin.joints[set].iter().zip(skin.weights[set]) {
                if weight == 0.0 {
                    continue;
                }
                let Affine3A { matrix3, translation } = self.joints[usize::from(*joint)];
                for (axis, row) in rows.iter_mut().enumerate() {
                    let part = matrix3.row(axis);
                    let part = [part.x, part.y, part.z, translation[axis]];
                    *row = std::array::from_fn(|column| add(row[column], weight, part[column]));
                }
            }
        }
        let point = [at[0], at[1], at[2], 1.0];
        let dot = |row: [f32; 4]| (0..4).fold(0.0, |sum, part| add(sum, row[part], point[part]));
        rows.map(dot).into()
    }
}

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from)
}

/// Returns an arbitrary matrix: it rotates, shears, mirrors or flattens, near or far away.
fn joint(far: Vec3) -> impl Strategy<Value = Affine3A> {
    (prop::array::uniform3(vector(2.0)), vector(3.0)).prop_map(move |(axes, translation)| {
        let matrix3 = Mat3A::from_cols(axes[0].into(), axes[1].into(), axes[2].into());
        // Geometry that is far away at rest is moved here.
        let back = matrix3 * Vec3A::from(far);
        Affine3A { matrix3, translation: Vec3A::from(translation) - back }
    })
}

fn posed() -> impl Strategy<Value = Posed> {
    let far = prop_oneof![Just(0.0_f32), Just(1e3), Just(1e6)];
    (far, 1_usize..12, 0_u32..3, 0..=TARGETS).prop_flat_map(|(far, count, sets, targets)| {
        let far = Vec3::new(far, far * -0.5, far * 0.25);
        let groups = count * sets as usize;
        let influence = (0..JOINTS as u16, prop_oneof![1 => Just(0.0_f32), 3 => 0.0_f32..1.0]);
        let displacements = prop::collection::vec(vector(1.5), count);
        (
            prop::collection::vec(vector(1.0), count),
            prop::collection::vec(prop::array::uniform4(influence), groups),
            prop::collection::vec(displacements, targets),
            prop::collection::vec(joint(far), JOINTS as usize),
            prop::collection::vec(prop_oneof![Just(0.0_f32), -2.0_f32..2.0], targets),
            0.97_f32..1.03,
        )
            .prop_map(move |(positions, influences, targets, joints, weights, sum)| {
                let mut skin = SkinWeights {
                    joint_count: JOINTS,
                    joints: influences
                        .iter()
                        .map(|influence| influence.map(|(joint, _)| joint))
                        .collect(),
                    weights: influences
                        .iter()
                        .map(|influence| influence.map(|(_, weight)| weight))
                        .collect(),
                    sets,
                };
                for weights in skin.weights.chunks_mut((sets as usize).max(1)) {
                    let weights = weights.as_flattened_mut();
                    weights[0] += 0.01;
                    let all: f32 = weights.iter().sum();
                    weights.iter_mut().for_each(|weight| *weight *= sum / all);
                }
                let list = |vectors: Vec<Vec3>| {
                    vectors.into_iter().map(|vectors| vectors.to_array()).collect()
                };
                let target =
                    |places| MorphTarget { positions: list(places), ..MorphTarget::default() };
                Posed {
                    positions: positions.into_iter().map(|at| at + far).collect(),
                    skin: (sets > 0).then_some(skin),
                    targets: targets.into_iter().map(target).collect(),
                    joints,
                    weights,
                }
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2048))]

    #[test]
    fn no_vertex_leaves_the_box_of_any_pose(posed in posed()) {
        let bounds = posed.bounds().unwrap();
        for vertex in 0..posed.positions.len() {
            for at in [posed.vertex(vertex, false), posed.vertex(vertex, true)] {
                prop_assert!(bounds.contains_point(at), "{} is outside of {:?}", at, bounds);
            }
        }
    }
}

/// Returns four corners, each lifted by its own morph target.
fn bumps() -> (Vec<Vec3>, Vec<MorphTarget>) {
    let corners: Vec<Vec3> = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::X + Vec3::Z].into();
    let lift = |target: usize| {
        let positions = (0..4).map(|index| [0.0, if index == target { 1.0 } else { 0.0 }, 0.0]);
        MorphTarget { positions: positions.collect(), ..MorphTarget::default() }
    };
    (corners, (0..4).map(lift).collect())
}

#[test]
fn boxes_are_as_large_as_poses() {
    let (corners, targets) = bumps();
    let still = PoseBounds::new(corners.iter().copied(), None, &[]).bounds(&[], &[]).unwrap();
    assert!(still.max.distance(Vec3::new(1.0, 0.0, 1.0)) < 1e-5, "{still:?}");
    let bounds = PoseBounds::new(corners.iter().copied(), None, &targets);
    let height = |weights: [f32; 4]| {
        let bounds = bounds.bounds(&[], &weights).unwrap();
        [bounds.min.y, bounds.max.y]
    };
    for (weights, expected) in [
        ([0.0; 4], [0.0, 0.0]),
        ([0.0, 2.0, 0.0, 0.0], [0.0, 2.0]),
        ([0.0, -2.0, 0.0, 0.5], [-2.0, 0.5]),
        // Each vertex has at most one of them.
        ([1.0; 4], [0.0, 1.0]),
        ([-1.0, 0.5, 0.5, 0.5], [-1.0, 0.5]),
    ] {
        let found = height(weights);
        let is_near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-4;
        assert!(found.iter().zip(&expected).all(is_near), "{found:?} for {expected:?}");
    }
}

/// Returns the size of the box of a pose relative to the tight box of its vertices.
fn ratio(posed: &Posed) -> Vec3 {
    let vertices = (0..posed.positions.len()).map(|vertex| posed.vertex(vertex, false));
    let tight = vertices.fold(Aabb::EMPTY, |all, at| all.union(&Aabb::new(at, at)));
    let bounds = posed.bounds().unwrap();
    (bounds.max - bounds.min) / (tight.max - tight.min)
}

#[test]
fn the_box_of_an_arm_that_bends_is_not_much_too_large() {
    let mut positions = Vec::new();
    let mut joints = Vec::new();
    let mut weights = Vec::new();
    for step in 0..=20_u8 {
        let along = f32::from(step) * 0.1;
        for (y, z) in [(-0.1, -0.1), (0.1, -0.1), (-0.1, 0.1), (0.1, 0.1)] {
            positions.push(Vec3::new(along, y, z));
            let lower = ((along - 0.9) * 5.0).clamp(0.0, 1.0);
            joints.push([0, 1, 0, 0]);
            weights.push([1.0 - lower, lower, 0.0, 0.0]);
        }
    }
    let skin = SkinWeights { joint_count: 2, joints, weights, sets: 1 };
    for degrees in 0..=120_u8 {
        let bend = Affine3A::from_rotation_z(f32::from(degrees).to_radians());
        let elbow = Affine3A::from_translation(Vec3::X);
        let joints = vec![Affine3A::IDENTITY, elbow * bend * elbow.inverse()];
        let posed = Posed {
            positions: positions.clone(),
            skin: Some(skin.clone()),
            targets: Vec::new(),
            joints,
            weights: Vec::new(),
        };
        let ratio = ratio(&posed);
        assert!(ratio.max_element() < 1.25, "{degrees} degrees: {ratio}");
    }
}

#[test]
fn what_has_no_box_is_told_from_what_has_one() {
    let (corners, targets) = bumps();
    let skin = |joint| SkinWeights {
        joint_count: 2,
        joints: vec![[joint; 4]; 4],
        weights: vec![[1.0, 0.0, 0.0, 0.0]; 4],
        sets: 1,
    };
    let in_pose = |joints: &[Affine3A], weights: [f32; 4]| {
        PoseBounds::new(corners.iter().copied(), Some(&skin(1)), &targets).bounds(joints, &weights)
    };
    let here = Affine3A::IDENTITY;
    assert!(in_pose(&[here; 2], [0.0; 4]).is_some());
    assert_eq!(in_pose(&[here], [0.0; 4]), None, "a joint is missing");
    assert_eq!(in_pose(&[here; 2], [f32::MAX; 4]), None);
    for far in [1e16, f32::INFINITY, f32::NAN] {
        let there = Affine3A::from_translation(Vec3::splat(far));
        assert_eq!(in_pose(&[here, there], [0.0; 4]), None, "{far}");
        assert!(in_pose(&[there, here], [0.0; 4]).is_some(), "no vertex follows joint 0");
    }
    let nothing = PoseBounds::new([].into_iter(), Some(&skin(0)), &[]).bounds(&[], &[]);
    assert_eq!(nothing, Some(Aabb::new(Vec3::ZERO, Vec3::ZERO)), "a mesh without vertices");
}
