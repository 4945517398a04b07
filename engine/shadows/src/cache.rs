//! The cache of shadow maps: decides which maps a frame must draw again, and with which casters.
//!
//! A map holds the nearest depth of all casters that its face sees. It stays valid until the face
//! changes, or a caster that the face sees or saw. Then the map is drawn again. Where a few casters
//! change in many frames, the other casters are kept in a layer of their own. The map is then a
//! copy of this layer with the moving casters drawn on top. The nearest depth does not depend on
//! the order of casters, so the map is the same to the bit.
//!
//! Moving casters need not be marked: the cache finds them from the changes of the hierarchy.
//!
//! A map that is used in a single frame can leave out casters whose shadows are not visible in this
//! frame ([`FaceWork::Cull`]). So an outdated map is first drawn without them. It is drawn with all
//! casters only after the culled frames have cost about as much. A face that changes again before
//! then, such as a cascade of a walking eye, is never drawn with all casters. No map costs more
//! than about twice the optimum (the ski rental problem).

use std::collections::HashMap;

use cull::{Aabb, BoxChange, Hierarchy, LeafIndex, ObjectId};
use glam::Vec3;

use crate::face::{Face, FaceId, FaceSurroundings, face_count, faces_of, wanted_side};
use crate::light::{ShadowLight, ShadowLightId};
use crate::options::{MIN_SIDE, ShadowCaching, ShadowOptions};
use crate::plan::{FaceWork, PlannedFace, PlannedLight, ShadowPlan};
use crate::sun_distance::sun_distance_m;
use crate::tiles::{Tile, TilePool};

/// The number of frames after its last change in which a caster counts as moving.
const RESTLESS_FRAMES: u64 = 32;

/// The casters of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Casters<'a> {
    /// The hierarchy over all casters.
    pub hierarchy: &'a Hierarchy,
    /// The changes since the previous frame; `None` if they are not known.
    pub changes: Option<&'a [BoxChange]>,
}

/// The views of a frame.
#[derive(Clone, Copy, Debug)]
pub struct ShadowViews<'a> {
    /// The eye of each view.
    pub eyes: &'a [Vec3],
    /// The bits of the device's sub-pixel grid (Vulkan's `subPixelPrecisionBits`).
    pub sub_pixel_bits: u32,
    /// The share of its casters' triangles that a culled map drew in recent frames. `None` if the
    /// executor cannot tell which casters shadow something visible. It can in frames of one view
    /// whose depth is complete before anything samples the maps.
    pub drawn_share: Option<f32>,
}

/// The most consecutive frames in which the map of an unchanged face is culled.
const CULLED_FRAMES_MAX: f32 = 15.0;

impl ShadowViews<'_> {
    /// Returns the number of frames in which a map is culled before it is drawn whole: one less
    /// than the number that costs as much as a whole map. `None` if maps are always drawn whole.
    fn culled_frames(&self) -> Option<u32> {
        self.drawn_share
            .map(|share| (share.recip().floor() - 1.0).clamp(0.0, CULLED_FRAMES_MAX) as u32)
    }
}

/// The contents of a map.
#[derive(Clone, Debug)]
struct Map {
    tile: Tile,
    face: Face,
    /// True if the texels are valid.
    is_drawn: bool,
    /// True if the face has changed since the previous frame.
    is_restless: bool,
    /// The number of frames in which this face was drawn culled, since it last changed or was drawn
    /// whole.
    culled_frames: u32,
    /// The casters that the resting layer leaves out, ascending; `None` without such a layer.
    moving: Option<Vec<ObjectId>>,
    /// The newest frame with this face.
    used: u64,
}

/// The maps of all lights, kept from frame to frame.
#[derive(Debug)]
pub struct ShadowCache {
    options: ShadowOptions,
    tiles: TilePool,
    maps: HashMap<FaceId, Map>,
    /// The sides of each light's maps: the wanted side, and the current one.
    sides: HashMap<ShadowLightId, [u32; 2]>,
    /// The distance of directional lights (metres) if the options do not set it. It is computed
    /// from the scene of the first frame and then kept, since a change would be visible as a jump
    /// of all shadows.
    sun_distance_m: Option<f32>,
    /// True if maps may have a layer of resting casters.
    keeps_resting: bool,
    /// The frame of the last change of each caster that is not at rest.
    restless: HashMap<ObjectId, u64>,
    frame: u64,
    /// True from a plan until it was submitted.
    is_pending: bool,
    /// The number of frames in which a map may be culled before it is drawn whole; `None` if maps
    /// must not be culled.
    culled_frames: Option<u32>,
    /// True if the wanted size of a light's maps has changed since the last search for room.
    has_changed: bool,
    faces: Vec<Face>,
}

