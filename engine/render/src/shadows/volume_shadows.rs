//! Shadow volumes: the crate `shadows` plans them for each view as pure values. They are counted
//! against the view's depth into a mask that its surfaces read.

use std::collections::HashMap;

use ::shadows::{
    CasterCulling as CullingOption, MASK_LIGHTS, PlannedVolumes, ShadowLight, ShadowOptions,
    ShadowStats, VolumeCounting, VolumeEnd, VolumePlan,
};
use cull::{
    Aabb, BoxShadowVolumes, CullView, Frustum, Hierarchy, LeafIndex, LightReach, SectionPlanes,
};
use glam::Vec4;
use gpu::{
    AttachmentStore, Buffer, BufferSlice, Commands, Device, Frame, IndirectDraw, MemoryKind,
    PredicationMode, Target, Tick, vk,
};
use occlusion::BoxVolumePass;
use scene::LightId;

use crate::error::Error;
use crate::passes::{
    VolumeCaster, VolumeCasters, VolumeDraws, VolumeGroup, VolumeIo, VolumeLight, VolumePass,
    VolumePath,
};
use crate::resources::geometry::Geometry;
use crate::shading::surfaces::LightTable;
use crate::shadows::LightShadow;
use crate::shadows::caster_culling::CasterCulling;
use crate::shadows::culled_draws::{CasterGroup, CastersInView};
use crate::shadows::records::{MASK_HEAD_VALUES, ShadowMaskIo, write_mask_lights};
use crate::shadows::shadow_maps::MapUses;

/// The shadow volumes of all lights.
pub(super) struct VolumeShadows {
    device: Device,
    options: ShadowOptions,
    /// The bits of all lights of a view, for each of its pixels.
    mask: Buffer,
    /// The highest number of bytes in the mask.
    room_bytes: u64,
    /// An empty list of lights, for views without a mask.
    unmasked: Buffer,
    /// The lights of the frame, and their places in the table.
    lights: Vec<ShadowLight>,
    places: Vec<u32>,
    /// A plan per view.
    plans: Vec<VolumePlan>,
    /// The view whose draws follow.
    view: usize,
    /// The work of this view.
    prepared: Option<Prepared>,
    /// The lights in the mask, while the mask belongs to the current view.
    masked: Option<BufferSlice>,
    stats: ShadowStats,
    /// The highest number of lights without shadows that was logged.
    warned_lights: u32,
    values: Vec<u32>,
    /// The choice of casters, if options and device allow it.
    culling: Option<CasterCulling>,
    /// True if casters of the frame are culled.
    is_culled: bool,
    /// The box around everything that can receive shadows.
    receivers: Aabb,
}

/// The work of a view, on the GPU.
struct Prepared {
    draws: VolumeDraws,
    /// The position and the lights of the mask.
    lights: BufferSlice,
    mask_bytes: u64,
}

impl VolumeShadows {
    /// Creates the volumes of a renderer that has not drawn any yet.
    pub(super) fn new(
        device: &Device,
        options: ShadowOptions,
        frames_in_flight: usize,
    ) -> Result<Self, Error> {
        // A compute pass only extrudes whole batches.
        let can_cull = options.culling == CullingOption::Culled
            && VolumePath::of(device) == VolumePath::GeometryShader;
        let culling = can_cull.then(|| CasterCulling::new(device, frames_in_flight)).transpose()?;
        let unmasked = [0_u32; MASK_HEAD_VALUES];
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        Ok(Self {
            device: device.clone(),
            options,
            mask: mask_of(device, 0)?,
            room_bytes: device.adapter().limits.max_storage_buffer_range.into(),
            unmasked: device.upload("no shadow mask", &unmasked, storage)?,
            lights: Vec::new(),
            places: Vec::new(),
            plans: Vec::new(),
            view: 0,
            prepared: None,
            masked: None,
            stats: ShadowStats::default(),
            warned_lights: 0,
            values: Vec::new(),
            culling,
            is_culled: false,
            receivers: Aabb::EMPTY,
        })
    }

    /// Returns the counts of the newest frame.
    pub(super) fn stats(&self) -> ShadowStats {
        match self.culling.as_ref().filter(|_| self.is_culled) {
            None => self.stats,
            Some(culling) => {
                let [triangles, revealed_triangles] = culling.triangles();
                let tests = culling.tests();
                ShadowStats { tests, triangles, revealed_triangles, ..self.stats }
            }
        }
    }

