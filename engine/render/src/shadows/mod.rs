//! Shadows: the maps of lights, drawn before the views of a frame and kept from frame to frame; or
//! shadow volumes, counted against the depth of each view.

mod caster_culling;
mod culled_draws;
mod light_shadow;
mod map_images;
mod records;
mod shadow_maps;
mod tile_draws;
mod usable;
mod volume_shadows;

use std::collections::HashMap;

use ::shadows::{ShadowMethod, ShadowOptions, ShadowStats};
use cull::{Aabb, CullView, Hierarchy, LeafIndex};
use gpu::{
    Commands, Device, Frame, Predicates, PredicationMode, RenderTarget, SampleCount, Target, Tick,
};
use scene::LightId;

use crate::error::Error;
use crate::passes::pipelines::Pipelines;
use crate::resources::geometry::Geometry;
use crate::section::Section;
pub(crate) use caster_culling::can_skip;
use culled_draws::CastersInView;
pub use light_shadow::LightShadow;
pub use records::{ShadowIo, ShadowMapIo, ShadowMaskIo};
pub(crate) use shadow_maps::MapUses;
use shadow_maps::ShadowMaps;
pub(crate) use usable::{caster_executor, usable_shadows};
use volume_shadows::VolumeShadows;

/// The shadows of a renderer's lights.
pub(crate) struct Shadows {
    pub(crate) options: ShadowOptions,
    /// The shadows of lights that differ from what the options say.
    pub(crate) own: HashMap<LightId, LightShadow>,
    /// The maps, with the method that has some.
    maps: Option<ShadowMaps>,
    /// The volumes, with the method that has some.
    volumes: Option<VolumeShadows>,
}

impl Shadows {
    /// Creates the maps or volumes that the options ask for, for images in `target`.
    ///
    /// # Errors
    /// Impossible options, a scene without surfaces, volumes with several samples per pixel, no
    /// memory, a failed call.
    pub(crate) fn new(
        device: &Device,
        options: ShadowOptions,
        target: &Target,
        has_surfaces: bool,
        frames_in_flight: usize,
    ) -> Result<Self, Error> {
        options.check()?;
        if options.method != ShadowMethod::Off && !has_surfaces {
            return Err(Error::NoSurfacesForShadows);
        }
        let mut maps = None;
        let mut volumes = None;
        match options.method {
            ShadowMethod::Off => {}
            ShadowMethod::Maps => maps = Some(ShadowMaps::new(device, options, frames_in_flight)?),
            ShadowMethod::Volumes if target.attachments().samples != SampleCount::One.flags() => {
                return Err(Error::MultisampledVolumes);
            }
            ShadowMethod::Volumes => {
                volumes = Some(VolumeShadows::new(device, options, frames_in_flight)?)
            }
        }
        Ok(Self { options, own: HashMap::new(), maps, volumes })
    }

    /// Skips culled casters by the executor of the renderer, of so many frames in flight.
    ///
    /// # Errors
    /// No memory, a failed call.
    pub(crate) fn skip_by(
        &mut self,
        executor: PredicationMode,
        frames: usize,
    ) -> Result<(), Error> {
        self.maps.as_mut().map_or(Ok(()), |maps| maps.skip_by(executor, frames))?;
        self.volumes.as_mut().map_or(Ok(()), |volumes| volumes.skip_by(executor, frames))
    }

    /// Draws all maps again in the next frame: casters changed and their boxes did not.
    pub(crate) fn forget(&mut self) {
        if let Some(maps) = &mut self.maps {
            maps.forget();
        }
    }

    /// Plans the maps or the volumes for the views of a frame, which see `receivers` at most.
    ///
    /// # Errors
    /// A lost device.
    pub(crate) fn plan(
        &mut self,
        geometry: &Geometry,
        hierarchy: &Hierarchy,
        receivers: Aabb,
        views: &[CullView],
        uses: MapUses,
    ) -> Result<(), Error> {
        let Some(surfaces) = &geometry.surfaces else { return Ok(()) };
        let Some(view) = views.first() else { return Ok(()) };
        let triangles =
            |geometry: &Geometry, object, leaf| geometry.caster_draw(object, leaf).index_count / 3;
        let scene = CastersInView { hierarchy, geometry, receivers, view, triangles };
        if let Some(volumes) = &mut self.volumes {
            volumes.plan(&surfaces.table, &self.own, &scene, views, uses)?;
        }
        if let Some(maps) = &mut self.maps {
            maps.plan(&surfaces.table, &self.own, &scene, views, uses)?;
        }
        Ok(())
    }

    /// Returns true if casters may be culled, for which receivers must be known.
    pub(crate) fn culls_casters(&self) -> bool {
        self.options.method != ShadowMethod::Off && self.options.may_cull_casters()
    }