impl ShadowCache {
    /// Creates a cache without maps. The options must have been [checked](ShadowOptions::check).
    #[must_use]
    pub fn new(options: ShadowOptions) -> Self {
        Self {
            tiles: TilePool::new(options.layer_side(), options.layers_max),
            options,
            maps: HashMap::new(),
            sides: HashMap::new(),
            sun_distance_m: None,
            keeps_resting: true,
            restless: HashMap::new(),
            frame: 0,
            is_pending: false,
            culled_frames: None,
            has_changed: false,
            faces: Vec::new(),
        }
    }

    /// Returns the options.
    #[must_use]
    pub fn options(&self) -> &ShadowOptions {
        &self.options
    }

    /// Marks the contents of all maps as invalid: the next plan draws them again.
    pub fn forget(&mut self) {
        for map in self.maps.values_mut() {
            (map.is_drawn, map.moving, map.culled_frames) = (false, None, 0);
        }
    }

    /// Limits later plans to `layers_max` layers and forgets all maps. Call it if allocating more
    /// layers failed.
    pub fn limit_layers(&mut self, layers_max: u32) {
        self.tiles = TilePool::new(self.options.layer_side(), layers_max);
        self.maps.clear();
        self.sides.clear();
    }

    /// Makes later plans without layers of resting casters and forgets all maps. Call it if
    /// allocating these layers failed.
    pub fn keep_no_resting_casters(&mut self) {
        self.keeps_resting = false;
        self.forget();
    }

    /// Notes that the newest plan was submitted. If this is never called for a plan, the next plan
    /// draws all maps again.
    pub fn submitted(&mut self) {
        self.is_pending = false;
    }

    /// Plans the maps of a frame. Lights that are not usable get none.
    pub fn plan(
        &mut self,
        lights: &[ShadowLight],
        casters: &Casters<'_>,
        views: &ShadowViews<'_>,
        plan: &mut ShadowPlan,
    ) {
        plan.clear();
        self.frame += 1;
        let culls = self.options.may_cull_casters();
        self.culled_frames = views.culled_frames().filter(|_| culls);
        if std::mem::replace(&mut self.is_pending, true) || casters.changes.is_none() {
            self.forget();
        }
        self.note_changes(casters.changes.unwrap_or_default());
        let hierarchy = casters.hierarchy;
        let scene = hierarchy.root().map_or(Aabb::EMPTY, |root| hierarchy.bounds(root));
        if !scene.is_empty() {
            let own_m = &mut self.sun_distance_m;
            let measured_m = || *own_m.get_or_insert_with(|| sun_distance_m(hierarchy));
            let around = FaceSurroundings {
                eyes: views.eyes,
                scene,
                sun_distance_m: self.options.distance_m.unwrap_or_else(measured_m),
                sub_pixel_bits: views.sub_pixel_bits,
            };
            self.release_unused(lights);
            for light in lights.iter().filter(|light| light.shape.is_usable()) {
                self.plan_light(light, casters, &around, plan);
            }
        }
        plan.layers = self.tiles.layers();
    }

    fn note_changes(&mut self, changes: &[BoxChange]) {
        let frame = self.frame;
        self.restless.extend(changes.iter().map(|change| (change.object, frame)));
        if frame.is_multiple_of(RESTLESS_FRAMES) {
            self.restless.retain(|_, changed| *changed + RESTLESS_FRAMES > frame);
        }
    }

    fn is_restless(&self, object: ObjectId) -> bool {
        let changed = self.restless.get(&object);
        changed.is_some_and(|changed| *changed + RESTLESS_FRAMES > self.frame)
    }

    /// Returns the tiles of removed lights and views to the pool.
    fn release_unused(&mut self, lights: &[ShadowLight]) {
        let Self { maps, tiles, sides, frame, has_changed, .. } = self;
        let mut has_more_room = std::mem::take(has_changed);
        let mut there: Vec<ShadowLightId> = lights.iter().map(|light| light.id).collect();
        there.sort_unstable();
        maps.retain(|id, map| {
            let is_used = map.used + 1 >= *frame && there.binary_search(&id.light).is_ok();
            if !is_used {
                tiles.give_back(map.tile);
            }
            has_more_room |= !is_used;
            is_used
        });
        // Lights with smaller maps try again, once each time that there is more room.
        let is_whole = |[wanted, side]: &[u32; 2]| !has_more_room || wanted == side;
        sides.retain(|light, light_sides| {
            is_whole(light_sides) && there.binary_search(light).is_ok()
        });
    }

