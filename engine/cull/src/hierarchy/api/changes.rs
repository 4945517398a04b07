//! Changes of a hierarchy: moves, removals and insertions of objects, and rebuilds of worn parts.
//! The work grows with the changes, not with the scene.

use super::super::box_log::BoxChange;
use super::super::journal::{Change, FREE_LEAF, Journal, NEW_LEAF, Restructured};
use super::super::refit::{Nodes, refit};
use super::super::topology::Topology;
use super::super::wear::{LEAVES_OF_WHOLE, LEAVES_PER_UPDATE};
use super::super::{
    Hierarchy, HierarchyError, MAX_OBJECTS, build, error, occupancy, rebuild_subtrees,
};
use crate::geom::bounds::Aabb;
use crate::ids::{Generation, LeafRange, NodeId, ObjectId};

/// The memory that a hierarchy holds per leaf and its two nodes (bytes).
const BYTES_PER_LEAF: usize = Topology::BYTES_PER_LEAF
    + 2 * (Nodes::BYTES + size_of::<Generation>())
    + size_of::<Generation>();

/// The work of all changes since the hierarchy was built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HierarchyWork {
    /// The number of leaves whose box was set.
    pub placed_leaves: u64,
    /// The number of inner nodes updated because an object below them was moved, inserted or
    /// removed.
    pub refitted_nodes: u64,
    /// The number of leaves in subtrees that were rebuilt.
    pub rebuilt_leaves: u64,
}

impl Hierarchy {
    /// Moves objects: sets their boxes and updates only the boxes of their ancestors.
    ///
    /// # Errors
    /// [`HierarchyError::BadBox`] or [`HierarchyError::UnknownObject`] for the first object that
    /// cannot be moved. The objects before it are moved, and the hierarchy is consistent.
    pub fn refit(
        &mut self,
        moved: impl IntoIterator<Item = (ObjectId, Aabb)>,
    ) -> Result<(), HierarchyError> {
        let Self { topology, nodes, stale, boxes, worn, work, .. } = self;
        let moved = moved.into_iter().inspect(|_| work.placed_leaves += 1);
        let mut refitted = 0;
        let outcome = refit(topology, nodes, stale, boxes, moved, |wear, node, data| {
            refitted += 1;
            worn.consider(topology, wear, node, data);
        });
        work.refitted_nodes += refitted;
        outcome
    }

    /// Removes an object. Its leaf stays, with an [empty](Aabb::EMPTY) box, until
    /// [`Hierarchy::insert`] gives the leaf and the id to another object.
    ///
    /// # Errors
    /// [`HierarchyError::UnknownObject`] if the object is not in the hierarchy.
    pub fn remove(&mut self, object: ObjectId) -> Result<(), HierarchyError> {
        let before = self.node_of(object).map_or(Aabb::EMPTY, |node| self.bounds(node));
        let node = occupancy::vacate(&self.topology, &mut self.nodes, object)?;
        let objects = self.topology.object_nodes.len();
        self.boxes.push(BoxChange { object, before, after: Aabb::EMPTY }, objects);
        self.refit_above(node);
        self.list_whole();
        Ok(())
    }

    /// Inserts objects and adds their ids to `added`, in the same order. If `boxes` has at least as
    /// many objects as the hierarchy, the hierarchy is rebuilt. Otherwise the objects get the free
    /// leaves; if there are too few, the rest get new leaves after all others, together with spare
    /// leaves: a sixteenth of all. Adds the ranges of leaves that are new or in another order to
    /// `reordered`.
    ///
    /// Objects keep their ids, and cullers keep their history.
    ///
    /// # Errors
    /// [`HierarchyError::BadBox`] for the first unusable box, by its index in `boxes`;
    /// [`HierarchyError::TooMany`]; [`HierarchyError::NoMemory`]. The hierarchy is then unchanged.
    pub fn insert_all(
        &mut self,
        boxes: &[Aabb],
        added: &mut Vec<ObjectId>,
        reordered: &mut Vec<LeafRange>,
    ) -> Result<(), HierarchyError> {
        boxes.iter().enumerate().try_for_each(|(place, bounds)| error::check(place, bounds))?;
        let leaves = self.topology.leaf_objects.len();
        // Building most of a scene at once gives a better hierarchy than inserting its parts.
        let is_most = boxes.len() >= (leaves - self.free_leaves()).max(leaves / 16);
        if is_most && !boxes.is_empty() {
            self.rebuild_with(boxes, added)?;
            reordered.extend(self.root().map(|root| self.leaves(root)));
            return Ok(());
        }
        let most = boxes.len().min(self.free_leaves());
        let (fitting, rest) = boxes.split_at(most);
        // The append comes first because it can fail.
        let mut appended = self.append(rest, reordered)?;
        for bounds in fitting {
            added.push(self.insert(*bounds)?);
        }
        added.append(&mut appended);
        Ok(())
    }

