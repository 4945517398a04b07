//! Skinned meshes: their data lies on the GPU since loading; only the pose changes, which the next
//! frame uploads before anything reads the vertices.

use std::collections::HashMap;

use cull::Aabb;
use glam::Affine3A;
use gpu::{Buffer, BufferSlice, Device, Frame, vk};
use scene::{
    Mesh, MeshId, MorphTarget, PoseBounds, Scene, SkinnedMesh, SkinnedMeshId, SurfaceVertex,
    TransparentId,
};

use crate::error::Error;
use crate::passes::{REST_VALUES, SkinningIo, SkinningJob, SkinningPass};
use crate::resources::limits::check_storage;

/// All skinned meshes of a scene and their newest poses.
pub(crate) struct SkinnedMeshes {
    mesh_data: Buffer,
    all: Vec<State>,
    /// The skinned meshes whose pose is not on the GPU yet.
    dirty: Vec<usize>,
    /// The skinned meshes whose pose the frame being recorded uploads.
    uploaded: Vec<usize>,
    /// The poses of a frame, kept to allocate nothing.
    values: Vec<u32>,
}

/// The CPU's data of a skinned mesh.
pub(crate) struct State {
    pub(crate) mesh: MeshId,
    /// The transparent object of the mesh, if there is one.
    pub(crate) transparent: Option<TransparentId>,
    pose_bounds: PoseBounds,
    /// The box of the newest pose, in the space of the mesh.
    pub(crate) bounds: Aabb,
    /// The box of the vertices on the GPU.
    pub(crate) shown_bounds: Aabb,
    /// The job without its pose.
    rest: SkinningJob,
    joint_count: usize,
    targets: Vec<TargetPlaces>,
    joints: Vec<Affine3A>,
    weights: Vec<f32>,
    is_dirty: bool,
    /// The job with its place among this frame's poses.
    pose: SkinningJob,
}

/// The places of a target's lists in the mesh data, in values, or [`NOTHING`].
#[derive(Clone, Copy)]
struct TargetPlaces([u32; 3]);

/// The place of an empty list; mirrors `skinning.comp`.
const NOTHING: u32 = u32::MAX;

/// The work of a frame for skinned meshes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Skinned {
    pub(crate) poses: u32,
    pub(crate) vertices: u64,
}

/// The vertices that the pass writes, from the first on.
#[derive(Clone, Copy)]
pub(crate) struct SkinnedVertices {
    pub(crate) vertices: BufferSlice,
    pub(crate) surfaces: BufferSlice,
}

impl SkinnedMeshes {
    /// Uploads the data of the skinned meshes of a scene that was validated. `first_vertices` holds
    /// the first vertex of each mesh.
    ///
    /// # Errors
    /// More than the device's storage buffers hold, no memory, a failed call.
    pub(crate) fn new(
        device: &Device,
        scene: &Scene,
        first_vertices: impl Fn(usize) -> u32,
    ) -> Result<Option<Self>, Error> {
        let Some(surfaces) = scene.surfaces.as_ref().filter(|it| !it.skinned_meshes.is_empty())
        else {
            return Ok(None);
        };
        const FEWER: &str = "leave out joints or morph targets, or make those meshes simpler";
        let [mesh_data, poses] = value_counts(scene);
        let what = "values of joints, weights and morph targets";
        check_storage(device, what, (mesh_data, 4), FEWER)?;
        check_storage(device, "poses", (poses, 4), FEWER)?;
        let transparent = (0..).map(TransparentId).zip(&surfaces.transparent);
        let transparent: HashMap<_, _> =
            transparent.map(|(id, object)| (object.mesh, id)).collect();
        let (mut values, mut all) = (Vec::new(), Vec::with_capacity(surfaces.skinned_meshes.len()));
        for skinned_mesh in &surfaces.skinned_meshes {
            let mesh = skinned_mesh.mesh.0 as usize;
            let (Some(at_rest), Some(surface)) =
                (scene.meshes.get(mesh), surfaces.meshes.get(mesh))
            else {
                continue;
            };
            let transparent = transparent.get(&skinned_mesh.mesh).copied();
            let surface = &surface.vertices;
            let state =
                State::new(skinned_mesh, (at_rest, surface), first_vertices(mesh), &mut values);
            all.push(State { transparent, ..state });
        }
        debug_assert_eq!(values.len() as u64, mesh_data);
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        Ok(Some(Self {
            mesh_data: device.upload("skinned mesh data", &values, storage)?,
            all,
            dirty: Vec::new(),
            uploaded: Vec::new(),
            values: Vec::new(),
        }))
    }