    /// Skips casters by an executor from now on.
    pub(super) fn skip_by(
        &mut self,
        executor: PredicationMode,
        frames: usize,
    ) -> Result<(), Error> {
        self.culling.as_mut().map_or(Ok(()), |culling| culling.skip_by(executor, frames))
    }

    /// Changes the number of frames in flight.
    pub(super) fn set_frames_in_flight(&mut self, frames_in_flight: usize) {
        if let Some(culling) = &mut self.culling {
            culling.set_frames_in_flight(frames_in_flight);
        }
    }

    /// Plans the volumes for the views of a frame. Lights that the mask has no room for cast no
    /// shadows.
    pub(super) fn plan(
        &mut self,
        table: &LightTable,
        own: &HashMap<LightId, LightShadow>,
        scene: &CastersInView<'_>,
        views: &[CullView],
        uses: MapUses,
    ) -> Result<(), Error> {
        let hierarchy = scene.hierarchy;
        self.receivers = scene.receivers;
        self.is_culled = self.culling.is_some() && uses.are_of_one_depth(views);
        if let Some(culling) = &mut self.culling {
            culling.collect(self.device.completed()?, hierarchy);
            culling.begin();
        }
        (self.view, self.prepared, self.masked) = (0, None, None);
        let lights = &mut self.lights;
        super::light_shadow::list(table, &self.options, own, lights, &mut self.places);
        self.plans.resize_with(views.len(), VolumePlan::default);
        self.plan_views(hierarchy, views);
        let mask_bytes = |(plan, view)| mask_bytes(plan, view);
        let wanted = self.plans.iter().zip(views).map(mask_bytes).max().unwrap_or_default();
        if wanted > self.mask.size_bytes() {
            match mask_of(&self.device, wanted) {
                Ok(mask) => self.mask = mask,
                Err(error) => {
                    tracing::warn!("no room for a larger shadow mask: {error}");
                    self.room_bytes = self.mask.size_bytes();
                    self.plan_views(hierarchy, views);
                }
            }
        }
        let unshadowed = self.plans.iter().map(|plan| plan.unshadowed_lights).sum();
        if unshadowed > self.warned_lights {
            self.warned_lights = unshadowed;
            tracing::warn!("the shadow mask has no room for {unshadowed} lights of the views");
        }
        self.stats = ShadowStats { unshadowed_lights: unshadowed, ..ShadowStats::default() };
        Ok(())
    }

    fn plan_views(&mut self, hierarchy: &Hierarchy, views: &[CullView]) {
        for (plan, view) in self.plans.iter_mut().zip(views) {
            let layers = self.room_bytes / layer_bytes(view).max(1);
            let layers = layers.min(self.options.layers_max.into()) as usize;
            let lights_max = layers.saturating_mul(MASK_LIGHTS as usize);
            plan.plan(&self.lights, hierarchy, view, lights_max);
        }
    }

    /// Returns true if the volumes of any view have a leaf among their casters.
    pub(super) fn has_caster(&self, leaf: LeafIndex) -> bool {
        self.plans.iter().any(|plan| plan.has_caster(leaf))
    }