    /// Changes the number of frames in flight.
    pub(crate) fn set_frames_in_flight(&mut self, frames_in_flight: usize) {
        if let Some(maps) = &mut self.maps {
            maps.set_frames_in_flight(frames_in_flight);
        }
        if let Some(volumes) = &mut self.volumes {
            volumes.set_frames_in_flight(frames_in_flight);
        }
    }

    /// Returns true if some maps wait for the finished depth of the view.
    pub(crate) fn has_culled(&self) -> bool {
        self.maps.as_ref().is_some_and(ShadowMaps::has_culled)
    }

    /// Returns true if the surfaces of a view cannot be shaded before its depth is finished.
    pub(crate) fn wait_for_depth(&self) -> bool {
        self.has_culled() || self.volumes.is_some()
    }

    /// Draws the maps that wait for the finished depth of the view, which `target` holds.
    pub(crate) fn record_culled(
        &mut self,
        commands: &Commands,
        geometry: &Geometry,
        pipelines: &Pipelines,
        target: RenderTarget,
        view: &CullView,
    ) {
        if let (Some(maps), Some(tests), Some(passes)) =
            (&mut self.maps, &pipelines.shadow_tests, &pipelines.maps)
        {
            maps.record_culled(commands, geometry, tests, &passes.casters, target, view);
        }
    }

    /// Returns true if the plan draws a leaf to some map, or its volume.
    pub(crate) fn draw(&self, leaf: LeafIndex) -> bool {
        self.maps.as_ref().is_some_and(|maps| maps.draws(leaf))
            || self.volumes.as_ref().is_some_and(|volumes| volumes.has_caster(leaf))
    }

    /// Draws the maps as they were planned, before anything of the frame samples them.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn record(
        &mut self,
        frame: &mut Frame<'_>,
        geometry: &Geometry,
        hierarchy: &Hierarchy,
        section: &Section,
        pipelines: &Pipelines,
        predicates: &Predicates,
    ) -> Result<(), Error> {
        match (&mut self.maps, &pipelines.maps) {
            (Some(maps), Some(passes)) => {
                maps.record(frame, geometry, hierarchy, section, passes, predicates)
            }
            _ => Ok(()),
        }
    }

    /// Selects the view whose draws follow, by its number in the frame, and uploads its volumes.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn begin_view(
        &mut self,
        frame: &mut Frame<'_>,
        number: u32,
        view: &CullView,
        geometry: &Geometry,
        hierarchy: &Hierarchy,
        pipelines: &Pipelines,
    ) -> Result<(), Error> {
        if let Some(maps) = &mut self.maps {
            maps.begin_view(number);
        }
        match (&mut self.volumes, &pipelines.volumes) {
            (Some(volumes), Some(pass)) => {
                volumes.begin_view(frame, number, view, geometry, hierarchy, pass)
            }
            _ => Ok(()),
        }
    }

    /// Counts the volumes of the view that was begun against its finished depth in the target.
    pub(crate) fn count_volumes(
        &mut self,
        commands: &Commands,
        geometry: &Geometry,
        pipelines: &mut Pipelines,
        view: &CullView,
        target: &mut Target,
    ) {
        if let (Some(volumes), Some(pass)) = (&mut self.volumes, &mut pipelines.volumes) {
            volumes.record(commands, geometry, pass, pipelines.shadow_tests.as_ref(), view, target);
        }
    }

    /// Notes that the surfaces of the view that was begun are shaded.
    pub(crate) fn end_view(&mut self) {
        if let Some(volumes) = &mut self.volumes {
            volumes.end_view();
        }
    }

    /// Returns the inputs of the passes that draw with shadows, in a frame that recorded the maps.
    pub(crate) fn io(&self) -> Option<ShadowIo<'_>> {
        match (&self.maps, &self.volumes) {
            (Some(maps), _) => maps.io().map(ShadowIo::Maps),
            (None, Some(volumes)) => Some(ShadowIo::Mask(volumes.io())),
            (None, None) => None,
        }
    }

    /// Notes that the frame of the last plan was submitted.
    pub(crate) fn submitted(&mut self, tick: Tick) {
        if let Some(maps) = &mut self.maps {
            maps.submitted(tick);
        }
        if let Some(volumes) = &mut self.volumes {
            volumes.submitted(tick);
        }
    }

    /// Returns the counts of the newest frame.
    pub(crate) fn stats(&self) -> ShadowStats {
        let of_maps = self.maps.as_ref().map(ShadowMaps::stats);
        of_maps.or(self.volumes.as_ref().map(VolumeShadows::stats)).unwrap_or_default()
    }
}