    fn plan_light(
        &mut self,
        light: &ShadowLight,
        casters: &Casters<'_>,
        around: &FaceSurroundings<'_>,
        plan: &mut ShadowPlan,
    ) {
        let mut faces = std::mem::take(&mut self.faces);
        let first = plan.faces.len();
        let side = self.place(light, around, &mut faces);
        if side.is_none() {
            plan.unshadowed_lights += 1;
        }
        for face in faces.drain(..) {
            self.plan_face(face, casters, plan);
        }
        self.faces = faces;
        plan.lights.push(PlannedLight { light: light.id, faces: first..plan.faces.len() });
    }

    /// Finds tiles for all faces of a light: of the wanted size if possible, else smaller ones.
    /// Returns their side, and lists the faces.
    fn place(
        &mut self,
        light: &ShadowLight,
        around: &FaceSurroundings<'_>,
        faces: &mut Vec<Face>,
    ) -> Option<u32> {
        let options = self.options;
        let wanted = wanted_side(&light.shape, &options);
        let before = self.sides.get(&light.id).copied();
        let known = before.filter(|[then, _]| *then == wanted);
        self.has_changed |= before.is_some() && known.is_none();
        let mut side = known.map_or(wanted, |[_, side]| side);
        while side >= MIN_SIDE {
            faces.clear();
            faces_of(light, &options, side, around, |face| faces.push(face));
            debug_assert_eq!(
                faces.len() as u32,
                face_count(&light.shape, &options, around.eyes.len())
            );
            if self.take_tiles(faces, side) {
                self.sides.insert(light.id, [wanted, side]);
                return Some(side);
            }
            side /= 2;
        }
        faces.clear();
        // No maps until there is more room.
        self.sides.insert(light.id, [wanted, 0]);
        None
    }

    /// Takes tiles of this size for all faces of a light that have none. Returns false, and leaves
    /// the light without tiles, if there is not enough room.
    fn take_tiles(&mut self, faces: &[Face], side: u32) -> bool {
        let Self { maps, tiles, frame, .. } = self;
        for face in faces {
            if let Some(map) = maps.get(&face.id)
                && map.tile.side != side
            {
                tiles.give_back(map.tile);
                maps.remove(&face.id);
            }
        }
        // Checked first, so that no layer is opened for a light that does not fit.
        let missing = faces.iter().filter(|face| !maps.contains_key(&face.id)).count();
        if missing > tiles.room(side) {
            for face in faces {
                if let Some(map) = maps.remove(&face.id) {
                    tiles.give_back(map.tile);
                }
            }
            return false;
        }
        for face in faces {
            if let Some(map) = maps.get_mut(&face.id) {
                map.used = *frame;
                continue;
            }
            let Some(tile) = tiles.take(side) else { return false };
            let mut face = *face;
            face.view.origin = tile.origin;
            let map = Map {
                tile,
                face,
                is_drawn: false,
                is_restless: false,
                culled_frames: 0,
                moving: None,
                used: *frame,
            };
            maps.insert(face.id, map);
        }
        true
    }

    fn plan_face(&mut self, mut face: Face, casters: &Casters<'_>, plan: &mut ShadowPlan) {
        let Some(mut map) = self.maps.remove(&face.id) else { return };
        face.view.origin = map.tile.origin;
        let is_other = map.face != face;
        if is_other {
            (map.face, map.is_drawn, map.moving) = (face, false, None);
            map.culled_frames = 0;
        }
        let is_restless = std::mem::replace(&mut map.is_restless, is_other) && is_other;
        let is_cached = self.options.caching == ShadowCaching::Cached;
        let is_culled = self.culled_frames.is_some_and(|frames| {
            !is_cached || !map.is_drawn && (is_restless || map.culled_frames < frames)
        });
        let work = if is_culled {
            FaceWork::Cull(all(&face, casters, plan))
        } else if is_cached {
            self.work(&mut map, casters, plan)
        } else {
            FaceWork::Draw(all(&face, casters, plan))
        };
        map.is_drawn = !matches!(work, FaceWork::Cull(_));
        map.culled_frames = if map.is_drawn { 0 } else { map.culled_frames + 1 };
        plan.faces.push(PlannedFace { face, tile: map.tile, work });
        self.maps.insert(face.id, map);
    }

