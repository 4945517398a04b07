//! Skinned meshes. Their data is uploaded once; later only poses change, which the next frame
//! uploads. The vertices of a mesh are written before its first draw in that frame: at once if the
//! mesh is taken as visible, otherwise if the test of its proxy passes, which the GPU decides.

use std::collections::HashMap;

use cull::{Aabb, LeafIndex};
use glam::Affine3A;
use gpu::{
    Buffer, BufferSlice, Commands, Device, FlagRing, Frame, Predicate, ResultSource, Tick, vk,
};
use occlusion::UpcomingDraws;
use scene::{MeshId, MorphTarget, Scene, SkinnedMeshId, TransparentId};

use crate::error::Error;
use crate::passes::{PredicatedJob, REST_VALUES, SkinningIo, SkinningJob, SkinningPass};
use crate::resources::limits::check_storage;
use crate::resources::skinned_mesh_state::SkinnedMeshState;
use crate::update_errors::PoseError;

/// All skinned meshes of a scene and their newest poses.
pub(crate) struct SkinnedMeshes {
    mesh_data: Buffer,
    all: Vec<SkinnedMeshState>,
    /// The skinned meshes whose pose is not on the GPU yet.
    dirty: Vec<usize>,
    /// The skinned meshes whose pose the frame being recorded uploads.
    uploaded: Vec<usize>,
    /// The uploaded meshes whose vertices no recorded work writes for certain yet, in the order of
    /// leaves.
    deferred: Vec<(LeafIndex, usize)>,
    /// The buffers of the frame being recorded.
    io: Option<SkinningIo>,
    /// A flag per uploaded pose, set if the GPU wrote the vertices.
    written: FlagRing<WrittenTag>,
    /// The work of the frame being recorded.
    skinned: Skinned,
    /// The poses of a frame, kept to allocate nothing in the steady state.
    values: Vec<u32>,
}

/// The pose that a flag belongs to.
#[derive(Clone, Copy)]
struct WrittenTag {
    number: usize,
    /// The number of poses that the mesh had before this one.
    pose: u64,
    vertices: u32,
}

/// The skinned meshes to upload in a frame.
#[derive(Clone, Copy)]
pub(crate) enum PoseUploads<'a> {
    /// All skinned meshes with a new pose, written at once.
    All,
    /// The skinned meshes that one of the views may show, written once their draws are known.
    Seen(&'a [cull::CullView]),
}

/// The work of a frame for skinned meshes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Skinned {
    pub(crate) poses: u32,
    pub(crate) vertices: u64,
    pub(crate) predicated_vertices: u64,
    pub(crate) revealed_vertices: u64,
}

/// The vertices that the pass writes: the first ones.
#[derive(Clone, Copy)]
pub(crate) struct SkinnedVertices {
    pub(crate) vertices: BufferSlice,
    pub(crate) surfaces: BufferSlice,
}

impl SkinnedMeshes {
    /// Uploads the data of the skinned meshes of a validated scene. `first_vertices` holds the
    /// first vertex of each mesh.
    pub(crate) fn new(
        device: &Device,
        scene: &Scene,
        frames_in_flight: usize,
        first_vertices: impl Fn(usize) -> u32,
    ) -> Result<Option<Self>, Error> {
        let Some(surfaces) =
            scene.surfaces.as_ref().filter(|surface| !surface.skinned_meshes.is_empty())
        else {
            return Ok(None);
        };
        const FEWER: &str = "leave out joints or morph targets, or make those meshes simpler";
        let [mesh_data, poses] = value_counts(scene);
        let what = "values of joints, weights and morph targets";
        check_storage(device, what, mesh_data, 4, FEWER)?;
        check_storage(device, "poses", poses, 4, FEWER)?;
        let transparent = (0..).map(TransparentId).zip(&surfaces.transparent);
        let transparent: HashMap<_, _> =
            transparent.map(|(id, object)| (object.mesh, id)).collect();
        let mut values = Vec::new();
        let mut all = Vec::with_capacity(surfaces.skinned_meshes.len());
        for skinned_mesh in &surfaces.skinned_meshes {
            let mesh = skinned_mesh.mesh.0 as usize;
            let (Some(at_rest), Some(surface)) =
                (scene.meshes.get(mesh), surfaces.meshes.get(mesh))
            else {
                continue;
            };
            let transparent = transparent.get(&skinned_mesh.mesh).copied();
            let surface = &surface.vertices;
            let state = SkinnedMeshState::new(
                skinned_mesh,
                at_rest,
                surface,
                first_vertices(mesh),
                &mut values,
            );
            all.push(SkinnedMeshState { transparent, ..state });
        }
        debug_assert_eq!(values.len() as u64, mesh_data);
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC;
        Ok(Some(Self {
            mesh_data: device.upload("skinned mesh data", &values, storage)?,
            all,
            dirty: Vec::new(),
            uploaded: Vec::new(),
            deferred: Vec::new(),
            io: None,
            written: written_ring(device, frames_in_flight),
            skinned: Skinned::default(),
            values: Vec::new(),
        }))
    }

