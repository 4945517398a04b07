//! Shadow maps: the crate `shadows` plans them as pure values, and one pass draws them here.

use std::collections::HashMap;

use ::shadows::{
    Casters, FaceWork, JitterTexture, LitArea, PlannedFace, PlannedLight, ShadowCache,
    ShadowFilter, ShadowLight, ShadowOptions, ShadowPlan, ShadowStats, ShadowViews, light_reach,
};
use cull::{BoxChange, BoxShadowVolumes, CullView, Frustum, Hierarchy, LeafIndex};
use glam::Vec3;
use gpu::{
    BufferSlice, Commands, Device, Frame, OptionalFeature, Predicates, PredicationMode,
    RenderTarget, Tick, VolumeTexels, VolumeTexture,
};
use occlusion::BoxVolumePass;
use scene::LightId;

use crate::error::Error;
use crate::passes::{CasterPass, MapPasses};
use crate::resources::geometry::Geometry;
use crate::section::Section;
use crate::shading::surfaces::LightTable;
use crate::shadows::LightShadow;
use crate::shadows::caster_culling::CasterCulling;
use crate::shadows::culled_draws::{CasterGroup, CastersInView, CulledGroup};
use crate::shadows::map_images::MapImages;
use crate::shadows::records::{FaceRecord, LightRecord, ShadowMapIo, light_records};
use crate::shadows::tile_draws::{
    CasterDraws, DrawnTile, FaceSections, TileStart, begin_tile, caster_io, tiles_target,
};

/// The side of the tile of disks, in pixels. Neighbouring pixels filter with different disks.
const DISKS_SIDE: u32 = 8;

/// The shadow maps of all lights.
pub(crate) struct ShadowMaps {
    device: Device,
    options: ShadowOptions,
    cache: ShadowCache,
    plan: ShadowPlan,
    images: MapImages,
    disks: VolumeTexture,
    /// The number of changes of boxes read from the hierarchy so far.
    changes_read: u64,
    /// The lights of the plan, and their places in the table.
    lights: Vec<ShadowLight>,
    places: Vec<u32>,
    views: u32,
    /// The view whose draws follow.
    view: u32,
    /// The choice of casters, if options and device allow it.
    culling: Option<CasterCulling>,
    /// The number of triangles of the casters that are drawn without a test.
    triangles: u64,
    buffers: Option<[BufferSlice; 2]>,
    scratch: Scratch,
    /// The section planes for each face of the frame.
    sections: FaceSections,
}

/// Memory that is kept to allocate nothing in the steady state.
#[derive(Default)]
struct Scratch {
    changes: Vec<BoxChange>,
    eyes: Vec<Vec3>,
    records: Vec<LightRecord>,
    faces: Vec<FaceRecord>,
    /// The casters of the plan, ascending.
    casters: Vec<LeafIndex>,
}

/// The readers of the maps of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MapUses {
    /// Only the shading of the frame's views, each with its finished depth.
    ShadedView,
    /// Also images from other viewpoints, such as debug views.
    Anywhere,
}

impl MapUses {
    /// Returns true if all readers of shadows belong to the finished depth of one view, which can
    /// decide about the casters that matter.
    pub(super) fn are_of_one_depth(self, views: &[CullView]) -> bool {
        self == Self::ShadedView && views.len() == 1
    }
}

