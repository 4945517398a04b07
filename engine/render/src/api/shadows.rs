//! The shadows of lights: the options of all, and the shadows of single lights.

use ::shadows::{ShadowMethod, ShadowOptions, ShadowStats};
use scene::LightId;

use crate::error::Error;
use crate::renderer::Renderer;
use crate::resources::volume_meshes::VolumeMeshes;
use crate::shadows::{LightShadow, Shadows, can_skip, caster_executor, usable_shadows};
use crate::update_errors::LightError;

impl Renderer {
    /// Returns the options of shadows.
    pub fn shadows(&self) -> &ShadowOptions {
        &self.passes.shadows.options
    }

    /// Returns the counts of the shadows of the newest frame.
    pub fn shadow_stats(&self) -> ShadowStats {
        self.passes.shadows.stats()
    }

    /// Draws shadows by other options from now on. The options of [single
    /// lights](Renderer::set_light_shadow) stay. New options compile passes and create maps; for
    /// volumes they also build the adjacency of all meshes and wait for copies. Do not change them
    /// in every frame. Casters are not culled on a driver whose flags, or all of whose executors,
    /// are [distrusted](crate::RendererOptions::disabled).
    ///
    /// # Errors
    /// [`Error::Shadows`]; [`Error::NoSurfacesForShadows`]; [`Error::MultisampledVolumes`]; maps or
    /// meshes beyond the device's limits, volumes on a device that lacks something for them, no
    /// memory, a failed call. Nothing has changed then.
    pub fn set_shadows(&mut self, options: ShadowOptions) -> Result<(), Error> {
        let can = |predication| can_skip(&self.device, predication);
        let quirks = self.scene.passes().quirks();
        let options = usable_shadows(quirks, options, can);
        if options == self.passes.shadows.options {
            return Ok(());
        }
        let has_surfaces = self.passes.gpu_scene.geometry.surfaces.is_some();
        let frames_in_flight = self.frames_in_flight();
        let mut shadows = Shadows::new(
            &self.device,
            options,
            &self.passes.target,
            has_surfaces,
            frames_in_flight,
        )?;
        if let Some(executor) = caster_executor(quirks, self.predication(), can) {
            shadows.skip_by(executor, self.frames_in_flight())?;
        }
        let pipelines = self.passes.recompiled(&self.shaders, &shadows)?;
        let passes = &mut self.passes;
        let is_by_volumes = options.method == ShadowMethod::Volumes;
        let is_new = is_by_volumes && passes.gpu_scene.geometry.volumes.is_none();
        let new = || {
            VolumeMeshes::new(
                &self.device,
                &passes.gpu_scene.geometry,
                passes.gpu_scene.skinned_meshes.as_ref(),
            )
        };
        let volumes = is_new.then(new).transpose()?;
        // Nothing can fail from here on.
        if is_new || !is_by_volumes {
            passes.gpu_scene.geometry.replace_volumes(volumes);
        }
        passes.pipelines = pipelines;
        shadows.own = std::mem::take(&mut passes.shadows.own);
        passes.shadows = shadows;
        Ok(())
    }

    /// Sets the shadow of one light; `None` restores the shadow that the options of all lights say.
    /// The setting stays with the id: a light that is [added](Renderer::add_lights) later with this
    /// id has it.
    ///
    /// # Errors
    /// [`Error::Light`] for a light that does not exist, and for a width that is negative or NaN.
    pub fn set_light_shadow(
        &mut self,
        light: LightId,
        shadow: Option<LightShadow>,
    ) -> Result<(), Error> {
        let refused = |reason| Error::Light { light, reason };
        let surfaces = self.passes.gpu_scene.geometry.surfaces.as_ref();
        let there = surfaces.and_then(|surfaces| surfaces.table.get(light));
        there.ok_or(refused(LightError::UnknownLight))?;
        if shadow.is_some_and(|shadow| !(0.0..1.0e3).contains(&shadow.penumbra_m)) {
            return Err(refused(LightError::PenumbraWidth));
        }
        let own = &mut self.passes.shadows.own;
        match shadow {
            Some(shadow) => own.insert(light, shadow),
            None => own.remove(&light),
        };
        Ok(())
    }
}
