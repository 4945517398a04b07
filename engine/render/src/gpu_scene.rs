//! The contents of a scene on the GPU, which its passes draw and shade with.

use ::shadows::ShadowMethod;
use cull::{CullView, Hierarchy, Strategy};
use gpu::{Device, Frame};
use occlusion::{CulledScene, LeafTable};
use scene::{Light, Scene, TransparentId};

use crate::error::Error;
use crate::kept_scene::KeptScene;
use crate::resources::geometry::Geometry;
use crate::resources::scene_memory::SceneMemory;
use crate::resources::skinned_meshes::{Skinned, SkinnedMeshes};
use crate::resources::volume_meshes::VolumeMeshes;
use crate::shading::fragments::Fragments;
use crate::shading::surfaces::SurfaceOptions;
use crate::shading::transparent::{Transparent, TransparentObject};

/// The contents of a scene on the GPU.
pub(crate) struct GpuScene {
    /// Meshes and instances, with materials, textures and lights where the scene has surfaces.
    pub(crate) geometry: Geometry,
    /// The light of scenes without surfaces, and the sky.
    pub(crate) light: Light,
    /// The skinned meshes, if there are any.
    pub(crate) skinned_meshes: Option<SkinnedMeshes>,
    /// The transparent objects, if there are any.
    pub(crate) transparent: Option<Transparent>,
}

/// The options of the upload of a scene.
#[derive(Clone, Copy)]
pub(crate) struct GpuSceneOptions<'a> {
    pub(crate) frames_in_flight: usize,
    pub(crate) samples: gpu::vk::SampleCountFlags,
    pub(crate) surfaces: &'a SurfaceOptions,
    /// The number of bytes of meshes and textures that a frame uploads.
    pub(crate) upload_bytes_per_frame: usize,
    pub(crate) shadows: ShadowMethod,
}

impl GpuScene {
    /// Uploads a scene, with a hierarchy over its objects. If memory is short, its textures become
    /// smaller.
    pub(crate) fn upload(
        device: &Device,
        scene: &Scene,
        hierarchy: &Hierarchy,
        options: &GpuSceneOptions<'_>,
    ) -> Result<Self, Error> {
        let leaves = hierarchy.leaf_objects().len();
        let mut memory = SceneMemory::plan(device, scene, leaves, options.surfaces);
        loop {
            let surfaces = memory.surface_options();
            let options = GpuSceneOptions { surfaces: &surfaces, ..*options };
            match Self::upload_as_planned(device, scene, hierarchy, &options) {
                Err(Error::Gpu(error)) if error.is_out_of_memory() => memory.reduce(error)?,
                Err(error) => return Err(error),
                Ok(uploaded) => {
                    memory.report();
                    return Ok(uploaded);
                }
            }
        }
    }

    fn upload_as_planned(
        device: &Device,
        scene: &Scene,
        hierarchy: &Hierarchy,
        options: &GpuSceneOptions<'_>,
    ) -> Result<Self, Error> {
        let GpuSceneOptions { frames_in_flight, samples, surfaces, .. } = *options;
        let upload_bytes = options.upload_bytes_per_frame;
        let mut geometry = Geometry::upload(device, scene, hierarchy, surfaces, upload_bytes)?;
        let cancellation = &surfaces.cancellation;
        cancellation.check()?;
        let fragments = Fragments::new(device, surfaces.transparency, samples, frames_in_flight);
        let transparent = Transparent::new(device, scene, fragments)?;
        let first_vertex = |mesh| geometry.first_vertex(mesh);
        let skinned_meshes = SkinnedMeshes::new(device, scene, frames_in_flight, first_vertex)?;
        if options.shadows == ShadowMethod::Volumes {
            geometry.volumes = Some(VolumeMeshes::new(device, &geometry, skinned_meshes.as_ref())?);
        }
        cancellation.check()?;
        Ok(Self { geometry, light: scene.light, skinned_meshes, transparent })
    }

    /// Brings a scene that was uploaded as the kept one began into the state that it has in `lost`.
    /// The next upload of changes completes it.
    pub(crate) fn restore(
        &mut self,
        lost: &Self,
        kept: &KeptScene,
        hierarchy: &Hierarchy,
        leaves: &mut LeafTable,
    ) -> Result<(), Error> {
        self.light = lost.light;
        if let (Some(transparent), Some(lost)) = (&mut self.transparent, &lost.transparent) {
            transparent.restore(lost);
        }
        if let (Some(skinned), Some(lost)) = (&mut self.skinned_meshes, &lost.skinned_meshes) {
            skinned.restore(lost);
        }
        self.geometry.restore(&lost.geometry, kept, hierarchy, leaves)
    }

    /// Returns the fragments of transparent objects, if fragments are sorted.
    pub(crate) fn fragments(&self) -> Option<&Fragments> {
        self.transparent.as_ref()?.fragments.as_ref()
    }

    /// Returns the fragments of transparent objects for changes, if fragments are sorted.
    pub(crate) fn fragments_mut(&mut self) -> Option<&mut Fragments> {
        self.transparent.as_mut()?.fragments.as_mut()
    }

    /// Gathers the transparent objects of a view, which its
    /// [shading](occlusion::ShadedObjects::shade) draws. Returns the number in its frustum.
    pub(crate) fn gather_transparent(
        &mut self,
        frame: &mut Frame<'_>,
        scene: &CulledScene,
        view: &CullView,
        strategy: Strategy,
    ) -> Result<u32, Error> {
        let Some(transparent) = &mut self.transparent else { return Ok(0) };
        transparent.gather(frame, &self.geometry, scene.passes(), view, strategy.culls_occluded())
    }

    /// Changes a transparent object, if it exists, and finds its lights again.
    pub(crate) fn change_transparent(
        &mut self,
        id: TransparentId,
        change: impl FnOnce(&mut TransparentObject),
    ) -> Result<(), Error> {
        let bounds =
            self.transparent.as_mut().and_then(|transparent| transparent.change(id, change));
        if let (Some(bounds), Some(surfaces)) = (bounds, &mut self.geometry.surfaces) {
            surfaces.move_transparent(id, &bounds)?;
        }
        Ok(())
    }

    /// Returns the work for skinned meshes in the newest recorded frame.
    pub(crate) fn skinned(&self) -> Skinned {
        self.skinned_meshes.as_ref().map(SkinnedMeshes::skinned).unwrap_or_default()
    }
}