impl ShadowMaps {
    /// Creates maps for options that were checked.
    pub(crate) fn new(
        device: &Device,
        options: ShadowOptions,
        frames_in_flight: usize,
    ) -> Result<Self, Error> {
        let JitterTexture { side, depth, texels } = JitterTexture::new(DISKS_SIDE);
        let limit = device.adapter().limits.max_image_array_layers;
        if options.layers_max > limit {
            let what = "the number of layers of shadow maps".to_owned();
            let wanted = options.layers_max.into();
            let limit = limit.into();
            return Err(gpu::Error::TooLarge { what, wanted, limit }.into());
        }
        let can_cull = options.may_cull_casters()
            && device.capabilities().has(OptionalFeature::FragmentStores);
        let culling = can_cull.then(|| CasterCulling::new(device, frames_in_flight));
        Ok(Self {
            culling: culling.transpose()?,
            triangles: 0,
            device: device.clone(),
            options,
            cache: ShadowCache::new(options),
            plan: ShadowPlan::default(),
            images: MapImages::new(device, &options, 1)?,
            disks: {
                let texels = VolumeTexels::Signed(&texels);
                VolumeTexture::new(device, [side, side, depth], texels, "shadow disks")?
            },
            changes_read: 0,
            lights: Vec::new(),
            places: Vec::new(),
            views: 0,
            view: 0,
            buffers: None,
            scratch: Scratch::default(),
            sections: FaceSections::default(),
        })
    }

    /// Returns the counts of the newest plan.
    pub(crate) fn stats(&self) -> ShadowStats {
        let [drawn, revealed_triangles] =
            self.culling.as_ref().map(CasterCulling::triangles).unwrap_or_default();
        let tests = self.culling.as_ref().map_or(0, CasterCulling::tests);
        let triangles = self.triangles + drawn;
        ShadowStats { tests, triangles, revealed_triangles, ..self.plan.stats() }
    }

    /// Skips casters by an executor from now on.
    pub(crate) fn skip_by(
        &mut self,
        executor: PredicationMode,
        frames: usize,
    ) -> Result<(), Error> {
        self.culling.as_mut().map_or(Ok(()), |culling| culling.skip_by(executor, frames))
    }

    /// Changes the number of frames in flight.
    pub(crate) fn set_frames_in_flight(&mut self, frames_in_flight: usize) {
        if let Some(culling) = &mut self.culling {
            culling.set_frames_in_flight(frames_in_flight);
        }
    }

    /// Draws all maps again in the next frame: casters have changed, although their boxes have not.
    pub(crate) fn forget(&mut self) {
        self.cache.forget();
    }

    /// Plans the maps for the views of a frame. If there is not enough memory for them, lights get
    /// smaller maps, and finally none.
    pub(crate) fn plan(
        &mut self,
        table: &LightTable,
        own: &HashMap<LightId, LightShadow>,
        scene: &CastersInView<'_>,
        views: &[CullView],
        uses: MapUses,
    ) -> Result<(), Error> {
        let hierarchy = scene.hierarchy;
        let Scratch { changes, eyes, casters: sorted, .. } = &mut self.scratch;
        let lights = &mut self.lights;
        super::light_shadow::list(table, &self.options, own, lights, &mut self.places);
        changes.clear();
        let are_known = hierarchy
            .box_changes_since(self.changes_read)
            .map(|found| changes.extend(found.copied()))
            .is_some();
        self.changes_read = hierarchy.box_changes();
        eyes.clear();
        eyes.extend(views.iter().map(|view| view.rays.origin));
        let casters = Casters { hierarchy, changes: are_known.then_some(&changes[..]) };
        let sub_pixel_bits = self.device.adapter().limits.sub_pixel_precision_bits;
        let culling = self.culling.as_ref().filter(|_| uses.are_of_one_depth(views));
        let drawn_share = culling.map(CasterCulling::drawn_share);
        let eyes = ShadowViews { eyes, sub_pixel_bits, drawn_share };
        self.views = views.len() as u32;
        self.cache.plan(&self.lights, &casters, &eyes, &mut self.plan);
        let options = &self.options;
        if self.plan.layers > self.images.layers() {
            match MapImages::new(&self.device, options, self.plan.layers) {
                Ok(images) => self.images = images,
                Err(error) => {
                    tracing::warn!("no room for more shadow maps, some get smaller: {error}");
                    self.cache.limit_layers(self.images.layers());
                }
            }
            // All maps move to other layers.
            self.cache.plan(&self.lights, &casters, &eyes, &mut self.plan);
        }
        if self.plan.has_layers()
            && let Err(error) = self.images.keep_resting(&self.device, options)
        {
            tracing::warn!("no room for resting casters, maps are drawn whole: {error}");
            self.cache.keep_no_resting_casters();
            self.cache.plan(&self.lights, &casters, &eyes, &mut self.plan);
        }
        sorted.clone_from(&self.plan.casters);
        sorted.sort_unstable();
        if let Some(culling) = &mut self.culling {
            culling.collect(self.device.completed()?, hierarchy);
            culling.begin();
            for planned in &self.plan.lights {
                let light = self.lights.iter().find(|light| light.id == planned.light);
                let Some(light) = light else { continue };
                plan_casters(culling, &self.plan, planned, light, scene, self.options.filter);
            }
        }
        Ok(())
    }

