//! Shadow maps: planned as pure values by the crate `shadows`, drawn here in one pass.

use std::collections::HashMap;
use std::ops::Range;

use ::shadows::{
    Casters, FaceWork, JitterTexture, PlannedFace, ShadowCache, ShadowLight, ShadowOptions,
    ShadowPlan, ShadowStats, ShadowViews,
};
use cull::{BoxChange, Hierarchy, LeafIndex, View};
use glam::Vec3;
use gpu::{
    BufferSlice, Commands, DepthLayers, DepthTile, Device, Frame, Predicates, VolumeTexels,
    VolumeTexture,
};
use scene::LightId;

use crate::error::Error;
use crate::passes::{CasterIo, CasterPass};
use crate::resources::geometry::Geometry;
use crate::shading::surfaces::LightTable;
use crate::shadows::LightShadow;
use crate::shadows::records::{FaceRecord, LightRecord, ShadowIo, light_records};

/// The side of the tile of disks, in pixels: neighbours filter with different ones.
const DISKS_SIDE: u32 = 8;

/// Bytes of an indirect draw.
const DRAW_BYTES: u64 = size_of::<gpu::IndirectDraw>() as u64;

/// The shadow maps of all lights.
pub(crate) struct ShadowMaps {
    device: Device,
    options: ShadowOptions,
    cache: ShadowCache,
    plan: ShadowPlan,
    maps: DepthLayers,
    /// The resting casters of maps in two layers, once there are such maps.
    resting: Option<DepthLayers>,
    /// True if the newest frame recorded a use of them.
    uses_resting: bool,
    disks: VolumeTexture,
    /// Changes of boxes that were read from the hierarchy so far.
    changes_read: u64,
    /// The lights of the plan, and their places in the table.
    lights: Vec<ShadowLight>,
    places: Vec<u32>,
    views: u32,
    /// The view that is drawn next.
    view: u32,
    buffers: Option<[BufferSlice; 2]>,
    scratch: Scratch,
}

/// Memory that is kept to allocate nothing at rest.
#[derive(Default)]
struct Scratch {
    changes: Vec<BoxChange>,
    eyes: Vec<Vec3>,
    records: Vec<LightRecord>,
    faces: Vec<FaceRecord>,
    tiles: Vec<DepthTile>,
    /// The casters of the plan, ascending.
    casters: Vec<LeafIndex>,
}

/// The part of the work for a map that is drawn to one image.
#[derive(Clone)]
enum TileDraws {
    /// On a cleared tile.
    Afresh(Range<usize>),
    /// On what is there.
    OnTop(Range<usize>),
}

impl ShadowMaps {
    /// Creates maps for options that were checked.
    ///
    /// # Errors
    /// A side beyond the device's limits, no memory, a failed call.
    pub(crate) fn new(device: &Device, options: ShadowOptions) -> Result<Self, Error> {
        let JitterTexture { side, depth, texels } = JitterTexture::new(DISKS_SIDE);
        let limit = device.adapter().limits.max_image_array_layers;
        if options.layers_max > limit {
            let what = "the number of layers of shadow maps".to_owned();
            let (wanted, limit) = (options.layers_max.into(), limit.into());
            return Err(gpu::Error::TooLarge { what, wanted, limit }.into());
        }
        Ok(Self {
            device: device.clone(),
            options,
            cache: ShadowCache::new(options),
            plan: ShadowPlan::default(),
            maps: DepthLayers::new(device, options.layer_side(), 1, "shadow maps")?,
            resting: None,
            uses_resting: false,
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
        })
    }

    /// Returns the counts of the newest plan.
    pub(crate) fn stats(&self) -> ShadowStats {
        self.plan.stats()
    }

    /// Draws all maps again in the next frame: casters changed and their boxes did not.
    pub(crate) fn forget(&mut self) {
        self.cache.forget();
    }

