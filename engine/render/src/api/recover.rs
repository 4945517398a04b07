//! Recovery from the loss of the device: everything on the GPU is created again on another device.

use std::sync::Arc;

use ::shadows::ShadowOptions;
use gpu::{CancellationToken, Device, FrameRing, LossReport};
use occlusion::{ScenePartsMut, SectionShaders};
use scene::Scene;

use crate::error::Error;
use crate::kept_scene::KeptScene;
use crate::renderer::{Renderer, RendererOptions};

impl Renderer {
    /// Keeps `scene`, which the renderer was created from, and every mesh, texture and environment
    /// that is added from now on, so that [`Renderer::recover`] can upload them again. The memory
    /// is that of the scene, unless the caller holds it anyway, and of what is added; frames cost
    /// nothing more.
    ///
    /// # Errors
    /// [`Error::OtherScene`] for a scene with other meshes or objects than the renderer has, after
    /// the first change, and if the renderer keeps a scene already.
    pub fn keep_scene(&mut self, scene: Arc<Scene>) -> Result<(), Error> {
        let geometry = &self.passes.gpu_scene.geometry;
        let is_unchanged = self.revision.is_first() && !self.has_other_content;
        if self.kept.is_none() && is_unchanged && geometry.is_of(&scene) {
            self.kept = Some(Box::new(KeptScene::new(scene)));
            Ok(())
        } else {
            Err(Error::OtherScene)
        }
    }

    /// Returns true if the renderer can [recover](Renderer::recover) from the loss of its device.
    pub fn keeps_scene(&self) -> bool {
        self.kept.is_some()
    }

    /// Returns what is known about the loss of the device: the frames and their passes that it did
    /// not finish, and the driver's words. Meaningful after a call failed with
    /// [`gpu::Error::is_device_lost`].
    pub fn loss_report(&self) -> LossReport {
        self.frames.loss_report()
    }

    /// Continues on another device, after the present one was lost
    /// ([`gpu::Error::is_device_lost`]). The renderer has the same scene, ids and options as
    /// before, and the next image shows all of it: whatever was still being uploaded is there. Ids
    /// that are added later may be others than without the loss.
    ///
    /// Views and their watched objects stay valid. A view begins without history in its next
    /// frame, and no answer of the lost device is read. Visible sets must be found again. What the
    /// caller made on the lost device itself ([`gpu::Readback`], a swapchain, an overlay) must be
    /// made again.
    ///
    /// ```no_run
    /// # use std::sync::Arc;
    /// # use antumbra_render::{self as render, Renderer};
    /// # type Failure = Box<dyn std::error::Error>;
    /// # fn run(scene: scene::Scene, camera: cull::Camera) -> Result<(), Failure> {
    /// # let device = gpu::open()?;
    /// let scene = Arc::new(scene);
    /// let mut renderer = Renderer::new(&device, &scene, &Default::default())?;
    /// renderer.keep_scene(Arc::clone(&scene))?; // before the first change
    /// let mut view = renderer.new_view()?;
    /// // Each frame:
    /// match renderer.render(&mut view, camera) {
    ///     Ok(_) => {}
    ///     Err(render::Error::Gpu(error)) if error.is_device_lost() => {
    ///         eprintln!("{error}; {}", renderer.loss_report());
    ///         // Changes nothing if it fails, and can be repeated.
    ///         renderer.recover(&gpu::open()?)?;
    ///     }
    ///     Err(error) => return Err(error.into()),
    /// }
    /// # Ok(()) }
    /// ```
    ///
    /// It takes as long as [`Renderer::new`], and waits for copies. The old device is closed once
    /// everything else that was made on it is dropped, too.
    ///
    /// # Errors
    /// [`Error::SceneNotKept`]; the errors of [`Renderer::new`], also because the device is smaller
    /// or lacks something that the former one had; another lost device. Nothing has changed then,
    /// and the call can be repeated.
    pub fn recover(&mut self, device: &Device) -> Result<(), Error> {
        let kept = self.kept.as_deref().ok_or(Error::SceneNotKept)?;
        let surfaces = self.passes.gpu_scene.geometry.surfaces.as_ref();
        let leaves = self.scene.hierarchy().leaf_objects().len();
        let options = RendererOptions {
            size: self.size(),
            frames_in_flight: self.frames_in_flight(),
            shadows: ShadowOptions::default(),
            // The places of textures fit only this storage.
            textures: surfaces.map(|surfaces| surfaces.textures.storage()),
            // Free leaves are room for objects, too.
            spare_objects: leaves.saturating_sub(kept.scene.objects.len()),
            // A complete renderer ignores the cancellation of its creation.
            cancellation: CancellationToken::default(),
            // Section planes are set later, as all that is compiled on demand.
            shaders: Some(self.shaders.clone().with_section(SectionShaders::Whole)),
            ..self.options.clone()
        };
        let mut new = Self::new(device, &kept.scene, &options)?;
        new.options = self.options.clone();
        new.id = self.id;
        new.generation = self.generation.next();
        new.restore_scene(self, kept)?;
        new.restore_settings(self, kept)?;
        new.revision = self.revision;
        // What was being uploaded is visible now.
        new.revision.advance();
        new.has_other_content = self.has_other_content;
        new.kept = self.kept.take();
        *self = new;
        Ok(())
    }

    /// Brings the scene into the state that it has in `lost`, and uploads it.
    fn restore_scene(&mut self, lost: &Self, kept: &KeptScene) -> Result<(), Error> {
        let ScenePartsMut { hierarchy, leaves, .. } = self.scene.parts_mut();
        hierarchy.clone_from(lost.scene.hierarchy());
        let gpu_scene = &mut self.passes.gpu_scene;
        gpu_scene.restore(&lost.passes.gpu_scene, kept, hierarchy, leaves)?;
        // A ring of its own, since a slot keeps as much memory as its largest frame took.
        let mut ring = FrameRing::new(&self.device, 1)?;
        let mut frame = ring.begin()?;
        gpu_scene.geometry.uploads.set_frame_bytes(usize::MAX);
        gpu_scene.geometry.upload_changes(&mut frame, &mut self.scene)?;
        gpu_scene.geometry.uploads.set_frame_bytes(self.options.upload_bytes_per_frame);
        let tick = frame.submit(None)?;
        gpu_scene.geometry.submitted();
        self.scene.submitted(tick);
        self.show_arrived();
        Ok(())
    }

    /// Makes the settings that `lost` got after its creation.
    fn restore_settings(&mut self, lost: &Self, kept: &KeptScene) -> Result<(), Error> {
        if let Some(environment) = &kept.environment {
            self.set_environment(environment.as_ref())?;
        }
        self.set_section(*lost.section())?;
        self.set_shadows(*lost.shadows())?;
        self.passes.shadows.own.clone_from(&lost.passes.shadows.own);
        self.set_edges(*lost.edges())?;
        self.set_outlined(lost.outlined())?;
        self.set_flares(lost.flares())?;
        self.set_debug_overlay(lost.debug_overlay())?;
        if lost.outlined.is_some() {
            self.outline(lost.outlined)?;
        }
        if let Some(interval) = lost.timed_interval() {
            self.time_passes_of_one_in(interval)?;
        }
        Ok(())
    }
}
