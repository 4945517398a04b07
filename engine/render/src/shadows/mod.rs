//! Shadows: the maps of lights, drawn before the views of a frame and kept from frame to frame.

mod light_shadow;
mod records;
mod shadow_maps;

use std::collections::HashMap;

use ::shadows::{ShadowMethod, ShadowOptions, ShadowStats};
use cull::{Hierarchy, LeafIndex, View};
use gpu::{Device, Frame, Predicates};
use scene::LightId;

use crate::error::Error;
use crate::passes::pipelines::Pipelines;
use crate::resources::geometry::Geometry;
pub use light_shadow::LightShadow;
pub use records::ShadowIo;
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
        has_surfaces: bool,
    ) -> Result<Self, Error> {
        options.check()?;
        if options.method != ShadowMethod::Off && !has_surfaces {
            return Err(Error::NoSurfacesForShadows);
        }
        let maps = match options.method {
            ShadowMethod::Off => None,
            ShadowMethod::Maps => Some(ShadowMaps::new(device, options)?),
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

    /// Plans the maps for the views of a frame.
    pub(crate) fn plan(&mut self, geometry: &Geometry, hierarchy: &Hierarchy, views: &[View]) {
        if let (Some(maps), Some(surfaces)) = (&mut self.maps, &geometry.surfaces) {
            maps.plan(&surfaces.table, &self.own, hierarchy, views);
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
    pub(crate) fn submitted(&mut self) {
        if let Some(maps) = &mut self.maps {
            maps.submitted();
        }
    }

    /// Returns the counts of the newest frame.
    pub(crate) fn stats(&self) -> ShadowStats {
        self.maps.as_ref().map(ShadowMaps::stats).unwrap_or_default()
    }
}
