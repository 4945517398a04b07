//! The CPU data of one skinned mesh: its newest pose, and the state of the vertices on the GPU.

use std::collections::HashMap;

use cull::Aabb;
use glam::{Affine3A, Vec3};
use scene::{Mesh, MeshId, PoseBounds, SkinnedMesh, SurfaceVertex, TransparentId};

use crate::passes::{NOTHING, REST_VALUES, SkinningJob};

/// The number of values for four joints and their weights.
const SKIN_VALUES: u32 = 6;

/// The CPU data of a skinned mesh.
pub(crate) struct SkinnedMeshState {
    pub(crate) mesh: MeshId,
    /// The transparent object of the mesh, if there is one.
    pub(crate) transparent: Option<TransparentId>,
    pub(super) pose_bounds: PoseBounds,
    /// The box of the newest pose, in the space of the mesh.
    pub(crate) bounds: Aabb,
    /// The box of the vertices on the GPU.
    pub(crate) shown_bounds: Aabb,
    /// The job without its pose.
    pub(super) rest: SkinningJob,
    pub(super) joint_count: usize,
    pub(super) targets: Vec<TargetPlaces>,
    pub(super) joints: Vec<Affine3A>,
    pub(super) weights: Vec<f32>,
    pub(super) is_dirty: bool,
    /// The number of poses that the mesh has had.
    pub(super) pose_count: u64,
    /// True if the frame being recorded writes the vertices for certain.
    pub(super) is_written: bool,
    /// True if an earlier frame wrote the vertices only if a test said so.
    pub(crate) is_stale: bool,
    /// The job with the offsets of this frame's pose.
    pub(super) pose: SkinningJob,
}

/// The offsets of a target's lists in the mesh data, or [`NOTHING`].
#[derive(Clone, Copy)]
pub(super) struct TargetPlaces([u32; 3]);

impl SkinnedMeshState {
    /// Appends the data of a skinned mesh to the data of all.
    pub(super) fn new(
        skinned_mesh: &SkinnedMesh,
        mesh: &Mesh,
        surface: &[SurfaceVertex],
        first_vertex: u32,
        values: &mut Vec<u32>,
    ) -> Self {
        let place = |values: &Vec<u32>| values.len() as u32;
        let mut rest = SkinningJob {
            vertex_count: mesh.vertices.len() as u32,
            first_vertex,
            rest: place(values),
            result: NOTHING,
            flag: NOTHING,
            ..SkinningJob::default()
        };
        for (vertex, surface) in mesh.vertices.iter().zip(surface) {
            values.extend(vertex.position.map(f32::to_bits));
            let [x, y, z, sides] = surface.normal;
            let [tangent_x, tangent_y, tangent_z, sign] = surface.tangent;
            let pairs = [[x, y], [z, sides], [tangent_x, tangent_y], [tangent_z, sign]];
            values.extend(
                pairs.map(|[low, high]| u32::from(low as u16) | u32::from(high as u16) << 16),
            );
        }
        debug_assert_eq!(place(values), rest.rest + REST_VALUES * rest.vertex_count);
        rest.skin = place(values);
        if let Some(skin) = &skinned_mesh.skin {
            rest.joint_sets = skin.sets;
            for (joints, weights) in skin.joints.iter().zip(&skin.weights) {
                let pair =
                    |first: usize| u32::from(joints[first]) | u32::from(joints[first + 1]) << 16;
                values.extend([pair(0), pair(2)]);
                values.extend(weights.map(f32::to_bits));
            }
        }
        let targets = skinned_mesh.targets.iter().map(|target| {
            TargetPlaces([&target.positions, &target.normals, &target.tangents].map(|list| {
                if list.is_empty() {
                    return NOTHING;
                }
                let begins = place(values);
                values.extend(list.as_flattened().iter().map(|part| part.to_bits()));
                begins
            }))
        });
        Self {
            mesh: skinned_mesh.mesh,
            transparent: None,
            pose_bounds: PoseBounds::of(mesh, skinned_mesh),
            bounds: mesh.bounds,
            shown_bounds: mesh.bounds,
            rest,
            targets: targets.collect(),
            joint_count: skinned_mesh.skin.as_ref().map_or(0, |skin| skin.joint_count as usize),
            // At rest, like the vertices: no pose has been set yet.
            joints: Vec::new(),
            weights: Vec::new(),
            is_dirty: false,
            pose_count: 0,
            is_written: false,
            is_stale: false,
            pose: rest,
        }
    }