    /// Returns a skinned mesh, if it exists.
    pub(crate) fn get(&self, skinned_mesh: SkinnedMeshId) -> Option<&SkinnedMeshState> {
        self.all.get(skinned_mesh.0 as usize)
    }

    /// Returns the skinned mesh that moves the vertices of a mesh, if there is one.
    pub(crate) fn of_mesh(&self, mesh: MeshId) -> Option<&SkinnedMeshState> {
        self.all.iter().find(|state| state.mesh == mesh)
    }

    /// Returns the vertices at rest, joints, weights and morph targets of all skinned meshes, as
    /// 32-bit values.
    pub(crate) fn mesh_data(&self) -> BufferSlice {
        self.mesh_data.whole()
    }

    /// Returns the box of a mesh in a pose, in its own space; `None` if the mesh already has this
    /// pose. Fails for an impossible pose.
    pub(crate) fn bounds_in(
        &self,
        skinned_mesh: SkinnedMeshId,
        joints: &[Affine3A],
        weights: &[f32],
    ) -> Result<Option<Aabb>, Error> {
        let refuse = |reason| Err(Error::Pose { skinned_mesh, reason });
        let Some(state) = self.all.get(skinned_mesh.0 as usize) else {
            return refuse(PoseError::UnknownSkinnedMesh);
        };
        let joint_count = state.joint_count;
        let target_count = state.targets.len();
        if joints.len() != joint_count {
            return refuse(PoseError::JointCount { joints: joint_count, given: joints.len() });
        }
        if weights.len() != target_count {
            return refuse(PoseError::TargetCount { targets: target_count, given: weights.len() });
        }
        if let Some(joint) = joints.iter().position(|joint| !joint.is_finite()) {
            return refuse(PoseError::JointNotFinite { joint });
        }
        if let Some(target) = weights.iter().position(|weight| !weight.is_finite()) {
            return refuse(PoseError::WeightNotFinite { target });
        }
        if state.joints == joints && state.weights == weights {
            return Ok(None);
        }
        match state.pose_bounds.bounds(joints, weights) {
            Some(bounds) => Ok(Some(bounds)),
            None => refuse(PoseError::MeshOutOfRange),
        }
    }

    /// Sets a possible pose of a mesh, and its box in this pose.
    pub(crate) fn set_pose(
        &mut self,
        skinned_mesh: SkinnedMeshId,
        joints: &[Affine3A],
        weights: &[f32],
        bounds: Aabb,
    ) {
        let number = skinned_mesh.0 as usize;
        let Some(state) = self.all.get_mut(number) else { return };
        joints.clone_into(&mut state.joints);
        weights.clone_into(&mut state.weights);
        state.bounds = bounds;
        state.pose_count += 1;
        if !std::mem::replace(&mut state.is_dirty, true) {
            self.dirty.push(number);
        }
    }

    /// Sets the pose that each mesh has in `lost`, skinned meshes of the same scene.
    pub(crate) fn restore(&mut self, lost: &Self) {
        for (number, lost) in (0..).zip(&lost.all).filter(|(_, lost)| lost.pose_count > 0) {
            self.set_pose(SkinnedMeshId(number), &lost.joints, &lost.weights, lost.bounds);
        }
    }

    /// Changes the number of frames in flight.
    pub(crate) fn set_frames_in_flight(&mut self, device: &Device, frames_in_flight: usize) {
        self.written = written_ring(device, frames_in_flight);
    }

    /// Reads back the poses that are on the GPU, for frames that are over.
    fn collect(&mut self, completed: Tick) {
        let Self { written, all, dirty, skinned, .. } = self;
        written.collect(completed, |tags, flags| {
            for (tag, _) in tags.iter().zip(flags).filter(|(_, flag)| **flag != 0) {
                skinned.revealed_vertices += u64::from(tag.vertices);
                if let Some(state) =
                    all.get_mut(tag.number).filter(|state| state.pose_count == tag.pose)
                {
                    state.settle();
                }
            }
        });
        dirty.retain(|number| all.get(*number).is_some_and(|state| state.is_dirty));
    }