    /// Decides the work for a map, and updates the map's state accordingly.
    fn work(&self, map: &mut Map, casters: &Casters<'_>, plan: &mut ShadowPlan) -> FaceWork {
        let face = map.face;
        if !map.is_drawn {
            map.moving = None;
            return FaceWork::Draw(all(&face, casters, plan));
        }
        let mut changed: Vec<ObjectId> = casters
            .changes
            .unwrap_or_default()
            .iter()
            .filter(|change| face.sees(&change.before) || face.sees(&change.after))
            .map(|change| change.object)
            .collect();
        if changed.is_empty() {
            return FaceWork::Keep;
        }
        changed.sort_unstable();
        changed.dedup();
        let is_left_out =
            |moving: &[ObjectId]| changed.iter().all(|object| moving.binary_search(object).is_ok());
        let restless =
            |moving: &[ObjectId]| moving.iter().filter(|object| self.is_restless(**object)).count();
        // A resting layer that leaves out many casters that are at rest by now is not worth its
        // copy.
        let fits = |moving: &&Vec<ObjectId>| {
            is_left_out(moving) && moving.len() <= 2 * restless(moving) + 8
        };
        if let Some(moving) = map.moving.as_ref().filter(fits) {
            return FaceWork::Layered { resting: None, moving: some(&face, casters, moving, plan) };
        }
        self.draw_layers(map, changed, casters, plan)
    }

    /// Draws a map in two layers, or in one if most of its casters move: then two layers do not pay
    /// off.
    fn draw_layers(
        &self,
        map: &mut Map,
        changed: Vec<ObjectId>,
        casters: &Casters<'_>,
        plan: &mut ShadowPlan,
    ) -> FaceWork {
        let face = map.face;
        let hierarchy = casters.hierarchy;
        let first = plan.casters.len();
        face.casters(hierarchy, &mut plan.casters);
        let object = |leaf: &LeafIndex| hierarchy.leaf_objects().get(leaf.0 as usize).copied();
        let there = plan.casters.get(first..).unwrap_or_default().iter().filter_map(object);
        let mut moving: Vec<ObjectId> =
            there.filter(|object| self.is_restless(*object)).chain(changed).collect();
        moving.sort_unstable();
        moving.dedup();
        let count = plan.casters.len() - first;
        if 2 * moving.len() > count || !self.keeps_resting {
            map.moving = None;
            let all = first..plan.casters.len();
            return match self.culled_frames {
                None | Some(0) => FaceWork::Draw(all),
                Some(_) => FaceWork::Cull(all),
            };
        }
        let is_moving = |leaf: &LeafIndex| {
            object(leaf).is_some_and(|object| moving.binary_search(&object).is_ok())
        };
        let mut kept = first;
        for place in first..plan.casters.len() {
            if let Some(leaf) = plan.casters.get(place).copied().filter(|leaf| !is_moving(leaf)) {
                plan.casters.swap(kept, place);
                debug_assert_eq!(plan.casters.get(kept), Some(&leaf));
                kept += 1;
            }
        }
        plan.casters.truncate(kept);
        let on_top = some(&face, casters, &moving, plan);
        map.moving = Some(moving);
        FaceWork::Layered { resting: Some(first..kept), moving: on_top }
    }
}

/// Adds all casters of a face to a plan.
fn all(face: &Face, casters: &Casters<'_>, plan: &mut ShadowPlan) -> std::ops::Range<usize> {
    let first = plan.casters.len();
    face.casters(casters.hierarchy, &mut plan.casters);
    first..plan.casters.len()
}

/// Adds the casters among `objects` that a face sees to a plan.
fn some(
    face: &Face,
    casters: &Casters<'_>,
    objects: &[ObjectId],
    plan: &mut ShadowPlan,
) -> std::ops::Range<usize> {
    let first = plan.casters.len();
    let hierarchy = casters.hierarchy;
    let seen = objects.iter().filter_map(|object| {
        let node = hierarchy.node_of(*object)?;
        let is_seen = face.sees(&hierarchy.bounds(node));
        is_seen.then(|| hierarchy.leaves(node).first)
    });
    plan.casters.extend(seen);
    first..plan.casters.len()
}