    /// Selects the view whose draws follow, by its index in the frame, and uploads its work.
    pub(super) fn begin_view(
        &mut self,
        frame: &mut Frame<'_>,
        number: u32,
        view: &CullView,
        geometry: &Geometry,
        hierarchy: &Hierarchy,
        pass: &VolumePass,
    ) -> Result<(), Error> {
        (self.view, self.prepared, self.masked) = (number as usize, None, None);
        let Self { plans, lights, places, values, receivers, .. } = self;
        let mut culling = self.culling.as_mut().filter(|_| self.is_culled);
        let Some(plan) = plans.get(number as usize).filter(|plan| !plan.lights.is_empty()) else {
            return Ok(());
        };
        let light_of = |planned: &PlannedVolumes| {
            let light = lights.get(planned.light);
            light.map_or(Vec4::ZERO, |light| light.shape.homogeneous())
        };
        let casting = Casting { plan, geometry, hierarchy };
        let casters: Vec<Vec<VolumeCaster>> =
            plan.lights.iter().map(|light| casting.casters(light, light_of(light))).collect();
        for casters in &casters {
            count(&mut self.stats, casters);
        }
        let triangles = |geometry: &Geometry, object, _| {
            let draw = geometry.volume_draw(object);
            draw.map_or(0, |(draw, volumes)| volumes.draw(draw).index_count / 6)
        };
        // Volumes are made of uncut objects: what section planes remove still casts its shadow.
        let view = &CullView { section: SectionPlanes::default(), ..*view };
        let scene = CastersInView { hierarchy, geometry, receivers: *receivers, view, triangles };
        let mut groups = Vec::new();
        if let Some(culling) = &mut culling {
            for (number, (planned, casters)) in plan.lights.iter().zip(&casters).enumerate() {
                let Some(light) = lights.get(planned.light) else { continue };
                groups.push(plan_casters(culling, &scene, light, planned, number, casters));
            }
            culling.upload(frame, |leaf| casting.draw(*leaf).unwrap_or_default())?;
        }
        let is_culled = culling.is_some();
        let with_bits = (0..).zip(plan.lights.iter().zip(&casters));
        let with_bits = with_bits.map(|(bit, (planned, casters)): (u32, _)| VolumeLight {
            light: light_of(planned),
            ends: &planned.ends,
            bits: 1 << (bit % MASK_LIGHTS),
            layer: bit / MASK_LIGHTS,
            area: planned.area,
            casters: if is_culled {
                VolumeCasters::Culled(groups.get(bit as usize).map_or(&[], Vec::as_slice))
            } else {
                VolumeCasters::All(casters)
            },
        });
        let draws = pass.prepare(frame, &with_bits.collect::<Vec<_>>())?;
        let place_of = |planned: &PlannedVolumes| places.get(planned.light).copied();
        write_mask_lights(view, plan.lights.iter().filter_map(place_of), values);
        let lights = frame.uploads().push(values)?;
        self.prepared = Some(Prepared { draws, lights, mask_bytes: mask_bytes(plan, view) });
        Ok(())
    }

    /// Counts the volumes of the current view against its finished depth in `target`, which must be
    /// prepared again before drawing to it.
    pub(super) fn record(
        &mut self,
        commands: &Commands,
        geometry: &Geometry,
        pass: &mut VolumePass,
        tests: Option<&BoxVolumePass>,
        view: &CullView,
        target: &mut Target,
    ) {
        let culling = self.culling.as_ref().filter(|_| self.is_culled);
        let (Some(Prepared { draws, lights, mask_bytes }), Some(meshes)) =
            (&self.prepared, &geometry.volumes)
        else {
            return;
        };
        let io = VolumeIo {
            vertices: geometry.vertices.whole(),
            adjacency: meshes.adjacency(),
            instances: geometry.instances.whole(),
            mask: self.mask.whole().part(0, *mask_bytes),
        };
        if let (Some(culling), Some(tests)) = (culling, tests) {
            target.prepare_tests(commands);
            let mut depth = target.render_target(None).within(view.origin, view.size).depth_only();
            depth.depth_store = AttachmentStore::Unchanged;
            culling.record_tests(commands, tests, depth, view);
        }
        let draw_group = |commands: &Commands, number: usize| {
            let Some(culling) = culling else { return };
            let groups = culling.groups();
            let place = groups.binary_search_by_key(&number, |group| group.number);
            if let Some(group) = place.ok().and_then(|place| groups.get(place)) {
                culling.draw(commands, group);
            }
        };
        pass.record(commands, &io, view, target, draws, &draw_group);
        if let Some(culling) = culling {
            culling.read_back(commands);
        }
        self.masked = Some(*lights);
    }

    /// Notes that the frame of the last plan was submitted.
    pub(super) fn submitted(&mut self, tick: Tick) {
        if let Some(culling) = &mut self.culling {
            culling.submitted(tick);
        }
    }

    /// Notes that the following draws do not belong to the view of the mask.
    pub(super) fn end_view(&mut self) {
        self.masked = None;
    }

    /// Returns the inputs of the passes that draw with shadows.
    pub(super) fn io(&self) -> ShadowMaskIo {
        let lights = self.masked.unwrap_or(self.unmasked.whole());
        ShadowMaskIo { lights, mask: self.mask.whole() }
    }
}

/// The casters of the volumes of a view.
struct Casting<'a> {
    plan: &'a VolumePlan,
    geometry: &'a Geometry,
    hierarchy: &'a Hierarchy,
}