    /// Returns the positions of the mesh's vertices at rest, from the mesh data, and a number for
    /// each. Vertices with equal numbers have the same position and are always moved in the same
    /// way ([`SkinnedMesh::motions`]).
    pub(crate) fn at_rest(&self, values: &[u32]) -> (Vec<Vec3>, Vec<u32>) {
        let value = |place: u32| values.get(place as usize).copied().unwrap_or_default();
        let vector = |place: u32| [0, 1, 2].map(|axis| f32::from_bits(value(place + axis)));
        let SkinningJob { vertex_count, rest, skin, joint_sets, .. } = self.rest;
        let positions = (0..vertex_count).map(|vertex| vector(rest + REST_VALUES * vertex).into());
        let mut known = HashMap::new();
        let motion_of = |vertex: u32| {
            let mut motion = Vec::new();
            for set in vertex * joint_sets..(vertex + 1) * joint_sets {
                let first = skin + SKIN_VALUES * set;
                let joints = [0, 1]
                    .map(|place| value(first + place))
                    .map(|pair| [pair & 0xFFFF, pair >> 16]);
                let weights = [2, 3, 4, 5].map(|place| value(first + place));
                let hung = joints.as_flattened().iter().zip(weights);
                // Negative zero counts as zero.
                let hung = hung.filter(|(_, weight)| f32::from_bits(*weight) != 0.0);
                motion.extend(hung.flat_map(|(joint, weight)| [*joint, weight]));
            }
            for TargetPlaces([positions, ..]) in &self.targets {
                if *positions != NOTHING {
                    let by = vector(positions + 3 * vertex);
                    motion.extend(by.map(|by| (by + 0.0).to_bits()));
                }
            }
            let next = known.len() as u32;
            *known.entry(motion).or_insert(next)
        };
        let motions = (0..vertex_count).map(motion_of).collect();
        (positions.collect(), motions)
    }

    /// Notes that the newest pose is on the GPU.
    pub(super) fn settle(&mut self) {
        (self.is_dirty, self.is_stale, self.shown_bounds) = (false, false, self.bounds);
    }

    /// Appends the pose to the poses of a frame.
    pub(super) fn write(&mut self, values: &mut Vec<u32>) {
        let joints = values.len() as u32;
        for joint in &self.joints {
            for row in 0..3 {
                let part = joint.matrix3.row(row);
                let row = [part.x, part.y, part.z, joint.translation[row]];
                values.extend(row.map(f32::to_bits));
            }
        }
        let targets = values.len() as u32;
        let mut target_count = 0;
        for (weight, TargetPlaces(places)) in self.weights.iter().zip(&self.targets) {
            if *weight != 0.0 {
                values.push(weight.to_bits());
                values.extend(places);
                target_count += 1;
            }
        }
        self.pose = SkinningJob { joints, targets, target_count, ..self.rest };
    }
}

#[cfg(test)]
mod tests {
    use scene::{MorphTarget, SkinWeights};

    use super::*;

    #[test]
    fn what_is_at_rest_is_read_out_of_the_mesh_data_as_the_scene_had_it() {
        let corners: Vec<_> = (0..6).map(|x| ([x as f32, 1.0, 2.0], [1.0; 3])).collect();
        let mesh = Mesh::of_triangles("mesh", &corners);
        let surface = vec![bytemuck::Zeroable::zeroed(); 6];
        let joints = (0..12).map(|set: u16| [set % 3, 1, 2, 3]).collect();
        let weights = (0..12).map(|set| [0.5, if set % 2 == 0 { 0.0 } else { 0.5 }, -0.0, 0.0]);
        let skin = SkinWeights { joint_count: 4, joints, weights: weights.collect(), sets: 2 };
        let by = (0..6).map(|vertex| [0.0, (vertex / 4) as f32, -0.0]).collect();
        let targets =
            vec![MorphTarget::default(), MorphTarget { positions: by, ..MorphTarget::default() }];
        for skin in [Some(skin), None] {
            let skinned = SkinnedMesh { mesh: MeshId(0), skin, targets: targets.clone() };
            let mut values = vec![7; 5];
            let state = SkinnedMeshState::new(&skinned, &mesh, &surface, 0, &mut values);
            let (positions, motions) = state.at_rest(&values);
            let places = mesh.vertices.iter().map(|vertex| Vec3::from(vertex.position));
            assert_eq!(positions, places.collect::<Vec<_>>());
            let expected = skinned.motions(6);
            assert_eq!(motions, expected);
            assert!(expected.iter().any(|pixel| *pixel > 0), "some move apart");
        }
    }
}