    /// Plans the maps for the views of a frame. Where there is no memory for more of them, lights
    /// get smaller ones, at last none.
    pub(crate) fn plan(
        &mut self,
        table: &LightTable,
        own: &HashMap<LightId, LightShadow>,
        hierarchy: &Hierarchy,
        views: &[View],
    ) {
        let Scratch { changes, eyes, casters: sorted, .. } = &mut self.scratch;
        let of_lights = (&mut self.lights, &mut self.places);
        super::light_shadow::list(table, (&self.options, own), of_lights.0, of_lights.1);
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
        let eyes = ShadowViews { eyes, sub_pixel_bits };
        self.views = views.len() as u32;
        self.cache.plan(&self.lights, &casters, &eyes, &mut self.plan);
        let side = self.options.layer_side();
        if self.plan.layers > self.maps.layers() {
            let layers = self.plan.layers;
            match DepthLayers::new(&self.device, side, layers, "shadow maps") {
                Ok(maps) => (self.maps, self.resting) = (maps, None),
                Err(error) => {
                    tracing::warn!("no room for more shadow maps, some get smaller: {error}");
                    self.cache.limit_layers(self.maps.layers());
                }
            }
            // Into other layers, all of them.
            self.cache.plan(&self.lights, &casters, &eyes, &mut self.plan);
        }
        if self.plan.has_layers() && self.resting.is_none() {
            let layers = self.maps.layers();
            match DepthLayers::new(&self.device, side, layers, "resting shadow maps") {
                Ok(resting) => self.resting = Some(resting),
                Err(error) => {
                    tracing::warn!("no room for resting casters, maps are drawn whole: {error}");
                    self.cache.keep_no_resting_casters();
                    self.cache.plan(&self.lights, &casters, &eyes, &mut self.plan);
                }
            }
        }
        sorted.clone_from(&self.plan.casters);
        sorted.sort_unstable();
    }

    /// Returns true if the plan draws a leaf to some map.
    pub(crate) fn draws(&self, leaf: LeafIndex) -> bool {
        self.scratch.casters.binary_search(&leaf).is_ok()
    }

    /// Draws the maps as they were planned, before anything of the frame samples them.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn record(
        &mut self,
        frame: &mut Frame<'_>,
        (geometry, hierarchy): (&Geometry, &Hierarchy),
        (pass, predicates): (&CasterPass, &Predicates),
    ) -> Result<(), Error> {
        let Self { plan, lights, places, views, scratch, .. } = self;
        light_records(plan, (lights, places), *views, &mut scratch.records);
        scratch.faces.clear();
        scratch.faces.extend(plan.faces.iter().map(FaceRecord::of));
        // Shaders find at least one of each: memory that nothing was written to holds anything.
        if scratch.records.is_empty() {
            scratch.records.push(LightRecord::default());
        }
        if scratch.faces.is_empty() {
            scratch.faces.push(FaceRecord::default());
        }
        let uploads = frame.uploads();
        self.buffers = Some([uploads.push(&scratch.records)?, uploads.push(&scratch.faces)?]);
        self.view = 0;
        let draw = |leaf: &LeafIndex| {
            let object = hierarchy.leaf_objects().get(leaf.0 as usize);
            object.map(|object| geometry.caster_draw(*object, *leaf)).unwrap_or_default()
        };
        let draws = uploads.push_iter(self.plan.casters.iter().map(draw))?;
        self.uses_resting = self.plan.has_layers();
        let commands = frame.commands();
        let casters = CasterDraws { geometry, pass, predicates, draws };
        if self.plan.stats().drawn_faces == 0 {
            self.maps.prepare(commands);
            return Ok(());
        }
        commands.pass("shadow maps", |commands| self.draw(commands, &casters));
        Ok(())
    }

    fn draw(&mut self, commands: &Commands, casters: &CasterDraws<'_>) {
        let Self { plan, maps, resting, scratch, .. } = self;
        if let Some(resting) = resting.as_mut().filter(|_| plan.has_layers()) {
            let part = |work: &FaceWork| match work {
                FaceWork::Layered { resting: Some(it), .. } => Some(TileDraws::Afresh(it.clone())),
                _ => None,
            };
            casters.draw(commands, resting, &plan.faces, part);
            let is_layered = |face: &&PlannedFace| matches!(face.work, FaceWork::Layered { .. });
            let layered = plan.faces.iter().filter(is_layered).map(|face| DepthTile {
                layer: face.tile.layer,
                origin: face.tile.origin,
                side: face.tile.side,
            });
            scratch.tiles.clear();
            scratch.tiles.extend(layered);
            maps.copy_from(commands, resting, &scratch.tiles);
        }
        casters.draw(commands, maps, &plan.faces, |work| match work {
            FaceWork::Keep => None,
            FaceWork::Draw(all) => Some(TileDraws::Afresh(all.clone())),
            FaceWork::Layered { moving, .. } => Some(TileDraws::OnTop(moving.clone())),
        });
    }

    /// Selects the view whose draws follow, by its number in the frame.
    pub(crate) fn begin_view(&mut self, number: u32) {
        self.view = number;
    }

    /// Returns the inputs of the passes that draw with shadows, in a frame that recorded the maps.
    pub(crate) fn io(&self) -> Option<ShadowIo<'_>> {
        let [lights, faces] = self.buffers?;
        Some(ShadowIo {
            lights,
            faces,
            maps: self.maps.comparing(),
            depths: self.maps.reading(),
            disks: self.disks.sampled(),
            view: self.view,
        })
    }

    /// Notes that the frame of the last plan was submitted.
    pub(crate) fn submitted(&mut self) {
        self.cache.submitted();
        self.maps.submitted();
        // What a frame before recorded, and was never submitted, stays undefined.
        if let Some(resting) = self.resting.as_mut().filter(|_| self.uses_resting) {
            resting.submitted();
        }
    }
}