    /// Rebuilds the hierarchy with more objects.
    fn rebuild_with(
        &mut self,
        boxes: &[Aabb],
        added: &mut Vec<ObjectId>,
    ) -> Result<(), HierarchyError> {
        let before = self.topology.leaf_objects.len();
        let wanted = before - self.free_leaves() + boxes.len();
        build::check_capacity(wanted)?;
        let mut all = self.boxes_of_objects();
        all.resize(before.max(wanted), Aabb::EMPTY);
        let places = (0..).map(ObjectId).zip(&mut all).filter(|(_, place)| place.is_empty());
        let mut ids = Vec::with_capacity(boxes.len());
        for ((id, place), bounds) in places.zip(boxes) {
            *place = *bounds;
            ids.push(id);
        }
        self.rebuild(&all)?;
        added.append(&mut ids);
        Ok(())
    }

    /// Appends leaves for objects after all others, with spare leaves, and returns the ids. Changes
    /// nothing if `boxes` is empty or memory is missing.
    fn append(
        &mut self,
        boxes: &[Aabb],
        reordered: &mut Vec<LeafRange>,
    ) -> Result<Vec<ObjectId>, HierarchyError> {
        const SPARE_MIN: usize = 8;
        if boxes.is_empty() {
            return Ok(Vec::new());
        }
        let before = self.topology.leaf_objects.len();
        let wanted = before + boxes.len();
        build::check_count(wanted)?;
        let spare = (before / 16).max(SPARE_MIN).min(MAX_OBJECTS - wanted);
        let new = boxes.len() + spare;
        let root = rebuild_subtrees::last_subtree(&self.topology, LEAVES_PER_UPDATE);
        // This memory is needed in addition to the memory for building the subtree.
        self.reserve_leaves(new)?;
        build::check_memory(self.leaves(NodeId(root)).count as usize + new)?;
        let mut more = boxes.to_vec();
        more.resize(new, Aabb::EMPTY);
        self.rebuild_below(root, &more, reordered)?;
        let ids: Vec<ObjectId> = (before as u32..wanted as u32).map(ObjectId).collect();
        for (object, bounds) in ids.iter().zip(boxes) {
            let change = BoxChange { object: *object, before: Aabb::EMPTY, after: *bounds };
            self.boxes.push(change, self.topology.object_nodes.len());
        }
        Ok(ids)
    }

    /// Reserves exactly the memory for more leaves and their nodes: spare leaves already make
    /// growth rare.
    fn reserve_leaves(&mut self, new: usize) -> Result<(), HierarchyError> {
        let reserved = self
            .topology
            .try_reserve(new)
            .and_then(|()| self.nodes.try_reserve(2 * new))
            .and_then(|()| self.births.try_reserve_exact(2 * new))
            .and_then(|()| self.arrivals.try_reserve_exact(new));
        reserved.map_err(|_| {
            let count = self.topology.leaf_objects.len() + new;
            HierarchyError::NoMemory { count, size_bytes: count * BYTES_PER_LEAF }
        })
    }