    /// Returns a skinned mesh, if the scene has it.
    pub(crate) fn get(&self, skinned_mesh: SkinnedMeshId) -> Option<&State> {
        self.all.get(skinned_mesh.0 as usize)
    }

    /// Returns the box of the mesh in a pose, in its own space; `None` if it has this pose already.
    ///
    /// # Errors
    /// An impossible pose.
    pub(crate) fn bounds_in(
        &self,
        skinned_mesh: SkinnedMeshId,
        joints: &[Affine3A],
        weights: &[f32],
    ) -> Result<Option<Aabb>, Error> {
        let refuse = |reason: String| Err(Error::Pose { skinned_mesh, reason });
        let Some(state) = self.all.get(skinned_mesh.0 as usize) else {
            return refuse("the scene has no such skinned mesh".to_owned());
        };
        let (joint_count, target_count) = (state.joint_count, state.targets.len());
        if joints.len() != joint_count {
            return refuse(format!("it has {joint_count} joints, not {}", joints.len()));
        }
        if weights.len() != target_count {
            return refuse(format!("it has {target_count} morph targets, not {}", weights.len()));
        }
        if let Some(joint) = joints.iter().position(|joint| !joint.is_finite()) {
            return refuse(format!("its joint {joint} has a number that is not finite"));
        }
        if let Some(target) = weights.iter().position(|weight| !weight.is_finite()) {
            return refuse(format!("the weight of its target {target} is not finite"));
        }
        if state.joints == joints && state.weights == weights {
            return Ok(None);
        }
        match state.pose_bounds.bounds(joints, weights) {
            Some(bounds) => Ok(Some(bounds)),
            None => refuse("it takes the mesh beyond all that can be drawn".to_owned()),
        }
    }

    /// Sets a possible pose, in which the mesh has this box.
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
        if !std::mem::replace(&mut state.is_dirty, true) {
            self.dirty.push(number);
        }
    }

    /// Records the upload of the newest poses of the skinned meshes that `is_seen` accepts, before
    /// anything of `frame` reads vertices. They stay dirty until the frame was
    /// [submitted](SkinnedMeshes::submitted), which may never happen.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn upload(
        &mut self,
        frame: &mut Frame<'_>,
        pass: &SkinningPass,
        target: SkinnedVertices,
        is_seen: impl Fn(&State) -> bool,
    ) -> Result<Skinned, Error> {
        self.uploaded.clear();
        let Self { all, dirty, uploaded, .. } = self;
        uploaded.extend(dirty.iter().filter(|number| all.get(**number).is_some_and(&is_seen)));
        if self.uploaded.is_empty() {
            return Ok(Skinned::default());
        }
        self.values.clear();
        let mut skinned = Skinned::default();
        for number in &self.uploaded {
            if let Some(state) = self.all.get_mut(*number) {
                state.write(&mut self.values);
                skinned.poses += 1;
                skinned.vertices += u64::from(state.rest.vertex_count);
            }
        }
        let poses = frame.uploads().push(&self.values)?;
        let SkinnedVertices { vertices, surfaces } = target;
        let io = SkinningIo { vertices, surfaces, mesh_data: self.mesh_data.whole(), poses };
        let poses = self.uploaded.iter().filter_map(|number| Some(self.all.get(*number)?.pose));
        pass.record(frame.commands(), &io, poses);
        Ok(skinned)
    }

    /// Notes that the frame of the last [`SkinnedMeshes::upload`] was submitted.
    pub(crate) fn submitted(&mut self) {
        for number in self.uploaded.drain(..) {
            if let Some(state) = self.all.get_mut(number) {
                (state.is_dirty, state.shown_bounds) = (false, state.bounds);
            }
        }
        let all = &self.all;
        self.dirty.retain(|number| all.get(*number).is_some_and(|state| state.is_dirty));
    }
}

impl State {
    /// Appends the data of a skinned mesh to the values of all.
    fn new(
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
            pose: rest,
        }
    }

    /// Appends its pose to those of a frame.
    fn write(&mut self, values: &mut Vec<u32>) {
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

/// Returns the number of values of the skinned meshes of a scene, and of the poses of all.
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

/// Returns the meshes of a scene in the order of their vertices: skinned ones first: they are one
/// part of the buffers, which a storage buffer can be.
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