    /// Returns true if the plan draws a leaf to a map.
    pub(crate) fn draws(&self, leaf: LeafIndex) -> bool {
        self.scratch.casters.binary_search(&leaf).is_ok()
    }

    /// Draws the maps as planned, before anything of the frame samples them.
    pub(crate) fn record(
        &mut self,
        frame: &mut Frame<'_>,
        geometry: &Geometry,
        hierarchy: &Hierarchy,
        section: &Section,
        passes: &MapPasses,
        predicates: &Predicates,
    ) -> Result<(), Error> {
        self.sections.upload(frame, section, &self.plan.faces)?;
        let Self { plan, lights, places, views, scratch, .. } = self;

        light_records(
            plan,
            lights,
            places,
            *views,
            self.options.cascade_blend,
            &mut scratch.records,
        );
        scratch.faces.clear();
        scratch.faces.extend(plan.faces.iter().map(FaceRecord::of));
        // Shaders read at least one record of each kind, and unwritten memory may hold anything.
        if scratch.records.is_empty() {
            scratch.records.push(LightRecord::default());
        }
        if scratch.faces.is_empty() {
            scratch.faces.push(FaceRecord::default());
        }
        let uploads = frame.uploads();
        self.buffers = Some([uploads.push(&scratch.records)?, uploads.push(&scratch.faces)?]);
        self.view = 0;
        let draw_of = |leaf: &LeafIndex| {
            let object = hierarchy.leaf_objects().get(leaf.0 as usize);
            object.map(|object| geometry.caster_draw(*object, *leaf)).unwrap_or_default()
        };
        let ShadowStats { drawn_faces, culled_faces, .. } = self.plan.stats();
        // The draws of culled maps are written in the order of their tests.
        let casters = if drawn_faces == culled_faces { &[][..] } else { &self.plan.casters[..] };
        let draws = uploads.push_iter(casters.iter().map(draw_of))?;
        let drawn = self.plan.faces.iter().flat_map(|face| face.work.drawn_casters());
        let drawn = drawn.filter_map(|range| self.plan.casters.get(range)).flatten();
        // Midpoints need both sides of each caster.
        let sides = 1 + u64::from(passes.midpoints.is_some());
        self.triangles = drawn.map(|leaf| sides * u64::from(draw_of(leaf).index_count / 3)).sum();
        if let Some(culling) = &mut self.culling {
            culling.upload(frame, draw_of)?;
        }
        let commands = frame.commands();
        self.images.begin_frame();
        if drawn_faces == culled_faces {
            self.images.maps_mut().prepare(commands);
            return Ok(());
        }
        let casters = CasterDraws { geometry, predicates, draws, section: &self.sections };
        self.images.draw(commands, &casters, passes, &self.plan);
        Ok(())
    }

    /// Returns true if maps of the newest frame are still to be drawn, because tests against the
    /// finished depth decide about their casters.
    pub(crate) fn has_culled(&self) -> bool {
        self.culling.as_ref().is_some_and(|culling| !culling.groups().is_empty())
    }

