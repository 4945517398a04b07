//! Changes between two frames: the size of the image, the number of frames in flight, the shaders.
//! The scene and the history of views stay, and nothing waits for the GPU.

use gpu::{FrameRing, Target};
use occlusion::{Method, ShaderSet};

use crate::error::Error;
use crate::renderer::{MAX_FRAMES_IN_FLIGHT, Renderer};
use crate::shading::surfaces::SurfaceResources;

impl Renderer {
    /// Draws images of `size` pixels from now on. A view from above that does not fit into the new
    /// size is no longer shown.
    ///
    /// # Errors
    /// A size of 0, beyond the device's limits, or too large for a visibility test that the present
    /// size allows; no memory. Nothing has changed then.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<(), Error> {
        if size == self.size() {
            return Ok(());
        }
        self.scene.check_resize(self.size(), size)?;
        let create = if self.passes.target.has_stencil() {
            Target::with_stencil
        } else {
            Target::multisampled
        };
        let target = create(&self.device, size, self.options.samples, "target")?;
        if let Some(volumes) = &mut self.passes.pipelines.volumes {
            volumes.resize(&self.device, size)?;
        }
        self.passes.target = target;
        self.passes.edges.resized();
        // The next frame creates the objects of methods again.
        self.methods.iter_mut().for_each(|method| method.resized());
        let area = self.debug_overlay.top_down;
        self.debug_overlay.top_down = area.filter(|area| area.fits(size));
        Ok(())
    }

    /// Returns the number of frames that may be in flight at once.
    pub fn frames_in_flight(&self) -> usize {
        self.frames.frames_in_flight()
    }

    /// Changes the number of frames that may be in flight at once; 0 counts as 1. Results and times
    /// in flight are lost. This costs some additional tests, but images stay exact.
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
        self.frame_times.enable(&mut frames)?;
        self.frames = frames;
        self.pass_times.clear();
        self.scene.set_frames_in_flight(slots);
        self.passes.set_frames_in_flight(slots);
        Ok(())
    }

    /// Measures the GPU time of every pass from now on; [`Renderer::pass_times`] returns it.
    ///
    /// # Errors
    /// A device without timestamps.
    pub fn time_passes(&mut self) -> Result<(), Error> {
        self.time_passes_of_one_in(1)
    }

    /// Measures the GPU time of the passes in one of `frames` frames from now on; 0 counts as 1. On
    /// a software driver, a frame with timestamps takes a tenth longer, so measure few frames.
    ///
    /// # Errors
    /// A device without timestamps.
    pub fn time_passes_of_one_in(&mut self, frames: u64) -> Result<(), Error> {
        Ok(self.frames.time_passes_of_one_in(frames)?)
    }

    /// Returns the interval between frames in which the GPU time of passes is measured; `None` if
    /// it is not measured.
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
        let surfaces = self.passes.gpu_scene.geometry.surfaces.as_ref();
        let has_sprites = surfaces.is_some_and(SurfaceResources::has_sprites);
        let shaders = if has_sprites { shaders.with_sprites() } else { shaders };
        self.draw_with(shaders.with_section(self.shaders.section()))
    }
}

impl Renderer {
    /// Compiles all passes again with shaders that fit the scene, and for the target.
    pub(crate) fn draw_with(&mut self, shaders: ShaderSet) -> Result<(), Error> {
        let pipelines = self.passes.recompiled(&shaders, &self.passes.shadows)?;
        let attachments = self.passes.target.attachments();
        let executing = self.scene.passes().recompiled(&self.device, &shaders, attachments)?;
        let methods = self.reloaded_methods(&shaders)?;
        // Nothing can fail from here on.
        self.passes.pipelines = pipelines;
        *self.scene.parts_mut().passes = executing;
        self.methods = methods;
        self.shaders = shaders;
        self.passes.shadows.forget();
        Ok(())
    }

    fn reloaded_methods(&mut self, shaders: &ShaderSet) -> Result<Vec<Box<dyn Method>>, Error> {
        let Self { scene, passes, methods, .. } = self;
        let reloaded = methods.iter().map(|method| method.reloaded(scene, passes, shaders));
        Ok(reloaded.collect::<Result<_, _>>()?)
    }
}
