//! The poses of skinned meshes in a frame.

use cull::{Aabb, Containment, CullView, Hierarchy, PlaneMask};
use glam::Affine3A;
use gpu::{Frame, Tick};

use crate::error::Error;
use crate::gpu_scene::GpuScene;
use crate::resources::geometry::bounds_in_world;
use crate::resources::skinned_mesh_state::SkinnedMeshState;
use crate::resources::skinned_meshes::PoseUploads;
use crate::scene_renderer::SceneRenderer;

impl SceneRenderer {
    /// Uploads the poses of meshes that a view or a light may see, and writes their vertices.
    pub(crate) fn upload_poses(
        &mut self,
        frame: &mut Frame<'_>,
        hierarchy: &Hierarchy,
        uploads: PoseUploads<'_>,
    ) -> Result<(), Error> {
        let Self { device, gpu_scene, pipelines, shadows, .. } = self;
        let GpuScene { geometry, skinned_meshes, transparent, .. } = gpu_scene;
        let (Some(skinned_meshes), Some(pass), Some(vertices)) =
            (skinned_meshes, &pipelines.skinning, geometry.skinned())
        else {
            return Ok(());
        };
        let transform = |state: &SkinnedMeshState| match state.transparent {
            Some(id) => transparent.as_ref()?.transform(id),
            None => geometry.transform(geometry.owner(state.mesh)?),
        };
        let is_in = |views: &[CullView], bounds: &Aabb, transform: &Affine3A| {
            let Some(bounds) = bounds_in_world(bounds, transform) else { return true };
            let is_outside = |(containment, _)| containment == Containment::Outside;
            views.iter().any(|view| !is_outside(view.frustum.classify(&bounds, PlaneMask::ALL)))
        };
        // A light may see what no view sees.
        let casts = |state: &SkinnedMeshState| {
            let leaf = || hierarchy.leaf_of(geometry.owner(state.mesh)?);
            state.transparent.is_none() && leaf().is_some_and(|leaf| shadows.draw(leaf))
        };
        let is_seen = |state: &SkinnedMeshState| match (transform(state), uploads) {
            (None, _) => false,
            (Some(_), PoseUploads::All) => true,
            _ if casts(state) => true,
            (Some(transform), PoseUploads::Seen(views)) => [state.bounds, state.shown_bounds]
                .iter()
                .any(|bounds| is_in(views, bounds, &transform)),
        };
        let leaf_of = |state: &SkinnedMeshState| {
            let PoseUploads::Seen(views) = uploads else { return None };
            let can_be_tested = state.transparent.is_none()
                && !casts(state)
                && is_in(views, &state.bounds, &transform(state)?);
            can_be_tested.then(|| hierarchy.leaf_of(geometry.owner(state.mesh)?)).flatten()
        };
        let completed = device.completed()?;
        skinned_meshes.upload(frame, completed, pass, vertices, is_seen, leaf_of)
    }

    /// Writes the vertices that the last frames wrote only if a test passed. Call it before hidden
    /// objects are drawn.
    pub(crate) fn write_stale(&mut self, frame: &mut Frame<'_>) -> Result<(), Error> {
        let Self { device, gpu_scene, pipelines, .. } = self;
        let GpuScene { geometry, skinned_meshes, .. } = gpu_scene;
        let (Some(skinned_meshes), Some(pass), Some(vertices)) =
            (skinned_meshes, &pipelines.skinning, geometry.skinned())
        else {
            return Ok(());
        };
        let completed = device.completed()?;
        let is_stale = |state: &SkinnedMeshState| state.is_stale;
        skinned_meshes.upload(frame, completed, pass, vertices, is_stale, |_| None)
    }

    /// Notes that the frame of the last [`SceneRenderer::write_stale`] was submitted.
    pub(crate) fn stale_submitted(&mut self, tick: Tick) {
        if let Some(skinned_meshes) = &mut self.gpu_scene.skinned_meshes {
            skinned_meshes.submitted(tick);
        }
    }
}