    /// Draws the maps whose casters are culled, once `target` holds the finished depth of the view.
    pub(crate) fn record_culled(
        &mut self,
        commands: &Commands,
        geometry: &Geometry,
        tests: &BoxVolumePass,
        casters: &CasterPass,
        target: RenderTarget,
        view: &CullView,
    ) {
        let Some(culling) = self.culling.as_ref().filter(|culling| !culling.groups().is_empty())
        else {
            return;
        };
        culling.record_tests(commands, tests, target, view);
        let Some(io) = caster_io(geometry) else { return };
        let faces = &self.plan.faces;
        commands.pass("culled shadow maps", |commands| {
            self.images.maps_mut().draw(commands, |commands, layers| {
                for layer in 0..layers.layers() {
                    let planned = |culled_group: &CulledGroup| {
                        faces.get(culled_group.number).filter(|face| face.tile.layer == layer)
                    };
                    let groups = || culling.groups().iter();
                    let mut here =
                        groups().filter_map(|group| Some((group, planned(group)?))).peekable();
                    let (Some(target), true) = (layers.target(layer), here.peek().is_some()) else {
                        continue;
                    };
                    let cleared = |face: &PlannedFace| DrawnTile {
                        tile: face.tile,
                        start: TileStart::Cleared,
                    };
                    let tiles = groups().filter_map(|group| planned(group).map(cleared));
                    commands.rendering(tiles_target(target, tiles), |commands| {
                        self.sections.bind(commands, casters, &io);
                        for (culled, face) in here {
                            begin_tile(commands, face, TileStart::Cleared);
                            self.sections.bind_face(commands, casters, &io, culled.number, face);
                            culling.draw(commands, culled);
                        }
                    });
                }
            });
        });
        culling.read_back(commands);
    }

    /// Selects the view whose draws follow, by its index in the frame.
    pub(crate) fn begin_view(&mut self, number: u32) {
        self.view = number;
    }

    /// Returns the inputs of the passes that draw with shadows, in a frame that recorded the maps.
    pub(crate) fn io(&self) -> Option<ShadowMapIo<'_>> {
        let [lights, faces] = self.buffers?;
        Some(ShadowMapIo {
            lights,
            faces,
            maps: self.images.maps().comparing(),
            depths: self.images.maps().reading(),
            disks: self.disks.sampled(),
            view: self.view,
        })
    }

    /// Notes that the frame of the last plan was submitted.
    pub(crate) fn submitted(&mut self, tick: Tick) {
        self.cache.submitted();
        if let Some(culling) = &mut self.culling {
            culling.submitted(tick);
        }
        self.images.submitted();
    }
}

/// Plans the casters of a light's culled maps.
fn plan_casters(
    culling: &mut CasterCulling,
    plan: &ShadowPlan,
    planned: &PlannedLight,
    light: &ShadowLight,
    scene: &CastersInView<'_>,
    filter: ShadowFilter,
) {
    let faces =
        || (planned.faces.start..).zip(plan.faces.get(planned.faces.clone()).unwrap_or(&[]));
    let group = |(number, face): (usize, &PlannedFace)| match &face.work {
        FaceWork::Cull(casters) => {
            Some(CasterGroup { number, casters: plan.casters.get(casters.clone())? })
        }
        FaceWork::Keep | FaceWork::Draw(_) | FaceWork::Layered { .. } => None,
    };
    let groups: Vec<CasterGroup<'_>> = faces().filter_map(group).collect();
    if groups.is_empty() {
        return;
    }
    let culled = || faces().filter(|face| group(*face).is_some()).map(|(_, face)| &face.face);
    let frusta: Vec<Frustum> = culled().map(|face| face.view.frustum).collect();
    let reach = light_reach(light, culled(), filter);
    let volumes = BoxShadowVolumes::new(scene.view, reach, scene.receivers, &frusta);
    let area = LitArea::of(scene.view, &light.shape, &scene.receivers);
    let area = area.unwrap_or(LitArea::whole(scene.view));
    culling.plan(light.id, area, scene, &volumes, &groups);
}
