//! The CPU's data of one skinned mesh: its newest pose, and what of it is on the GPU.

use cull::Aabb;
use glam::Affine3A;
use scene::{Mesh, MeshId, PoseBounds, SkinnedMesh, SurfaceVertex, TransparentId};

use crate::passes::{NOTHING, REST_VALUES, SkinningJob};

/// The CPU's data of a skinned mesh.
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
    /// The number of poses that it had.
    pub(super) pose_count: u64,
    /// True if the frame being recorded writes the vertices for certain.
    pub(super) is_written: bool,
    /// True if a frame left it to a test whether the vertices are written.
    pub(crate) is_stale: bool,
    /// The job with its place among this frame's poses.
    pub(super) pose: SkinningJob,
}

/// The places of a target's lists in the mesh data, in values, or [`NOTHING`].
#[derive(Clone, Copy)]
pub(super) struct TargetPlaces([u32; 3]);

impl SkinnedMeshState {
    /// Appends the data of a skinned mesh to the values of all.
    pub(super) fn new(
        skinned_mesh: &SkinnedMesh,
        (mesh, surface): (&Mesh, &[SurfaceVertex]),
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
            // At rest, as the vertices are: no pose was set yet.
            joints: Vec::new(),
            weights: Vec::new(),
            is_dirty: false,
            pose_count: 0,
            is_written: false,
            is_stale: false,
            pose: rest,
        }
    }

    /// Notes that the newest pose is on the GPU.
    pub(super) fn settle(&mut self) {
        (self.is_dirty, self.is_stale, self.shown_bounds) = (false, false, self.bounds);
    }

    /// Appends its pose to those of a frame.
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