    /// Inserts an object into the free leaf where it fits best. A leaf is free if its object was
    /// removed or had an empty box from the beginning. The new object does not inherit the history
    /// of the former object, and results of tests of the former object are ignored.
    ///
    /// # Errors
    /// [`HierarchyError::BadBox`]; [`HierarchyError::NoFreeLeaf`].
    pub fn insert(&mut self, bounds: Aabb) -> Result<ObjectId, HierarchyError> {
        let node = occupancy::occupy(&self.topology, &mut self.nodes, &mut self.search, bounds)?;
        self.refit_above(node);
        let generation = self.begin_generation();
        self.births[node as usize] = generation;
        self.note(generation, Change::Recycled(node));
        let leaf = self.topology.nodes[node as usize].first_leaf;
        let object = self.topology.leaf_objects[leaf as usize];
        self.arrivals[object.0 as usize] = generation;
        let objects = self.topology.object_nodes.len();
        self.boxes.push(BoxChange { object, before: Aabb::EMPTY, after: bounds }, objects);
        Ok(object)
    }

    /// Returns the number of objects that can still be inserted.
    #[must_use]
    pub fn free_leaves(&self) -> usize {
        self.nodes.all.first().map_or(0, |root| root.free() as usize)
    }

    /// Rebuilds subtrees that are worn by moves, a bounded number of leaves per call, the most
    /// worthwhile first. Rebuilds the whole hierarchy only if it is worn as a whole and small. Call
    /// this once per frame, after the other changes of the frame. Adds the ranges of leaves that
    /// are in another order to `reordered`.
    ///
    /// Objects keep their ids, and cullers keep their history.
    pub fn rebuild_subtrees(&mut self, reordered: &mut Vec<LeafRange>) {
        if self.is_degraded() && self.topology.leaf_objects.len() <= LEAVES_OF_WHOLE as usize {
            // Without memory for a rebuild the hierarchy stays unchanged, here and below.
            let _ = self.rebuild_below(0, &[], reordered);
            return;
        }
        let mut chosen = std::mem::take(&mut self.chosen);
        self.worn.choose(&self.topology, &self.nodes, LEAVES_PER_UPDATE, &mut chosen);
        for node in chosen.drain(..) {
            // A rebuild above or below may have repaired it.
            if self.nodes.excess(node).is_some() {
                let _ = self.rebuild_below(node, &[], reordered);
            }
        }
        self.chosen = chosen;
    }

    /// Returns true if the hierarchy as a whole is worn, so that a [rebuild](Hierarchy::rebuild) is
    /// worth its time. [`Hierarchy::rebuild_subtrees`] includes this rebuild up to some ten
    /// thousand objects.
    #[must_use]
    pub fn is_degraded(&self) -> bool {
        self.nodes.excess(0).is_some()
    }

    /// Returns the box of each object, by its id; [empty](Aabb::EMPTY) for a free id.
    #[must_use]
    pub fn boxes_of_objects(&self) -> Vec<Aabb> {
        let nodes = self.topology.object_nodes.iter();
        nodes.map(|node| self.bounds(NodeId(*node))).collect()
    }

    /// Rebuilds the hierarchy, for instance after objects moved so far that its shape is bad, or to
    /// make room for more objects. Cullers notice the rebuild and carry their history over by
    /// object: an object with an id that was in use before inherits the history of this id.
    ///
    /// # Errors
    /// The errors of [`Hierarchy::build`]; the hierarchy is then unchanged.
    pub fn rebuild(&mut self, boxes: &[Aabb]) -> Result<Generation, HierarchyError> {
        let topology = build::topology(boxes)?;
        let moved_from = topology.leaf_objects.iter().map(|object| {
            if boxes[object.0 as usize].is_empty() {
                return FREE_LEAF;
            }
            let before = self.topology.object_nodes.get(object.0 as usize);
            let before = before.filter(|node| self.nodes.all[**node as usize].free() == 0);
            before.map_or(NEW_LEAF, |node| self.topology.nodes[*node as usize].first_leaf)
        });
        let leaf_counts = |topology: &Topology| {
            topology.nodes.iter().map(|links| links.leaf_count).collect::<Vec<u32>>()
        };
        let change = Restructured {
            root: 0,
            before: leaf_counts(&self.topology),
            after: leaf_counts(&topology),
            moved_from: moved_from.collect(),
        };
        self.nodes = Nodes::new(&topology, boxes);
        self.topology = topology;
        self.boxes.clear();
        self.worn = rebuild_subtrees::Worn::new(self.topology.nodes.len());
        self.work.rebuilt_leaves += boxes.len() as u64;
        let generation = self.begin_generation();
        self.births = vec![generation; self.topology.nodes.len()];
        self.arrivals.resize(boxes.len(), generation);
        let leaves = change.moved_from.iter().zip(&self.topology.leaf_objects);
        for (_, object) in leaves.filter(|(moved_from, _)| **moved_from == NEW_LEAF) {
            self.arrivals[object.0 as usize] = generation;
        }
        self.note(generation, Change::Restructured(Box::new(change)));
        Ok(generation)
    }

