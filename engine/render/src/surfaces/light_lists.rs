//! Which points' and spots' lights reach which object: a list of a bounded number for each, the strongest
//! first.

use cull::{Aabb, Hierarchy, NodeId, ObjectId};
use glam::Vec3;

use crate::scene::{LightKind, PunctualLight};
use crate::surfaces::lights::{LightTable, is_bright, reach_m, strongest_part};

/// The most points' and spots' lights that shine on an object; weaker ones are left out.
pub const MAX_LIGHTS_PER_OBJECT: usize = 16;

/// Two lights a word.
pub(crate) const LIST_WORDS: usize = MAX_LIGHTS_PER_OBJECT / 2;

/// The most lights of a scene: a place in the light table has 16 bits.
pub const MAX_LIGHTS: usize = 1 << 16;

/// What decides whether a light reaches a box.
#[derive(Clone, Copy, Debug)]
struct Reach {
    /// Its place in the light table.
    entry: u32,
    position: Vec3,
    reach_m: f32,
    candela: f32,
}

/// A list as the shaders read it, and its length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct LightList {
    words: [u32; LIST_WORDS],
    count: u32,
}

/// The lists of all objects, by slots: first the objects by their ids, then what is blended.
#[derive(Debug, Default)]
pub struct LightLists {
    /// Whether there is anything but directional lights; a dark one may be lit later.
    has_lights: bool,
    /// `None` of directional lights, and of those that give no light.
    reaches: Vec<Option<Reach>>,
    lists: Vec<LightList>,
    /// Slots whose list the GPU does not have yet.
    stale: Vec<u32>,
    is_stale: Vec<bool>,
}

impl LightLists {
    /// Lists for so many slots, all of them empty.
    pub(crate) fn new(table: &LightTable, slots: usize) -> Self {
        let reaches = table.lights.iter().zip(&table.places);
        let is_local = |light: &PunctualLight| light.kind != LightKind::Directional;
        Self {
            has_lights: table.lights.iter().any(is_local),
            reaches: reaches.map(|(light, entry)| Reach::of(light, *entry)).collect(),
            lists: vec![LightList::default(); slots],
            stale: Vec::new(),
            is_stale: vec![false; slots],
        }
    }

    /// Whether there is anything but directional lights.
    pub(crate) fn has_lights(&self) -> bool {
        self.has_lights
    }

    /// How many lights reach what is in a slot.
    #[must_use]
    pub fn count(&self, slot: u32) -> u32 {
        self.lists.get(slot as usize).map_or(0, |list| list.count)
    }

    /// The lights that reach what is in a slot, the strongest first, as places in the light table.
    #[must_use]
    pub fn entries(&self, slot: u32) -> Vec<u32> {
        let list = self.lists.get(slot as usize).copied().unwrap_or_default();
        let entry = |place: usize| list.words[place / 2] >> (16 * (place % 2)) & 0xFFFF;
        (0..list.count as usize).map(entry).collect()
    }

    /// Finds the lists of all objects of a hierarchy, light by light.
    pub(crate) fn fill(&mut self, hierarchy: &Hierarchy) {
        let mut found: Vec<Vec<Reach>> = vec![Vec::new(); self.lists.len()];
        for reach in self.reaches.iter().flatten() {
            objects_within(hierarchy, reach.position, reach.reach_m, |object| {
                if let Some(found) = found.get_mut(object.0 as usize) {
                    found.push(*reach);
                }
            });
        }
        for ((slot, found), list) in (0..).zip(&mut found).zip(&mut self.lists) {
            let Some(node) = hierarchy.node_of(ObjectId(slot)) else { continue };
            *list = LightList::of(found, &hierarchy.bounds(node));
        }
    }

    /// Finds the list of what is in a slot, in a box of the world; answers whether it is another than it was.
    pub(crate) fn find(&mut self, slot: u32, bounds: &Aabb) -> bool {
        let mut found: Vec<Reach> =
            self.reaches.iter().flatten().filter(|reach| reach.meets(bounds)).copied().collect();
        let now = LightList::of(&mut found, bounds);
        let place = slot as usize;
        let (Some(list), Some(is_stale)) =
            (self.lists.get_mut(place), self.is_stale.get_mut(place))
        else {
            return false;
        };
        if std::mem::replace(list, now) == now {
            return false;
        }
        if !std::mem::replace(is_stale, true) {
            self.stale.push(slot);
        }
        true
    }

    /// A light is another now, at the same place in the table. Answers where the objects are whose lists
    /// must be found again: around its old and around its new place, centre and radius in metres.
    pub(crate) fn replace(
        &mut self,
        light: usize,
        entry: Option<u32>,
        to: &PunctualLight,
    ) -> Vec<(Vec3, f32)> {
        let now = Reach::of(to, entry);
        let before = match self.reaches.get_mut(light) {
            Some(reach) => std::mem::replace(reach, now),
            None => None,
        };
        [before, now].into_iter().flatten().map(|reach| (reach.position, reach.reach_m)).collect()
    }

    /// Slots whose lists the GPU does not have.
    pub(crate) fn stale(&self) -> &[u32] {
        &self.stale
    }

    /// The list in a slot as the shaders read it.
    pub(crate) fn words(&self, slot: u32) -> [u32; LIST_WORDS] {
        self.lists.get(slot as usize).map(|list| list.words).unwrap_or_default()
    }

    /// All lists, in the order of slots.
    pub(crate) fn all_words(&self) -> Vec<[u32; LIST_WORDS]> {
        self.lists.iter().map(|list| list.words).collect()
    }

    /// The GPU has all lists.
    pub(crate) fn submitted(&mut self) {
        for slot in self.stale.drain(..) {
            if let Some(is_stale) = self.is_stale.get_mut(slot as usize) {
                *is_stale = false;
            }
        }
    }
}

impl Reach {
    fn of(light: &PunctualLight, entry: Option<u32>) -> Option<Self> {
        let is_local = light.kind != LightKind::Directional && is_bright(light);
        let entry = entry.filter(|_| is_local)?;
        let (position, candela) = (light.position, strongest_part(light));
        Some(Self { entry, position, reach_m: reach_m(light), candela })
    }

    fn meets(&self, bounds: &Aabb) -> bool {
        bounds.distance_squared(self.position) <= self.reach_m * self.reach_m
    }

    /// What arrives where the box is nearest, in lux.
    fn strength(&self, bounds: &Aabb) -> f32 {
        self.candela / bounds.distance_squared(self.position).max(1.0e-4)
    }
}

impl LightList {
    /// The strongest of those found; of equal ones the first in the table.
    fn of(found: &mut [Reach], bounds: &Aabb) -> Self {
        found.sort_by(|a, b| {
            let strength = b.strength(bounds).total_cmp(&a.strength(bounds));
            strength.then(a.entry.cmp(&b.entry))
        });
        let count = found.len().min(MAX_LIGHTS_PER_OBJECT);
        let mut list = Self { count: count as u32, ..Self::default() };
        for (place, reach) in found.iter().take(count).enumerate() {
            list.words[place / 2] |= reach.entry << (16 * (place % 2));
        }
        list
    }
}

/// Calls `found` with every object whose box is within `radius_m` of `centre`.
pub(crate) fn objects_within(
    hierarchy: &Hierarchy,
    centre: Vec3,
    radius_m: f32,
    mut found: impl FnMut(ObjectId),
) {
    let mut open: Vec<NodeId> = hierarchy.root().into_iter().collect();
    while let Some(node) = open.pop() {
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
}