    /// Uploads the newest poses of the skinned meshes that `is_seen` accepts, before anything of
    /// `frame` reads vertices. The vertices of a mesh with a leaf are written when the leaf's draw
    /// is [announced](SkinnedMeshes::prepare), others at once. Meshes stay dirty until the frame
    /// was [submitted](SkinnedMeshes::submitted), which may never happen.
    pub(crate) fn upload(
        &mut self,
        frame: &mut Frame<'_>,
        completed: Tick,
        pass: &SkinningPass,
        target: SkinnedVertices,
        is_seen: impl Fn(&SkinnedMeshState) -> bool,
        leaf_of: impl Fn(&SkinnedMeshState) -> Option<LeafIndex>,
    ) -> Result<(), Error> {
        self.skinned = Skinned::default();
        self.collect(completed);
        self.deferred.clear();
        self.uploaded.clear();
        let Self { all, dirty, uploaded, .. } = self;
        uploaded.extend(dirty.iter().filter(|number| all.get(**number).is_some_and(&is_seen)));
        let tags = uploaded.iter().map(|number| {
            let state = all.get(*number);
            let [pose, vertices] = state
                .map_or([0; 2], |state| [state.pose_count, u64::from(state.rest.vertex_count)]);
            WrittenTag { number: *number, pose, vertices: vertices as u32 }
        });
        self.written.begin(frame, tags)?;
        if self.uploaded.is_empty() {
            return Ok(());
        }
        self.values.clear();
        for (flag, number) in (0..).zip(&self.uploaded) {
            if let Some(state) = self.all.get_mut(*number) {
                state.write(&mut self.values);
                (state.pose.flag, state.is_written) = (flag, false);
                self.skinned.poses += 1;
            }
        }
        let poses = frame.uploads().push(&self.values)?;
        let SkinnedVertices { vertices, surfaces } = target;
        let mesh_data = self.mesh_data.whole();
        let written = self.written.results();
        let io = SkinningIo { vertices, surfaces, mesh_data, poses, written };
        self.io = Some(io);
        let mut at_once = Vec::new();
        for number in &self.uploaded {
            match self.all.get(*number).and_then(&leaf_of) {
                Some(leaf) => self.deferred.push((leaf, *number)),
                None => at_once.push(*number),
            }
        }
        self.deferred.sort_unstable();
        self.write_vertices(frame.commands(), pass, &at_once);
        Ok(())
    }

    /// Returns true while the vertices of some mesh are not written for certain.
    pub(crate) fn is_deferring(&self) -> bool {
        !self.deferred.is_empty()
    }

    /// Writes the vertices of the deferred meshes that the announced draws may read.
    pub(crate) fn prepare(
        &mut self,
        commands: &Commands,
        pass: &SkinningPass,
        draws: UpcomingDraws<'_>,
    ) {
        let deferred = std::mem::take(&mut self.deferred);
        let at = |leaf: LeafIndex| deferred.binary_search_by_key(&leaf, |(leaf, _)| *leaf).ok();
        let numbers: Vec<usize> = match draws {
            UpcomingDraws::All => deferred.iter().map(|(_, number)| *number).collect(),
            UpcomingDraws::Visible(plan) => {
                let queried = plan.queried_draws.iter().map(|(leaf, _)| *leaf);
                let visible = plan.draws.iter().copied().chain(queried);
                visible.filter_map(|leaf| Some(deferred.get(at(leaf)?)?.1)).collect()
            }
            UpcomingDraws::Revealed(revealed) => {
                self.write_revealed(commands, pass, &deferred, revealed);
                Vec::new()
            }
        };
        self.write_vertices(commands, pass, &numbers);
        self.deferred = deferred;
        let all = &self.all;
        self.deferred.retain(|(_, number)| all.get(*number).is_some_and(|state| !state.is_written));
    }

    fn write_vertices(&mut self, commands: &Commands, pass: &SkinningPass, numbers: &[usize]) {
        let Some(io) = self.io.filter(|_| !numbers.is_empty()) else { return };
        let Self { all, skinned, .. } = self;
        pass.record(
            commands,
            &io,
            numbers.iter().filter_map(|number| {
                let state = all.get_mut(*number).filter(|state| !state.is_written)?;
                state.is_written = true;
                skinned.vertices += u64::from(state.rest.vertex_count);
                Some(PredicatedJob { results: None, job: state.pose })
            }),
        );
    }

