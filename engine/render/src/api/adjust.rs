//! Changes between two frames of a loop: the size of the image, the number of frames in flight,
//! the shaders. The scene and the history of views stay, and nothing waits for the GPU.

use gpu::{FrameRing, Target};
use occlusion::{ComputeTest, Method, MethodScene, ShaderSet};

use crate::debug::debug_overlay::DebugRenderer;
use crate::error::Error;
use crate::frame_passes::DepthFirst;
use crate::passes::{CountPass, DeformPass, OpaquePass, OverlayPass};
use crate::renderer::{MAX_FRAMES_IN_FLIGHT, Renderer};
use crate::shading::depth_first::Shading;
use crate::shading::surfaces::SurfaceResources;
use crate::shading::transparent::Transparent;

impl Renderer {
    /// Draws images of `size` pixels from now on. A view from above that does not fit into them
    /// is no longer shown.
    ///
    /// # Errors
    /// A size of 0, beyond the device's limits, or too large for a test that smaller images have;
    /// no memory. Nothing has changed then.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<(), Error> {
        if size == self.size() {
            return Ok(());
        }
        // Views plan with what the device could do when they were made.
        if ComputeTest::check(&self.device, self.size()).is_ok() {
            ComputeTest::check(&self.device, size)?;
        }
        self.passes.target = Target::new(&self.device, size, "target")?;
        // These are made again by the next frame that needs them.
        self.executor.passes.compute_test = None;
        self.methods.iter_mut().for_each(|method| method.resized());
        if let Some(explainer) = &mut self.explainer {
            let area = explainer.explanation.top_down;
            let fits = area.filter(|area| area.fits(size));
            explainer.explanation.top_down = fits;
        }
        Ok(())
    }

    /// Returns the number of frames that may be in flight at once.
    pub fn frames_in_flight(&self) -> usize {
        self.frames.frames_in_flight()
    }

    /// Changes the number of frames that may be in flight at once; 0 counts as 1. Results and times
    /// that are still on their way are lost, which costs some tests and no pixel.
    ///
    /// # Errors
    /// More than [`MAX_FRAMES_IN_FLIGHT`]; a failed call. Nothing has changed then.
    pub fn set_frames_in_flight(&mut self, frames_in_flight: usize) -> Result<(), Error> {
        if frames_in_flight > MAX_FRAMES_IN_FLIGHT {
            return Err(Error::FramesInFlight {
                wanted: frames_in_flight,
                most: MAX_FRAMES_IN_FLIGHT,
            });
        }
        let slots = frames_in_flight.max(1);
        if slots == self.frames_in_flight() {
            return Ok(());
        }
        let mut frames = FrameRing::new(&self.device, slots)?;
        if let Some(interval) = self.frames.timed_interval() {
            frames.time_passes_of_one_in(interval)?;
        }
        if self.learns {
            frames.time_frames()?;
        }
        self.frames = frames;
        self.pass_times.clear();
        self.executor.leaves.set_frames_in_flight(slots);
        Ok(())
    }

    /// Measures the GPU time of every pass from now on; [`Renderer::pass_times`] returns it.
    ///
    /// # Errors
    /// A device without timestamps.
    pub fn time_passes(&mut self) -> Result<(), Error> {
        self.time_passes_of_one_in(1)
    }

    /// Measures the GPU time of the passes of one in `frames` frames from now on, 0 counting as 1.
    /// On a software driver a frame with timestamps takes a tenth longer, which few such frames
    /// hide.
    ///
    /// # Errors
    /// A device without timestamps.
    pub fn time_passes_of_one_in(&mut self, frames: u64) -> Result<(), Error> {
        Ok(self.frames.time_passes_of_one_in(frames)?)
    }

    /// Returns the interval of the frames in which the GPU time of passes is measured; `None`
    /// without any.
    pub fn timed_interval(&self) -> Option<u64> {
        self.frames.timed_interval()
    }

    /// Stops measuring the GPU time of passes.
    pub fn stop_timing_passes(&mut self) {
        self.frames.stop_timing_passes();
        self.pass_times.clear();
    }

    /// Draws with other shaders from now on.
    ///
    /// # Errors
    /// A shader that does not fit its pass, a failed call. Nothing has changed then.
    pub fn reload(&mut self, shaders: ShaderSet) -> Result<(), Error> {
        let (device, size) = (&self.device, self.size());
        let surfaces = self.passes.geometry.surfaces.as_ref();
        let has_sprites = surfaces.is_some_and(SurfaceResources::has_sprites);
        let shaders = if has_sprites { shaders.with_sprites() } else { shaders };
        let opaque = OpaquePass::new(device, &shaders)?;
        let executing = self.executor.passes.reloaded(device, &shaders, size)?;
        let depth_first = self.passes.depth_first.as_ref();
        let depth_first = again(depth_first, || DepthFirst::new(device, &shaders))?;
        let counts = again(self.passes.counts.as_ref(), || CountPass::new(device, &shaders))?;
        let top_down = again(self.top_down.as_ref(), || OverlayPass::new(device, &shaders))?;
        let deforming =
            self.passes.skinned_meshes.as_ref().map(|skinned_meshes| &skinned_meshes.pass);
        let deforming = again(deforming, || DeformPass::new(device, &shaders))?;
        let shading = surfaces.map(|surfaces| Shading::new(device, &shaders, surfaces));
        let shading = shading.transpose()?;
        let blending = match (surfaces, &self.passes.transparent) {
            (Some(surfaces), Some(_)) => Some(Transparent::pass(device, &shaders, surfaces)?),
            _ => None,
        };
        let explanation = self.explanation();
        let explainer =
            again(self.explainer.as_ref(), || DebugRenderer::new(device, &shaders, explanation))?;
        let methods = self.reloaded_methods(&shaders)?;
        if let Some(overlay) = &mut self.flat_overlay {
            overlay.reload(&shaders)?;
        }
        let passes = &mut self.passes;
        (passes.opaque, passes.depth_first, passes.counts) = (opaque, depth_first, counts);
        (self.executor.passes, self.methods, self.top_down) = (executing, methods, top_down);
        (passes.shading, self.explainer) = (shading, explainer);
        if let (Some(transparent), Some(pass)) = (&mut passes.transparent, blending) {
            transparent.pass = pass;
        }
        if let (Some(skinned_meshes), Some(pass)) = (&mut passes.skinned_meshes, deforming) {
            skinned_meshes.pass = pass;
        }
        // Made again when it is next wanted.
        self.seen_leaves = None;
        self.shaders = shaders;
        Ok(())
    }
}

impl Renderer {
    fn reloaded_methods(&mut self, shaders: &ShaderSet) -> Result<Vec<Box<dyn Method>>, Error> {
        let Self { device, hierarchy, passes, executor, methods, .. } = self;
        let mut scene = MethodScene { device, shaders, hierarchy, executor, objects: passes };
        let reloaded = methods.iter().map(|method| method.reloaded(&mut scene));
        Ok(reloaded.collect::<Result<_, _>>()?)
    }
}

/// Makes an object again if it exists.
fn again<T, E>(there: Option<&T>, make: impl FnOnce() -> Result<T, E>) -> Result<Option<T>, E> {
    there.map(|_| make()).transpose()
}
