//! Small scenes of all kinds: trees of nodes, tracks of all kinds, meshes on them.

use animation::{
    Channel, Clip, Interpolation, Pose, Rest, Rig, RigNode, RigNodeId, Skeleton, Skin, Track, Trs,
    Values,
};
use glam::{Affine3A, Quat, Vec3};
use proptest::prelude::*;
use scene::{MorphTarget, PoseBounds, SkinWeights};

/// The number of morph targets of the mesh, and of weights per node.
const TARGETS: usize = 2;

#[derive(Clone, Debug)]
pub struct Animated {
    pub rig: Rig,
    pub clips: Vec<Clip>,
    pub skin: Skin,
    pub positions: Vec<[f32; 3]>,
    pub targets: Vec<Vec<[f32; 3]>>,
    pub joints: Vec<[u16; 4]>,
    pub weights: Vec<[f32; 4]>,
}

impl Animated {
    pub fn skeleton(&self) -> Skeleton {
        Skeleton::new(&self.rig, &self.skin, &[]).unwrap()
    }

    /// Returns the boxes of the rig's mesh, with or without the skin.
    pub fn bounds(&self, is_skinned: bool) -> PoseBounds {
        let skin = SkinWeights {
            joint_count: self.skin.joints.len() as u32,
            joints: self.joints.clone(),
            weights: self.weights.clone(),
            sets: 1,
        };
        let targets = self.targets.iter().map(|positions| MorphTarget {
            positions: positions.clone(),
            ..MorphTarget::default()
        });
        let targets: Vec<MorphTarget> = targets.collect();
        let positions = self.positions.iter().copied().map(Vec3::from);
        PoseBounds::new(positions, is_skinned.then_some(&skin), &targets)
    }

    /// Returns the positions of all vertices in the object's space, as a GPU would compute them.
    pub fn vertices(&self, matrices: Option<&[Affine3A]>, pose: &Pose) -> Vec<Vec3> {
        let vertex = |index: usize| {
            let mut place = Vec3::from(self.positions[index]);
            for (target, weight) in self.targets.iter().zip(pose.weights(RigNodeId(0))) {
                place += Vec3::from(target[index]) * *weight;
            }
            let Some(matrices) = matrices else { return place };
            let pairs = self.joints[index].iter().zip(self.weights[index]);
            pairs.map(|(joint, w)| matrices[usize::from(*joint)].transform_point3(place) * w).sum()
        };
        (0..self.positions.len()).map(vertex).collect()
    }
}

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from)
}

/// Returns scales of any sign, including zero.
fn scale() -> impl Strategy<Value = Vec3> {
    prop_oneof![
        3 => Just(Vec3::ONE),
        2 => vector(1.5),
        1 => Just(Vec3::ZERO),
        1 => Just(Vec3::new(1.0, 0.0, -1.0))
    ]
}

/// Returns small rotations and arbitrary rotations.
fn rotation() -> impl Strategy<Value = Quat> {
    prop_oneof![vector(0.4), vector(3.0)].prop_map(Quat::from_scaled_axis)
}

fn parts() -> impl Strategy<Value = Trs> {
    (vector(1.0), rotation(), scale()).prop_map(|(translation, rotation, scale)| Trs {
        translation,
        rotation,
        scale,
    })
}

fn node() -> impl Strategy<Value = RigNode> {
    let matrix = parts().prop_map(|parts| Rest::Matrix(parts.to_affine()));
    (prop_oneof![5 => parts().prop_map(Rest::Parts), 1 => matrix]).prop_map(|rest| RigNode {
        name: String::new(),
        parent: None,
        rest,
        weights: vec![0.3; TARGETS],
    })
}

