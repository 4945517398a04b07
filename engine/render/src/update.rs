//! Changes of the scene between frames. They are applied to the hierarchy at once, and to the data
//! on the GPU at the start of the next frame. Nothing waits.

use std::collections::HashSet;
use std::time::Duration;

use cull::{Aabb, LeafRange, ObjectId};
use scene::MeshId;

/// The work of an update.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct UpdateReport {
    /// The CPU time.
    pub cpu: Duration,
    /// The ids of the added objects, in the order of their changes. An id may have belonged to an
    /// object that was removed.
    pub added: Vec<ObjectId>,
    /// The number of meshes whose pose changed.
    pub poses: u32,
    /// The number of inner nodes of the hierarchy whose box was computed again.
    pub refitted_nodes: u64,
    /// The number of leaves below nodes that were rebuilt because movement had degraded them.
    pub rebuilt_leaves: u64,
    /// The number of leaves that the next frame uploads.
    pub dirty_leaves: usize,
    /// True if the whole hierarchy has degraded and is too large to be rebuilt within a frame.
    /// Frames cost more than necessary until
    /// [`Renderer::rebuild_hierarchy`](crate::Renderer::rebuild_hierarchy) is called.
    pub is_degraded: bool,
}

/// The lists of an update in progress, kept to allocate nothing in the steady state.
#[derive(Default)]
pub(crate) struct UpdateScratch {
    /// The box of the object of each change; empty for a removed object.
    pub(crate) bounds: Vec<Aabb>,
    pub(crate) gone: ObjectSet,
    /// The skinned meshes that get an object.
    pub(crate) taken: HashSet<MeshId>,
    pub(crate) moves: Vec<(ObjectId, Aabb)>,
    pub(crate) changed: Vec<ObjectId>,
    pub(crate) reordered: Vec<LeafRange>,
}

/// A set of objects as one bit per id: an update asks it about each object that moves.
#[derive(Default)]
pub(crate) struct ObjectSet {
    words: Vec<u64>,
    objects: Vec<ObjectId>,
}

impl ObjectSet {
    /// Removes all objects, in a time in proportion to their number.
    pub(crate) fn clear(&mut self) {
        for object in self.objects.drain(..) {
            self.words[word_of(object)] = 0;
        }
    }

    pub(crate) fn insert(&mut self, object: ObjectId) {
        let word = word_of(object);
        if word >= self.words.len() {
            self.words.resize(word + 1, 0);
        }
        self.words[word] |= bit_of(object);
        self.objects.push(object);
    }

    #[inline]
    pub(crate) fn contains(&self, object: ObjectId) -> bool {
        self.words.get(word_of(object)).is_some_and(|word| word & bit_of(object) != 0)
    }
}

const fn word_of(object: ObjectId) -> usize {
    (object.0 / u64::BITS) as usize
}

const fn bit_of(object: ObjectId) -> u64 {
    1 << (object.0 % u64::BITS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_has_the_objects_inserted_since_it_was_cleared() {
        let mut set = ObjectSet::default();
        for first in [0, 40] {
            let objects = [0, 1, 63, 64, 900].map(|id| ObjectId(first + id));
            objects.iter().for_each(|object| set.insert(*object));
            for object in (0..2_000).map(ObjectId) {
                assert_eq!(set.contains(object), objects.contains(&object), "{object:?}");
            }
            set.clear();
        }
    }
}
