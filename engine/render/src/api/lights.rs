//! Lights that are added, changed and removed between frames.

use std::mem::discriminant;

use scene::{Light, LightId, LightKind, PunctualLight};

use crate::error::Error;
use crate::renderer::Renderer;
use crate::shading::surfaces::SurfaceResources;
use crate::update_errors::LightError;

impl Renderer {
    /// Replaces the light of a scene without surfaces: sun, ambient light and colour of the sky.
    /// The next frame shows it.
    pub fn set_scene_light(&mut self, light: Light) {
        self.passes.gpu_scene.light = light;
    }

    /// Adds lights to a scene with surfaces, and returns their ids in the same order. The next
    /// frame shows them; nothing waits. They take the room of removed lights and of
    /// [`RendererOptions::spare`](crate::RendererOptions::spare), so an id may have belonged to a
    /// light that was removed. Each light costs as much as a call of [`Renderer::set_light`].
    ///
    /// The picture of a spot light may be a texture that was [added](Renderer::add_textures): the
    /// parts that have arrived are shown.
    ///
    /// Directional lights are summed in the order in which they were added, but a new renderer sums
    /// them from the strongest on: the last bits of colours may differ between the two.
    ///
    /// # Errors
    /// [`Error::CapacityExceeded`] if there is not enough room for lights of a kind, or no surface
    /// that they could light; [`Error::LightCookie`]. Nothing has changed then. There is room for
    /// spot lights if the scene began with some, or with any
    /// [`SpareCapacity::lights`](crate::SpareCapacity::lights), since pipelines are compiled for
    /// them.
    pub fn add_lights(&mut self, lights: &[PunctualLight]) -> Result<Vec<LightId>, Error> {
        let surfaces = self.passes.gpu_scene.geometry.surfaces.as_mut();
        let left = |kind| surfaces.as_ref().map_or(0, |surfaces| surfaces.light_room(kind));
        let (suns, spots, points) = count_kinds(lights);
        let spot = LightKind::Spot { inner_rad: 0.0, outer_rad: 0.0 };
        for (what, wanted, left) in [
            ("directional lights", suns, left(LightKind::Directional)),
            ("spot lights", spots, left(spot)),
            ("point and spot lights", points + spots, left(LightKind::Point)),
        ] {
            if wanted > left {
                return Err(Error::CapacityExceeded {
                    what,
                    wanted: wanted as u64,
                    left: left as u64,
                });
            }
        }
        let Some(surfaces) = surfaces else { return Ok(Vec::new()) };
        for (index, light) in lights.iter().enumerate() {
            let checked = surfaces.check_cookie(light);
            checked.map_err(|reason| Error::LightCookie { index, reason })?;
        }
        let add = |light: &PunctualLight| surfaces.add_light(self.scene.hierarchy(), *light);
        Ok(lights.iter().filter_map(add).collect())
    }

    /// Removes lights. The next frame is without them; frames in flight still have them. Their ids
    /// may be reused for [lights that are added](Renderer::add_lights). If a sun of the scene is
    /// dark because there are too many ([`SceneDegradations::dark_suns`]), it stays dark when
    /// another sun is removed.
    ///
    /// # Errors
    /// [`Error::Light`] for the first light that does not exist. The lights before it are removed.
    ///
    /// [`SceneDegradations::dark_suns`]: crate::SceneDegradations::dark_suns
    pub fn remove_lights(&mut self, lights: &[LightId]) -> Result<(), Error> {
        for light in lights {
            lit_surfaces(&mut self.passes.gpu_scene.geometry.surfaces, *light)?
                .remove_light(self.scene.hierarchy(), *light);
        }
        Ok(())
    }

    /// Replaces a light of a scene with surfaces by a moved or changed one. The next frame shows
    /// it. The cost grows with the number of objects around its old and its new place, not with the
    /// scene. These objects look up their lights once per frame, for any number of changed lights.
    ///
    /// # Errors
    /// [`Error::Light`] for a light that is not in the scene; for another kind of light (remove the
    /// light and add another); and for a picture that does not exist or that pipelines are not
    /// compiled for. They are compiled for pictures if the scene began with a light that has one.
    pub fn set_light(&mut self, light: LightId, to: PunctualLight) -> Result<(), Error> {
        let surfaces = lit_surfaces(&mut self.passes.gpu_scene.geometry.surfaces, light)?;
        let before = surfaces.table.get(light).map(|before| discriminant(&before.kind));
        if before != Some(discriminant(&to.kind)) {
            return Err(Error::Light { light, reason: LightError::OtherKind });
        }
        let checked = surfaces.check_cookie(&to);
        checked.map_err(|fault| Error::Light { light, reason: LightError::Cookie { fault } })?;
        surfaces.replace_light(self.scene.hierarchy(), light, to);
        Ok(())
    }
}

/// Returns the surfaces of a scene if it contains the light.
fn lit_surfaces(
    surfaces: &mut Option<SurfaceResources>,
    light: LightId,
) -> Result<&mut SurfaceResources, Error> {
    let refused = |reason| Error::Light { light, reason };
    let surfaces = surfaces.as_mut();
    let surfaces = surfaces.ok_or(refused(LightError::NoSurfaces))?;
    surfaces.table.get(light).ok_or(refused(LightError::UnknownLight))?;
    Ok(surfaces)
}

/// Counts directional, spot and point lights.
fn count_kinds(lights: &[PunctualLight]) -> (usize, usize, usize) {
    lights.iter().fold((0, 0, 0), |(suns, spots, points), light| match light.kind {
        LightKind::Directional => (suns + 1, spots, points),
        LightKind::Spot { .. } => (suns, spots + 1, points),
        LightKind::Point => (suns, spots, points + 1),
    })
}
