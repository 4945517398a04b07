//! Poses of skinned meshes, and the boxes that follow from them.

use crate::gpu_scene::GpuScene;
use glam::Affine3A;
use scene::{PoseUpdate, SceneUpdate, SkinnedMeshId};

use crate::error::Error;
use crate::renderer::Renderer;
use crate::resources::geometry::bounds_in_world;
use crate::resources::skinned_mesh_state::SkinnedMeshState;
use crate::update::UpdateScratch;
use crate::update_errors::PoseError;

/// The new pose of a skinned mesh.
#[derive(Clone, Copy)]
struct PoseRef<'a> {
    skinned_mesh: SkinnedMeshId,
    joints: &'a [Affine3A],
    weights: &'a [f32],
}

impl Renderer {
    /// Sets the pose of a skinned mesh. The next frame shows it; frames in flight do not. Each
    /// joint transforms points of the mesh at rest to the object's own space; `weights` has the
    /// weight of each morph target, with any sum. Repeating a pose costs nothing, and neither do
    /// targets of weight 0.
    ///
    /// The box of the object follows from the pose ([`scene::PoseBounds`]). The GPU computes the
    /// vertices in the first frame with a view in which the mesh may be visible.
    ///
    /// # Errors
    /// [`Error::Pose`] for a skinned mesh that does not exist, a wrong number of joints or targets,
    /// and values that are not finite or that move the mesh beyond the possible coordinates.
    /// Nothing has changed then.
    pub fn set_pose(
        &mut self,
        skinned_mesh: SkinnedMeshId,
        joints: &[Affine3A],
        weights: &[f32],
    ) -> Result<(), Error> {
        self.set_each([PoseRef { skinned_mesh, joints, weights }]).map(drop)
    }

    /// Sets the poses of an update, in their order. Returns the number of poses that changed. After
    /// the first impossible pose, the poses before it are set.
    pub(crate) fn set_poses(&mut self, update: &SceneUpdate) -> Result<u32, Error> {
        self.set_each(update.poses.iter().map(|PoseUpdate { skinned_mesh, joints, weights }| {
            let joints = update.joints.get(joints.clone()).unwrap_or_default();
            let weights = update.weights.get(weights.clone()).unwrap_or_default();
            PoseRef { skinned_mesh: *skinned_mesh, joints, weights }
        }))
    }

    fn set_each<'a>(&mut self, poses: impl IntoIterator<Item = PoseRef<'a>>) -> Result<u32, Error> {
        let mut scratch = std::mem::take(&mut self.update_scratch);
        let mut count = 0;
        let set = poses.into_iter().try_for_each(|pose| {
            let is_other = self.set_one(pose, &mut scratch)?;
            count += u32::from(is_other);
            Ok(())
        });
        let settled = if count > 0 { self.settle(&mut scratch) } else { Ok(()) };
        self.update_scratch = scratch;
        set.and(settled.map_err(Error::from)).map(|()| count)
    }

    /// Sets a pose. Returns true if it changed.
    fn set_one(
        &mut self,
        PoseRef { skinned_mesh, joints, weights }: PoseRef<'_>,
        scratch: &mut UpdateScratch,
    ) -> Result<bool, Error> {
        let refuse = |reason| Error::Pose { skinned_mesh, reason };
        let none = || refuse(PoseError::UnknownSkinnedMesh);
        let GpuScene { skinned_meshes, geometry, transparent, .. } = &mut self.passes.gpu_scene;
        let skinned_meshes = skinned_meshes.as_mut().ok_or_else(none)?;
        let Some(bounds) = skinned_meshes.bounds_in(skinned_mesh, joints, weights)? else {
            return Ok(false);
        };
        let SkinnedMeshState { mesh, transparent: id, .. } =
            *skinned_meshes.get(skinned_mesh).ok_or_else(none)?;
        let object = geometry.owner(mesh);
        let transform = match id {
            Some(id) => transparent.as_ref().and_then(|transparent| transparent.transform(id)),
            None => object.and_then(|object| geometry.transform(object)),
        };
        let transform = transform.unwrap_or(Affine3A::IDENTITY);
        let in_world = bounds_in_world(&bounds, &transform);
        let in_world = in_world.ok_or_else(|| refuse(PoseError::ObjectOutOfRange))?;
        skinned_meshes.set_pose(skinned_mesh, joints, weights, bounds);
        geometry.reshape(mesh, bounds);
        self.revision.advance();
        if let Some(id) = id {
            self.passes.gpu_scene.change_transparent(id, |object| {
                (object.own_bounds, object.bounds) = (bounds, in_world);
            })?;
        } else if let Some(object) = object {
            scratch.moves.push((object, in_world));
            scratch.changed.push(object);
        }
        Ok(true)
    }
}
