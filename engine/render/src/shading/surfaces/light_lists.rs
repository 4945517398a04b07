//! The point and spot lights that reach each object: a list of limited length per object, from the
//! strongest light on.

use cull::{Aabb, Hierarchy, NodeId, ObjectId};
use glam::Vec3;
use scene::limits::MAX_LIGHTS_PER_OBJECT;
use scene::{LightKind, PunctualLight};

use crate::shading::surfaces::light_tree::{LightTree, Reach, Strongest};
use crate::shading::surfaces::lights::LightTable;
use crate::shading::surfaces::marked::Marked;

/// The number of values in a list, with two lights per value.
pub(crate) const LIST_VALUES: usize = MAX_LIGHTS_PER_OBJECT / 2;

/// The highest number of nodes that the search for one object may visit in the tree of lights. It
/// is enough for all nodes of up to 8192 lights. More are needed only if thousands of lights end
/// just short of an object.
pub(crate) const MOST_VISITS: usize = 1 << 14;

/// The highest number of nodes for one object after the searches of a frame, or of loading, have
/// visited [`VISITS_A_FRAME`]. Lights that are spread over a scene need about a hundred.
pub(crate) const LEAST_VISITS: usize = 1 << 9;

/// The number of visits in a frame after which searches get shorter: a few tenths of a second.
pub(crate) const VISITS_A_FRAME: usize = 1 << 25;

/// A list in the form that shaders read, and its length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct LightList {
    values: [u32; LIST_VALUES],
    count: u32,
    /// True if the list leaves out lights that reach the object.
    leaves_out: bool,
}

/// The lists of all objects, by slots: first the objects by their ids, then the transparent ones.
///
/// Memory grows only with the number of slots and of lights. In the worst case a frame finds every
/// list again, each by a limited search.
#[derive(Debug, Default)]
pub struct LightLists {
    /// True if there are point or spot lights, including dark ones, which may be lit later.
    has_lights: bool,
    tree: LightTree,
    lists: Vec<LightList>,
    /// The number of lists that leave lights out.
    crowded: usize,
    /// The slots whose list is not on the GPU yet.
    dirty: Marked,
    /// The slots around which lights changed. Their lists must be found again before the next
    /// frame.
    doubtful: Marked,
    /// The number of nodes visited to find doubtful slots. If it exceeds a limit that grows with
    /// the number of slots, all slots become doubtful.
    doubt_visits: usize,
    /// The number of nodes of the tree that searches visited since the last frame.
    visits: usize,
}

impl LightLists {
    /// Creates empty lists for `slots` slots.
    pub(crate) fn new(table: &LightTable, slots: usize) -> Self {
        let reaches = table.lights.iter().zip(&table.places);
        let is_local = |light: &PunctualLight| light.kind != LightKind::Directional;
        Self {
            has_lights: table.lights.iter().any(is_local),
            tree: LightTree::new(reaches.map(|(light, entry)| Reach::of(light, *entry)).collect()),
            lists: vec![LightList::default(); slots],
            crowded: 0,
            dirty: Marked::none_of(slots),
            doubtful: Marked::none_of(slots),
            doubt_visits: 0,
            visits: 0,
        }
    }

    /// Returns true if there are point or spot lights.
    pub(crate) fn has_lights(&self) -> bool {
        self.has_lights
    }

    /// Returns the number of lights that reach the object in a slot.
    #[must_use]
    pub fn count(&self, slot: u32) -> u32 {
        self.lists.get(slot as usize).map_or(0, |list| list.count)
    }

    /// Returns the lights that reach the object in a slot as places in the light table, from the
    /// strongest on.
    #[cfg(test)]
    pub fn entries(&self, slot: u32) -> Vec<u32> {
        let list = self.lists.get(slot as usize).copied().unwrap_or_default();
        let entry = |place: usize| list.values[place / 2] >> (16 * (place % 2)) & 0xFFFF;
        (0..list.count as usize).map(entry).collect()
    }

    /// Returns the number of objects in reach of more lights than [`MAX_LIGHTS_PER_OBJECT`], for
    /// which the weakest are left out.
    #[must_use]
    pub fn crowded(&self) -> usize {
        self.crowded
    }

    /// Finds the lists of all objects of a hierarchy, whose slots begin at `first_slot`.
    pub(crate) fn fill(&mut self, hierarchy: &Hierarchy, first_slot: u32) {
        for object in 0..hierarchy.leaf_objects().len() as u32 {
            if let Some(node) = hierarchy.node_of(ObjectId(object)) {
                self.find(first_slot + object, &hierarchy.bounds(node));
            }
        }
    }