/// The draws of the casters of all maps of a frame.
struct CasterDraws<'a> {
    geometry: &'a Geometry,
    pass: &'a CasterPass,
    predicates: &'a Predicates,
    /// One indirect command per caster of the plan.
    draws: BufferSlice,
}

impl CasterDraws<'_> {
    /// Draws what `part` names of each face, in one rendering per layer.
    fn draw(
        &self,
        commands: &Commands,
        layers: &mut DepthLayers,
        faces: &[PlannedFace],
        part: impl Fn(&FaceWork) -> Option<TileDraws>,
    ) {
        let Some(surfaces) = self.geometry.surfaces.as_ref() else { return };
        let io = CasterIo {
            vertices: self.geometry.vertices.whole(),
            indices: self.geometry.indices.whole(),
            instances: self.geometry.instances.whole(),
            surfaces,
        };
        layers.draw(commands, |commands, layers| {
            for layer in 0..layers.layers() {
                let is_here = |face: &&PlannedFace| face.tile.layer == layer;
                let mut work = faces
                    .iter()
                    .filter(is_here)
                    .filter_map(|face| Some((face, part(&face.work)?)))
                    .peekable();
                let (Some(target), true) = (layers.target(layer), work.peek().is_some()) else {
                    continue;
                };
                commands.rendering(target, |commands| {
                    self.pass.bind(commands, &io);
                    work.for_each(|(face, part)| self.draw_face(commands, &io, face, part));
                });
            }
        });
    }

    fn draw_face(
        &self,
        commands: &Commands,
        io: &CasterIo<'_>,
        face: &PlannedFace,
        part: TileDraws,
    ) {
        let (origin, size) = (face.tile.origin, [face.tile.side; 2]);
        commands.set_viewport(&gpu::Viewport::covering(origin, size));
        let casters = match part {
            TileDraws::Afresh(casters) => {
                commands.clear_depth(origin, size, 0.0);
                casters
            }
            TileDraws::OnTop(casters) => casters,
        };
        if casters.is_empty() {
            return;
        }
        self.pass.set_view(commands, io, &face.face.view);
        let (first, count) = (casters.start as u64, casters.len() as u64);
        let draws = self.draws.part(first * DRAW_BYTES, count * DRAW_BYTES);
        self.predicates.draw_after_counted(commands, draws);
    }
}