impl Casting<'_> {
    /// Lists the casters of a light in homogeneous coordinates.
    fn casters(&self, planned: &PlannedVolumes, light: Vec4) -> Vec<VolumeCaster> {
        let ranges = self.plan.ranges_of(planned).iter();
        let leaves =
            ranges.flat_map(|range| range.leaves.iter().map(|leaf| (leaf, range.counting)));
        let ends = &planned.ends[..];
        leaves.filter_map(|(leaf, counting)| self.caster(leaf, counting, light, ends)).collect()
    }

    fn caster(
        &self,
        leaf: LeafIndex,
        counting: VolumeCounting,
        light: Vec4,
        ends: &[VolumeEnd],
    ) -> Option<VolumeCaster> {
        let object = *self.hierarchy.leaf_objects().get(leaf.0 as usize)?;
        let (_, volumes) = self.geometry.volume_draw(object)?;
        let transform = self.geometry.transform(object)?;
        let bounds = self.hierarchy.bounds(self.hierarchy.node_of(object)?);
        let draw = self.draw(leaf)?;
        let kind = volumes.enclosure.kind_under(&transform.matrix3).towards(&bounds, light);
        let end = VolumeEnd::nearest(ends, &bounds);
        Some(VolumeCaster { draw, group: VolumeGroup { counting, kind, end } })
    }

    /// Returns the draw of a caster's triangles with adjacency.
    fn draw(&self, leaf: LeafIndex) -> Option<IndirectDraw> {
        let object = *self.hierarchy.leaf_objects().get(leaf.0 as usize)?;
        let (draw, volumes) = self.geometry.volume_draw(object)?;
        Some(IndirectDraw { first_instance: leaf.0, instance_count: 1, ..volumes.draw(draw) })
    }
}

/// Plans the casters of a light, by its index in the frame, in groups that are drawn in the same
/// way. Returns the groups that are not empty.
fn plan_casters(
    culling: &mut CasterCulling,
    scene: &CastersInView<'_>,
    light: &ShadowLight,
    planned: &PlannedVolumes,
    number: usize,
    casters: &[VolumeCaster],
) -> Vec<(VolumeGroup, usize)> {
    // Volumes have sharp edges, so no filter extends them.
    let reach = LightReach {
        light: light.shape.homogeneous(),
        reach_m: light.shape.reach().map_or(f32::INFINITY, |(_, reach_m)| reach_m),
        spread_m: 0.0,
        lead: 0.0,
    };
    let everywhere = [Frustum::EVERYTHING];
    let volumes = BoxShadowVolumes::new(scene.view, reach, scene.receivers, &everywhere);
    let all = VolumeGroup::all(planned.ends.len());
    let leaves = all.clone().map(|group| {
        let alike = casters.iter().filter(|caster| caster.group == group);
        alike.map(|caster| LeafIndex(caster.draw.first_instance)).collect::<Vec<_>>()
    });
    let leaves: Vec<_> = leaves.collect();
    let numbered = all.zip(&leaves).zip(number * VolumeGroup::MOST..);
    let there = numbered.filter(|((_, casters), _)| !casters.is_empty());
    let groups: Vec<_> =
        there.clone().map(|((_, casters), number)| CasterGroup { number, casters }).collect();
    culling.plan(light.id, planned.area, scene, &volumes, &groups);
    there.map(|((group, _), number)| (group, number)).collect()
}

/// Adds the casters of a light to the counts of a frame.
fn count(stats: &mut ShadowStats, casters: &[VolumeCaster]) {
    let fails = casters.iter().filter(|caster| caster.group.counting == VolumeCounting::ZFail);
    let triangles = casters.iter().map(|caster| u64::from(caster.draw.index_count / 6));
    stats.lights += 1;
    stats.casters += casters.len() as u32;
    stats.z_fail_volumes += fails.count() as u32;
    stats.triangles += triangles.sum::<u64>();
}

/// Returns the bytes of a layer of the mask of a view: 32 bits per pixel.
fn layer_bytes(view: &CullView) -> u64 {
    view.size.map(u64::from).iter().product::<u64>() * size_of::<u32>() as u64
}

fn mask_bytes(plan: &VolumePlan, view: &CullView) -> u64 {
    u64::from((plan.lights.len() as u32).div_ceil(MASK_LIGHTS)) * layer_bytes(view)
}

fn mask_of(device: &Device, size_bytes: u64) -> Result<Buffer, Error> {
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
    Ok(Buffer::new(device, "shadow mask", size_bytes, usage, MemoryKind::Device)?)
}