    /// Finds the list of the object in a slot by its box in the world. An empty box makes an empty
    /// list. Returns true if the list changed.
    pub(crate) fn find(&mut self, slot: u32, bounds: &Aabb) -> bool {
        let most_visits = if self.visits < VISITS_A_FRAME { MOST_VISITS } else { LEAST_VISITS };
        let found = self.tree.strongest(bounds, most_visits);
        self.visits += found.visits;
        let now = LightList::of(&found);
        let Some(list) = self.lists.get_mut(slot as usize) else { return false };
        let before = std::mem::replace(list, now);
        self.crowded += usize::from(now.leaves_out);
        self.crowded -= usize::from(before.leaves_out);
        let is_other = (before.values, before.count) != (now.values, now.count);
        if is_other {
            self.dirty.mark_dirty(slot);
        }
        is_other
    }

    /// Replaces a light by another at the same place in the table. Returns the spheres (centre,
    /// radius in metres) that the former and the new light reach. Objects in them are
    /// [doubtful](LightLists::doubt).
    pub(crate) fn replace(
        &mut self,
        light: usize,
        entry: Option<u32>,
        to: &PunctualLight,
    ) -> impl Iterator<Item = (Vec3, f32)> + use<> {
        let now = Reach::of(to, entry);
        let before = self.tree.replace(light, now);
        [before, now].into_iter().flatten().map(|reach| (reach.position, reach.reach_m))
    }

    /// Marks the lists of the objects within `radius_m` of `centre`, which must be found again. The
    /// slots of the hierarchy's objects begin at `first_slot`.
    pub(crate) fn doubt(
        &mut self,
        hierarchy: &Hierarchy,
        first_slot: u32,
        centre: Vec3,
        radius_m: f32,
    ) {
        if self.doubts_all() {
            return;
        }
        self.doubt_visits += objects_within(hierarchy, centre, radius_m, |object| {
            self.doubtful.mark_dirty(first_slot + object.0);
        });
        if self.doubts_all() {
            (0..self.lists.len() as u32).for_each(|slot| self.doubtful.mark_dirty(slot));
        }
    }

    fn doubts_all(&self) -> bool {
        self.doubt_visits > 4 * self.lists.len() + 1000
    }

    /// Takes the slots whose lists must be found again before a frame.
    pub(crate) fn take_doubtful(&mut self) -> Vec<u32> {
        self.doubt_visits = 0;
        self.doubtful.drain().collect()
    }

    /// Returns the slots whose lists are not on the GPU.
    pub(crate) fn dirty(&self) -> &[u32] {
        self.dirty.list()
    }

    /// Returns the list in a slot in the form that shaders read.
    pub(crate) fn values(&self, slot: u32) -> [u32; LIST_VALUES] {
        self.lists.get(slot as usize).map(|list| list.values).unwrap_or_default()
    }

    /// Returns all lists, in the order of slots.
    pub(crate) fn all_values(&self) -> Vec<[u32; LIST_VALUES]> {
        self.lists.iter().map(|list| list.values).collect()
    }

    /// Returns the number of nodes of the tree of lights that were visited since the last frame.
    #[cfg(test)]
    pub(crate) fn visits(&self) -> usize {
        self.visits
    }

    /// Returns the number of nodes of hierarchies visited since the last frame to find the objects
    /// around changed lights.
    #[cfg(test)]
    pub(crate) fn doubt_visits(&self) -> usize {
        self.doubt_visits
    }

    /// Notes that all lists are on the GPU.
    pub(crate) fn submitted(&mut self) {
        self.dirty.drain().for_each(drop);
        self.visits = 0;
    }
}

impl LightList {
    fn of(found: &Strongest) -> Self {
        let mut list = Self { leaves_out: found.leaves_out, ..Self::default() };
        for (place, entry) in found.entries().enumerate() {
            list.values[place / 2] |= entry << (16 * (place % 2));
            list.count += 1;
        }
        list
    }
}

/// Calls `found` with every object whose box is within `radius_m` of `centre`. Returns the number
/// of visited nodes.
pub(crate) fn objects_within(
    hierarchy: &Hierarchy,
    centre: Vec3,
    radius_m: f32,
    mut found: impl FnMut(ObjectId),
) -> usize {
    let mut visits = 0;
    let mut open: Vec<NodeId> = hierarchy.root().into_iter().collect();
    while let Some(node) = open.pop() {
        visits += 1;
        let bounds = hierarchy.bounds(node);
        if bounds.is_empty() || bounds.distance_squared(centre) > radius_m * radius_m {
            continue;
        }
        match hierarchy.children(node) {
            Some(children) => open.extend(children),
            None => {
                let leaf = hierarchy.leaves(node).first;
                if let Some(object) = hierarchy.leaf_objects().get(leaf.0 as usize) {
                    found(*object);
                }
            }
        }
    }
    visits
}