    /// Returns the work of all changes so far.
    #[must_use]
    pub fn work(&self) -> HierarchyWork {
        self.work
    }

    /// Returns true if a node has had the same meaning since `generation`, so that results from
    /// then are still valid.
    #[must_use]
    pub fn is_same_since(&self, node: NodeId, generation: Generation) -> bool {
        let born = self.births.get(node.0 as usize);
        generation <= self.generation && born.is_some_and(|born| *born <= generation)
    }

    /// Returns true if an object is in the hierarchy and has been since `generation`, so that
    /// results from then are not about an earlier object with the same id.
    #[must_use]
    pub fn is_same_object_since(&self, object: ObjectId, generation: Generation) -> bool {
        let arrived = self.arrivals.get(object.0 as usize);
        self.contains(object)
            && generation <= self.generation
            && arrived.is_some_and(|arrived| *arrived <= generation)
    }

    /// Returns the number of changes of boxes so far, for [`Hierarchy::box_changes_since`].
    #[must_use]
    pub fn box_changes(&self) -> u64 {
        self.boxes.count()
    }

    /// Returns the changes of objects' boxes after the first `count`, the oldest first: moves (also
    /// to the same box), removals and insertions. `None` if some of them are no longer held, after
    /// a [rebuild](Hierarchy::rebuild) or after too many changes.
    #[must_use]
    pub fn box_changes_since(&self, count: u64) -> Option<impl Iterator<Item = &BoxChange>> {
        self.boxes.since(count)
    }

    pub(crate) fn journal(&self) -> &Journal {
        &self.journal
    }

    fn refit_above(&mut self, leaf: u32) {
        let Self { topology, nodes, worn, work, .. } = self;
        work.placed_leaves += 1;
        occupancy::refit_above(topology, nodes, leaf, |wear, node, data| {
            work.refitted_nodes += 1;
            worn.consider(topology, wear, node, data);
        });
    }

    /// Rebuilds a subtree. `more` adds leaves to it, which only the last subtree allows.
    fn rebuild_below(
        &mut self,
        root: u32,
        more: &[Aabb],
        reordered: &mut Vec<LeafRange>,
    ) -> Result<(), HierarchyError> {
        let Self { topology, nodes, .. } = self;
        let change = rebuild_subtrees::rebuild_subtree(topology, nodes, root, more)?;
        let leaves = self.leaves(NodeId(root));
        self.work.rebuilt_leaves += u64::from(leaves.count);
        let generation = self.begin_generation();
        self.births.resize(self.topology.nodes.len(), generation);
        self.arrivals.resize(self.topology.leaf_objects.len(), generation);
        let end = root as usize + change.after.len();
        if let Some(births) = self.births.get_mut(root as usize..end) {
            births.fill(generation);
        }
        self.note(generation, Change::Restructured(Box::new(change)));
        reordered.push(leaves);
        Ok(())
    }

    /// Returns the number of a new change. After 2^32 changes the numbers start again: no history
    /// and no result is older than that.
    fn begin_generation(&mut self) -> Generation {
        match self.generation.0.checked_add(1) {
            Some(next) => self.generation = Generation(next),
            None => {
                self.generation = Generation(1);
                self.births.fill(self.generation);
                self.arrivals.fill(self.generation);
                self.journal.clear();
            }
        }
        self.generation
    }

    fn note(&mut self, generation: Generation, change: Change) {
        // The size of a few full rebuilds: enough for views that pause for a while.
        const ENTRIES_MIN: usize = 1 << 14;
        let most_entries = ENTRIES_MIN.max(8 * self.topology.nodes.len());
        self.journal.push(generation, change, most_entries);
        self.list_whole();
    }
}
