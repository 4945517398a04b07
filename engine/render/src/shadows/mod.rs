//! Shadows: the maps of lights, drawn before the views of a frame and kept from frame to frame.

mod caster_culling;
mod culled_draws;
mod light_shadow;
mod records;
mod shadow_maps;
mod tile_draws;

use std::collections::HashMap;

use ::shadows::{ShadowMethod, ShadowOptions, ShadowStats};
use cull::{Aabb, Hierarchy, LeafIndex, View};
use gpu::{Commands, Device, Frame, Predicates, RenderTarget, Tick};
use scene::LightId;

use crate::error::Error;
use crate::passes::pipelines::Pipelines;
use crate::resources::geometry::Geometry;
use culled_draws::CastersInView;
pub use light_shadow::LightShadow;
pub use records::ShadowIo;
pub(crate) use shadow_maps::MapUses;
use shadow_maps::ShadowMaps;

/// The shadows of a renderer's lights.
pub(crate) struct Shadows {
    pub(crate) options: ShadowOptions,
    /// The shadows of lights that differ from what the options say.
    pub(crate) own: HashMap<LightId, LightShadow>,
    /// The maps, with the method that has some.
    maps: Option<ShadowMaps>,
}

impl Shadows {
    /// Creates the maps that the options ask for.
    ///
    /// # Errors
    /// Impossible options, a scene without surfaces, no memory, a failed call.
    pub(crate) fn new(
        device: &Device,
        options: ShadowOptions,
        (has_surfaces, frames_in_flight): (bool, usize),
    ) -> Result<Self, Error> {
        options.check()?;
        if options.method != ShadowMethod::Off && !has_surfaces {
            return Err(Error::NoSurfacesForShadows);
        }
        let maps = match options.method {
            ShadowMethod::Off => None,
            ShadowMethod::Maps => Some(ShadowMaps::new(device, options, frames_in_flight)?),
        };
        Ok(Self { options, own: HashMap::new(), maps })
    }

    /// Returns the options that passes are compiled for; `None` without maps.
    pub(crate) fn map_options(&self) -> Option<&ShadowOptions> {
        self.maps.as_ref().map(|_| &self.options)
    }

    /// Draws all maps again in the next frame: casters changed and their boxes did not.
    pub(crate) fn forget(&mut self) {
        if let Some(maps) = &mut self.maps {
            maps.forget();
        }
    }

    /// Plans the maps for the views of a frame, which see `receivers` at most.
    ///
    /// # Errors
    /// A lost device.
    pub(crate) fn plan(
        &mut self,
        (geometry, hierarchy): (&Geometry, &Hierarchy),
        receivers: Aabb,
        views: &[View],
        uses: MapUses,
    ) -> Result<(), Error> {
        let (Some(maps), Some(surfaces), Some(view)) =
            (&mut self.maps, &geometry.surfaces, views.first())
        else {
            return Ok(());
        };
        let scene = CastersInView { hierarchy, geometry, receivers, view };
        maps.plan((&surfaces.table, &self.own), &scene, views, uses)
    }

    /// Changes the number of frames in flight.
    pub(crate) fn set_frames_in_flight(&mut self, frames_in_flight: usize) {
        if let Some(maps) = &mut self.maps {
            maps.set_frames_in_flight(frames_in_flight);
        }
    }

    /// Returns true if some maps wait for the finished depth of the view.
    pub(crate) fn has_culled(&self) -> bool {
        self.maps.as_ref().is_some_and(ShadowMaps::has_culled)
    }

    /// Draws the maps that wait for the finished depth of the view, which `target` holds.
    pub(crate) fn record_culled(
        &mut self,
        commands: &Commands,
        (geometry, pipelines): (&Geometry, &Pipelines),
        target: (RenderTarget, &View),
    ) {
        if let (Some(maps), Some(tests), Some(casters)) =
            (&mut self.maps, &pipelines.shadow_tests, &pipelines.casters)
        {
            maps.record_culled(commands, geometry, (tests, casters), target);
        }
    }

    /// Returns true if the plan draws a leaf to some map.
    pub(crate) fn draw(&self, leaf: LeafIndex) -> bool {
        self.maps.as_ref().is_some_and(|maps| maps.draws(leaf))
    }

    /// Draws the maps as they were planned, before anything of the frame samples them.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn record(
        &mut self,
        frame: &mut Frame<'_>,
        scene: (&Geometry, &Hierarchy),
        (pipelines, predicates): (&Pipelines, &Predicates),
    ) -> Result<(), Error> {
        match (&mut self.maps, &pipelines.casters) {
            (Some(maps), Some(pass)) => maps.record(frame, scene, (pass, predicates)),
            _ => Ok(()),
        }
    }

    /// Selects the view whose draws follow, by its number in the frame.
    pub(crate) fn begin_view(&mut self, number: u32) {
        if let Some(maps) = &mut self.maps {
            maps.begin_view(number);
        }
    }

    /// Returns the inputs of the passes that draw with shadows, in a frame that recorded the maps.
    pub(crate) fn io(&self) -> Option<ShadowIo<'_>> {
        self.maps.as_ref().and_then(ShadowMaps::io)
    }

    /// Notes that the frame of the last plan was submitted.
    pub(crate) fn submitted(&mut self, tick: Tick) {
        if let Some(maps) = &mut self.maps {
            maps.submitted(tick);
        }
    }

    /// Returns the counts of the newest frame.
    pub(crate) fn stats(&self) -> ShadowStats {
        self.maps.as_ref().map(ShadowMaps::stats).unwrap_or_default()
    }
}