    /// Writes the vertices of meshes whose draws depend on results, if these results reveal them.
    fn write_revealed(
        &mut self,
        commands: &Commands,
        pass: &SkinningPass,
        deferred: &[(LeafIndex, usize)],
        revealed: &[Predicate],
    ) {
        let first_at = |leaf: u32| deferred.partition_point(|(upload, _)| upload.0 < leaf);
        let meshes_of = |predicate: &Predicate| {
            first_at(predicate.leaves.first)
                ..first_at(predicate.leaves.first + predicate.leaves.count)
        };
        let Some(io) =
            self.io.filter(|_| revealed.iter().any(|range| !meshes_of(range).is_empty()))
        else {
            return;
        };
        let Self { all, skinned, .. } = self;
        let jobs = revealed.iter().flat_map(|predicate| {
            let meshes = deferred.get(meshes_of(predicate)).unwrap_or_default();
            meshes.iter().map(move |(_, number)| (predicate, *number))
        });
        let jobs = jobs.filter_map(|(predicate, number)| {
            let state = all.get(number)?;
            skinned.predicated_vertices += u64::from(state.rest.vertex_count);
            let Predicate { results, result, threshold_samples, .. } = *predicate;
            let job = SkinningJob { result, threshold_samples, ..state.pose };
            Some(PredicatedJob { results: Some(results), job })
        });
        pass.record(commands, &io, jobs);
    }

    /// Copies the flags to the CPU, as their last use in a frame.
    pub(crate) fn read_back(&self, commands: &Commands) {
        if !self.uploaded.is_empty() {
            self.written.read_back(commands);
        }
    }

    /// Returns the work of the frame that was recorded last.
    pub(crate) fn skinned(&self) -> Skinned {
        self.skinned
    }

    /// Notes that the frame of the last [`SkinnedMeshes::upload`] was submitted. Vertices that may
    /// or may not have been written count as being in both poses.
    pub(crate) fn submitted(&mut self, tick: Tick) {
        self.written.submitted(tick);
        self.deferred.clear();
        for number in self.uploaded.drain(..) {
            let Some(state) = self.all.get_mut(number) else { continue };
            if std::mem::take(&mut state.is_written) {
                state.settle();
            } else {
                state.is_stale = true;
                state.shown_bounds = state.shown_bounds.union(&state.bounds);
            }
        }
        let all = &self.all;
        self.dirty.retain(|number| all.get(*number).is_some_and(|state| state.is_dirty));
    }
}

fn written_ring(device: &Device, frames_in_flight: usize) -> FlagRing<WrittenTag> {
    FlagRing::new(device, frames_in_flight, ResultSource::Compute, "written meshes")
}

/// Returns the number of values of the mesh data of a scene, and of all its poses.
fn value_counts(scene: &Scene) -> [u64; 2] {
    let mut sums = [0, 0];
    for skinned_mesh in scene.surfaces.iter().flat_map(|surfaces| &surfaces.skinned_meshes) {
        let mesh = scene.meshes.get(skinned_mesh.mesh.0 as usize);
        let skin = skinned_mesh.skin.as_ref();
        let influences = skin.map_or(0, |skin| skin.joints.len() as u64);
        let lists = |target: &MorphTarget| {
            (target.positions.len() + target.normals.len() + target.tangents.len()) as u64
        };
        sums[0] += mesh.map_or(0, |mesh| mesh.vertices.len() as u64) * u64::from(REST_VALUES)
            + influences * 6
            + skinned_mesh.targets.iter().map(lists).sum::<u64>() * 3;
        sums[1] += skin.map_or(0, |skin| u64::from(skin.joint_count)) * 12
            + skinned_mesh.targets.len() as u64 * 4;
    }
    sums
}

/// Returns the meshes of a scene in the order of their vertices. Skinned meshes come first, so that
/// they are one part of the buffers, which can be bound as a storage buffer.
pub(crate) fn mesh_order(scene: &Scene) -> Vec<usize> {
    let is_skinned = are_skinned(scene);
    let mut order: Vec<usize> = (0..scene.meshes.len()).collect();
    order.sort_by_key(|mesh| !is_skinned[*mesh]);
    order
}

/// Returns the number of vertices of all skinned meshes.
pub(crate) fn skinned_vertices(scene: &Scene) -> u64 {
    let skinned_meshes = scene.surfaces.iter().flat_map(|surfaces| &surfaces.skinned_meshes);
    let meshes =
        skinned_meshes.filter_map(|skinned_mesh| scene.meshes.get(skinned_mesh.mesh.0 as usize));
    meshes.map(|mesh| mesh.vertices.len() as u64).sum()
}

/// Returns true for each mesh of a scene that is skinned.
pub(crate) fn are_skinned(scene: &Scene) -> Vec<bool> {
    let mut are_skinned = vec![false; scene.meshes.len()];
    for skinned_mesh in scene.surfaces.iter().flat_map(|surfaces| &surfaces.skinned_meshes) {
        if let Some(is_skinned) = are_skinned.get_mut(skinned_mesh.mesh.0 as usize) {
            *is_skinned = true;
        }
    }
    are_skinned
}