fn track() -> impl Strategy<Value = Track> {
    use Interpolation::{Cubic, Linear, Step};
    let shape = (prop_oneof![Just(Step), Just(Linear), Just(Cubic)], 1_usize..5, 0..4);
    shape.prop_flat_map(|(interpolation, keys, property)| {
        let count = keys * if interpolation == Cubic { 3 } else { 1 };
        let values = match property {
            0 => prop::collection::vec(vector(2.0), count).prop_map(Values::Translation).boxed(),
            1 => prop::collection::vec(rotation(), count).prop_map(Values::Rotation).boxed(),
            2 => prop::collection::vec(scale(), count).prop_map(Values::Scale).boxed(),
            _ => prop::collection::vec(-1.0_f32..2.0, count * TARGETS)
                .prop_map(Values::Weights)
                .boxed(),
        };
        let gaps_s = prop::collection::vec(0.1_f32..1.0, keys);
        (gaps_s, values).prop_map(move |(gaps_s, values)| {
            let mut now_s = -0.1;
            let times_s = gaps_s.iter().map(|gap_s| {
                now_s += gap_s;
                now_s
            });
            Track::new(interpolation, times_s.collect(), values, TARGETS).unwrap()
        })
    })
}

/// Returns a clip of the channels; channels that do not fit the rig or are repeated are left out.
fn clip(rig: &Rig, channels: Vec<(prop::sample::Index, Track)>) -> Clip {
    let mut kept: Vec<Channel> = Vec::new();
    for (node, track) in channels {
        let node = if matches!(track.values, Values::Weights(_)) {
            0
        } else {
            node.index(rig.nodes().len())
        };
        let channel = Channel { node: RigNodeId(node as u32), track };
        let with = [kept.as_slice(), std::slice::from_ref(&channel)].concat();
        if Clip::new(String::new(), with, rig).is_ok() {
            kept.push(channel);
        }
    }
    Clip::new(String::new(), kept, rig).unwrap()
}

pub fn animated() -> impl Strategy<Value = Animated> {
    let nodes = prop::collection::vec((node(), any::<prop::sample::Index>()), 1..7);
    let clips = prop::collection::vec(
        prop::collection::vec((any::<prop::sample::Index>(), track()), 0..6),
        1..4,
    );
    let vertex = (
        vector(1.0),
        [vector(0.5), vector(0.5)],
        any::<[prop::sample::Index; 4]>(),
        prop::array::uniform4(0.0_f32..1.0),
    );
    let joints = prop::collection::vec((any::<prop::sample::Index>(), parts()), 1..5);
    (nodes, clips, joints, prop::collection::vec(vertex, 1..6), any::<bool>()).prop_map(
        |(nodes, clips, joints, vertices, has_targets)| {
            let node = |(id, (node, parent)): (usize, (RigNode, prop::sample::Index))| {
                // About one node in five has no parent; the parent of any other node precedes it.
                let parent = parent.index(id + 1).checked_sub(usize::from(id > 3));
                RigNode { parent: parent.filter(|p| *p < id).map(|p| RigNodeId(p as u32)), ..node }
            };
            let rig = Rig::new(nodes.into_iter().enumerate().map(node).collect()).unwrap();
            let place = |index: &prop::sample::Index, of: usize| index.index(of) as u16;
            let skin = Skin {
                joints: joints
                    .iter()
                    .map(|(n, _)| RigNodeId(place(n, rig.nodes().len()).into()))
                    .collect(),
                inverse_bind: joints.iter().map(|(_, parts)| parts.to_affine()).collect(),
            };
            let target = |target: usize| vertices.iter().map(|v| v.1[target].to_array()).collect();
            Animated {
                clips: clips.into_iter().map(|channels| clip(&rig, channels)).collect(),
                positions: vertices.iter().map(|vertex| vertex.0.to_array()).collect(),
                targets: (0..if has_targets { TARGETS } else { 0 }).map(target).collect(),
                joints: vertices.iter().map(|v| v.2.map(|j| place(&j, joints.len()))).collect(),
                weights: vertices
                    .iter()
                    .map(|v| v.3.map(|w| w / v.3.iter().sum::<f32>()))
                    .collect(),
                skin,
                rig,
            }
        },
    )
}
