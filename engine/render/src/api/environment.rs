//! The light of an environment, and the exposure.

use scene::Environment;

use crate::error::Error;
use crate::renderer::Renderer;
use crate::shading::environment_texture::EnvironmentTexture;

impl Renderer {
    /// Lights the surfaces by an environment from now on, which is also the sky; `None` restores
    /// the [ambient light](scene::Light). Waits for a copy. Compiles passes if there was no
    /// environment before or there is none now. Do not call it in every frame.
    ///
    /// # Errors
    /// [`Error::NoSurfacesForEnvironment`]; no memory, a failed call. Nothing has changed then.
    pub fn set_environment(&mut self, environment: Option<&Environment>) -> Result<(), Error> {
        let texture = EnvironmentTexture::new(&self.device, environment)?;
        let surfaces = self.passes.gpu_scene.geometry.surfaces.as_mut();
        let surfaces = surfaces.ok_or(Error::NoSurfacesForEnvironment)?;
        let before = std::mem::replace(&mut surfaces.environment, texture);
        if before.is_there() != environment.is_some() {
            match self.passes.recompiled(&self.shaders, &self.passes.shadows) {
                Ok(pipelines) => self.passes.pipelines = pipelines,
                Err(error) => {
                    if let Some(surfaces) = &mut self.passes.gpu_scene.geometry.surfaces {
                        surfaces.environment = before;
                    }
                    return Err(error.into());
                }
            }
        }
        self.has_other_content = true;
        if let Some(kept) = &mut self.kept {
            kept.environment = Some(environment.cloned());
        }
        Ok(())
    }

    /// Sets the factor on all light before tone mapping, at least 0; a number that is not finite
    /// counts as 1. Does nothing in scenes without surfaces.
    pub fn set_exposure(&mut self, exposure: f32) {
        if let Some(surfaces) = &mut self.passes.gpu_scene.geometry.surfaces {
            surfaces.exposure = if exposure.is_finite() { exposure.max(0.0) } else { 1.0 };
        }
    }
}
