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
    /// The shadows of single lights that differ from the options.
    pub(crate) own: HashMap<LightId, LightShadow>,
    active: ActiveShadows,
}

/// The method that draws shadows, with its memory.
enum ActiveShadows {
    Off,
    Maps(Box<ShadowMaps>),
    Volumes(Box<VolumeShadows>),
}

impl Shadows {
    /// Creates the maps or volumes that the options request, for images in `target`.
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
        let active = match options.method {
            ShadowMethod::Off => ActiveShadows::Off,
            ShadowMethod::Maps => {
                ActiveShadows::Maps(Box::new(ShadowMaps::new(device, options, frames_in_flight)?))
            }
            ShadowMethod::Volumes if target.attachments().samples != SampleCount::One.flags() => {
                return Err(Error::MultisampledVolumes);
            }
            ShadowMethod::Volumes => ActiveShadows::Volumes(Box::new(VolumeShadows::new(
                device,
                options,
                frames_in_flight,
            )?)),
        };
        Ok(Self { options, own: HashMap::new(), active })
    }

    /// Skips culled casters by the executor of the renderer, with this number of frames in flight.
    pub(crate) fn skip_by(
        &mut self,
        executor: PredicationMode,
        frames: usize,
    ) -> Result<(), Error> {
        match &mut self.active {
            ActiveShadows::Off => Ok(()),
            ActiveShadows::Maps(maps) => maps.skip_by(executor, frames),
            ActiveShadows::Volumes(volumes) => volumes.skip_by(executor, frames),
        }
    }

    /// Draws all maps again in the next frame: casters have changed, although their boxes have not.
    pub(crate) fn forget(&mut self) {
        if let ActiveShadows::Maps(maps) = &mut self.active {
            maps.forget();
        }
    }

    /// Plans the maps or the volumes for the views of a frame. `receivers` is a box around
    /// everything that the views can show.
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
        match &mut self.active {
            ActiveShadows::Off => Ok(()),
            ActiveShadows::Maps(maps) => maps.plan(&surfaces.table, &self.own, &scene, views, uses),
            ActiveShadows::Volumes(volumes) => {
                volumes.plan(&surfaces.table, &self.own, &scene, views, uses)
            }
        }
    }

    /// Returns true if casters may be culled, which needs the box of receivers.
    pub(crate) fn culls_casters(&self) -> bool {
        self.options.method != ShadowMethod::Off && self.options.may_cull_casters()
    }

    /// Changes the number of frames in flight.
    pub(crate) fn set_frames_in_flight(&mut self, frames_in_flight: usize) {
        match &mut self.active {
            ActiveShadows::Off => {}
            ActiveShadows::Maps(maps) => maps.set_frames_in_flight(frames_in_flight),
            ActiveShadows::Volumes(volumes) => volumes.set_frames_in_flight(frames_in_flight),
        }
    }

    /// Returns true if some maps wait for the finished depth of the view.
    pub(crate) fn has_culled(&self) -> bool {
        matches!(&self.active, ActiveShadows::Maps(maps) if maps.has_culled())
    }

    /// Returns true if the surfaces of a view cannot be shaded before its depth is finished.
    pub(crate) fn wait_for_depth(&self) -> bool {
        self.has_culled() || matches!(self.active, ActiveShadows::Volumes(_))
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
        if let (ActiveShadows::Maps(maps), Some(tests), Some(passes)) =
            (&mut self.active, &pipelines.shadow_tests, &pipelines.maps)
        {
            maps.record_culled(commands, geometry, tests, &passes.casters, target, view);
        }
    }

    /// Returns true if the plan draws a leaf to a map, or draws its volume.
    pub(crate) fn draw(&self, leaf: LeafIndex) -> bool {
        match &self.active {
            ActiveShadows::Off => false,
            ActiveShadows::Maps(maps) => maps.draws(leaf),
            ActiveShadows::Volumes(volumes) => volumes.has_caster(leaf),
        }
    }

    /// Draws the maps as planned, before anything of the frame samples them.
    pub(crate) fn record(
        &mut self,
        frame: &mut Frame<'_>,
        geometry: &Geometry,
        hierarchy: &Hierarchy,
        section: &Section,
        pipelines: &Pipelines,
        predicates: &Predicates,
    ) -> Result<(), Error> {
        match (&mut self.active, &pipelines.maps) {
            (ActiveShadows::Maps(maps), Some(passes)) => {
                maps.record(frame, geometry, hierarchy, section, passes, predicates)
            }
            _ => Ok(()),
        }
    }

    /// Selects the view whose draws follow, by its index in the frame, and uploads its volumes.
    pub(crate) fn begin_view(
        &mut self,
        frame: &mut Frame<'_>,
        number: u32,
        view: &CullView,
        geometry: &Geometry,
        hierarchy: &Hierarchy,
        pipelines: &Pipelines,
    ) -> Result<(), Error> {
        match (&mut self.active, &pipelines.volumes) {
            (ActiveShadows::Maps(maps), _) => {
                maps.begin_view(number);
                Ok(())
            }
            (ActiveShadows::Volumes(volumes), Some(pass)) => {
                volumes.begin_view(frame, number, view, geometry, hierarchy, pass)
            }
            _ => Ok(()),
        }
    }

    /// Counts the volumes of the current view against its finished depth in the target.
    pub(crate) fn count_volumes(
        &mut self,
        commands: &Commands,
        geometry: &Geometry,
        pipelines: &mut Pipelines,
        view: &CullView,
        target: &mut Target,
    ) {
        if let (ActiveShadows::Volumes(volumes), Some(pass)) =
            (&mut self.active, &mut pipelines.volumes)
        {
            volumes.record(commands, geometry, pass, pipelines.shadow_tests.as_ref(), view, target);
        }
    }

    /// Notes that the surfaces of the current view are shaded.
    pub(crate) fn end_view(&mut self) {
        if let ActiveShadows::Volumes(volumes) = &mut self.active {
            volumes.end_view();
        }
    }

    /// Returns the inputs of the passes that draw with shadows, in a frame that recorded the maps.
    pub(crate) fn io(&self) -> Option<ShadowIo<'_>> {
        match &self.active {
            ActiveShadows::Off => None,
            ActiveShadows::Maps(maps) => maps.io().map(ShadowIo::Maps),
            ActiveShadows::Volumes(volumes) => Some(ShadowIo::Mask(volumes.io())),
        }
    }

    /// Notes that the frame of the last plan was submitted.
    pub(crate) fn submitted(&mut self, tick: Tick) {
        match &mut self.active {
            ActiveShadows::Off => {}
            ActiveShadows::Maps(maps) => maps.submitted(tick),
            ActiveShadows::Volumes(volumes) => volumes.submitted(tick),
        }
    }

    /// Returns the counts of the newest frame.
    pub(crate) fn stats(&self) -> ShadowStats {
        match &self.active {
            ActiveShadows::Off => ShadowStats::default(),
            ActiveShadows::Maps(maps) => maps.stats(),
            ActiveShadows::Volumes(volumes) => volumes.stats(),
        }
    }
}
