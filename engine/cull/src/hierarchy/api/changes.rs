//! Changes of a hierarchy: objects move, go and come, and worn parts are rebuilt. The work grows
//! with the changes, not with the scene.

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

/// Memory that a hierarchy holds for each leaf and its two nodes (bytes).
const BYTES_PER_LEAF: usize = Topology::BYTES_PER_LEAF
    + 2 * (Nodes::BYTES + size_of::<Generation>())
    + size_of::<Generation>();

/// The work that changes took, counted since the hierarchy was built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HierarchyWork {
    /// Leaves whose box was set.
    pub placed_leaves: u64,
    /// Inner nodes computed again because something below them moved, came or went.
    pub refitted_nodes: u64,
    /// Leaves in subtrees that were rebuilt.
    pub rebuilt_leaves: u64,
}

impl Hierarchy {
    /// Moves objects: sets their boxes and updates the boxes of their ancestors and no others.
    ///
    /// # Errors
    /// [`HierarchyError::BadBox`] or [`HierarchyError::UnknownObject`] for the first object that
    /// cannot be moved; those before it have been, and the hierarchy is consistent.
    pub fn refit(
        &mut self,
        moved: impl IntoIterator<Item = (ObjectId, Aabb)>,
    ) -> Result<(), HierarchyError> {
        let Self { topology, nodes, refit_scratch, boxes, worn, work, .. } = self;
        let moved = moved.into_iter().inspect(|_| work.placed_leaves += 1);
        let mut refitted = 0;
        let outcome = refit(topology, nodes, refit_scratch, boxes, moved, |nodes, node| {
            refitted += 1;
            worn.consider(topology, nodes, node, LEAVES_PER_UPDATE);
        });
        work.refitted_nodes += refitted;
        outcome
    }

    /// Takes an object out. Its leaf stays, with an [empty](Aabb::EMPTY) box, and so does its id,
    /// until [`Hierarchy::insert`] gives both to another.
    ///
    /// # Errors
    /// [`HierarchyError::UnknownObject`] if it is not there.
    pub fn remove(&mut self, object: ObjectId) -> Result<(), HierarchyError> {
        let before = self.node_of(object).map_or(Aabb::EMPTY, |node| self.bounds(node));
        let node = occupancy::vacate(&self.topology, &mut self.nodes, object)?;
        self.boxes.push(BoxChange { object, before, after: Aabb::EMPTY });
        self.refit_above(node);
        self.list_whole();
        Ok(())
    }

    /// Puts objects in, and adds their ids, in the same order, to `added`. Where there are as many
    /// as there were before, the hierarchy is built again. Else they get the free leaves; where
    /// those are too few, the rest gets leaves behind all others, together with free ones: a
    /// sixteenth of all. Adds the ranges of leaves that are new, or in another order now, to
    /// `reordered`.
    ///
    /// Objects keep their ids, and cullers keep their history.
    ///
    /// # Errors
    /// [`HierarchyError::BadBox`] for the first bad one, by its place in `boxes`;
    /// [`HierarchyError::TooMany`]; [`HierarchyError::NoMemory`]. Nothing is changed then.
    pub fn insert_all(
        &mut self,
        boxes: &[Aabb],
        added: &mut Vec<ObjectId>,
        reordered: &mut Vec<LeafRange>,
    ) -> Result<(), HierarchyError> {
        boxes.iter().enumerate().try_for_each(|(place, bounds)| error::check(place, bounds))?;
        let leaves = self.topology.leaf_objects.len();
        // Most of a scene at once makes a better hierarchy than one part after the other.
        let is_most = boxes.len() >= (leaves - self.free_leaves()).max(leaves / 16);
        if is_most && !boxes.is_empty() {
            self.rebuild_with(boxes, added)?;
            reordered.extend(self.root().map(|root| self.leaves(root)));
            return Ok(());
        }
        let most = boxes.len().min(self.free_leaves());
        let (fitting, rest) = boxes.split_at(most);
        // First what can be refused.
        let mut appended = self.append(rest, reordered)?;
        for bounds in fitting {
            added.push(self.insert(*bounds)?);
        }
        added.append(&mut appended);
        Ok(())
    }

    /// Builds the hierarchy again with more objects.
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

    /// Gives objects leaves behind all others, makes room for some more, and returns their ids.
    /// Nothing is changed where there is nothing to append, or no memory for it.
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
        // What grows is reserved beside the memory that building the subtree takes.
        self.reserve_leaves(new)?;
        build::check_memory(self.leaves(NodeId(root)).count as usize + new)?;
        let mut more = boxes.to_vec();
        more.resize(new, Aabb::EMPTY);
        self.rebuild_below(root, &more, reordered)?;
        let ids: Vec<ObjectId> = (before as u32..wanted as u32).map(ObjectId).collect();
        for (object, bounds) in ids.iter().zip(boxes) {
            self.boxes.push(BoxChange { object: *object, before: Aabb::EMPTY, after: *bounds });
        }
        Ok(ids)
    }

    /// Reserves the memory of more leaves and their nodes, and no more than that: spare leaves
    /// already make growth rare.
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

    /// Puts an object in, in the free leaf where it fits best: one whose object was removed or had
    /// an empty box from the beginning. No view remembers the leaf's former object as the new one,
    /// and results of tests of the former are ignored.
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
        self.boxes.push(BoxChange { object, before: Aabb::EMPTY, after: bounds });
        Ok(object)
    }

    /// Returns the number of objects that can still be inserted.
    #[must_use]
    pub fn free_leaves(&self) -> usize {
        self.nodes.free.first().map_or(0, |free| *free as usize)
    }

    /// Rebuilds subtrees that moving has worn, a bounded number of leaves at a time, the most
    /// rewarding first; the whole only if it is worn as a whole and not large. To be called once
    /// per frame, after the frame's other changes. Adds the ranges whose leaves are in another
    /// order now to `reordered`.
    ///
    /// Objects keep their ids, and cullers keep their history.
    pub fn rebuild_subtrees(&mut self, reordered: &mut Vec<LeafRange>) {
        if self.is_degraded() && self.topology.leaf_objects.len() <= LEAVES_OF_WHOLE as usize {
            // Without memory for it everything stays as it is, here and below.
            let _ = self.rebuild_below(0, &[], reordered);
            return;
        }
        let mut chosen = std::mem::take(&mut self.chosen);
        self.worn.choose(&self.topology, &self.nodes, LEAVES_PER_UPDATE, &mut chosen);
        for node in chosen.drain(..) {
            // A rebuild above or below may have mended it.
            if self.nodes.wear.excess(node, &self.nodes.bounds[node as usize]).is_some() {
                let _ = self.rebuild_below(node, &[], reordered);
            }
        }
        self.chosen = chosen;
    }

    /// Returns true if the hierarchy as a whole is worn, so that a [rebuild](Hierarchy::rebuild) is
    /// worth its time. Up to some ten thousand objects [`Hierarchy::rebuild_subtrees`] does that by
    /// itself.
    #[must_use]
    pub fn is_degraded(&self) -> bool {
        let root = self.nodes.bounds.first();
        root.is_some_and(|bounds| self.nodes.wear.excess(0, bounds).is_some())
    }

    /// Returns the box of each object, by its id; [empty](Aabb::EMPTY) for a free one.
    #[must_use]
    pub fn boxes_of_objects(&self) -> Vec<Aabb> {
        let nodes = self.topology.object_nodes.iter();
        nodes.map(|node| self.bounds(NodeId(*node))).collect()
    }

    /// Builds the hierarchy again, for instance after objects were moved so far that the old shape
    /// is a bad one, or to make room for more. Cullers notice by themselves and carry their history
    /// over by object: an object keeps its id, or else inherits the history of the object that had
    /// the id before.
    ///
    /// # Errors
    /// Those of [`Hierarchy::build`]; the hierarchy is then unchanged.
    pub fn rebuild(&mut self, boxes: &[Aabb]) -> Result<Generation, HierarchyError> {
        let topology = build::topology(boxes)?;
        let moved_from = topology.leaf_objects.iter().map(|object| {
            if boxes[object.0 as usize].is_empty() {
                return FREE_LEAF;
            }
            let before = self.topology.object_nodes.get(object.0 as usize);
            let before = before.filter(|node| self.nodes.free[**node as usize] == 0);
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
        self.worn = rebuild_subtrees::Worn::default();
        self.refit_scratch = super::super::refit::Scratch::default();
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

    /// Returns the work that changes took so far.
    #[must_use]
    pub fn work(&self) -> HierarchyWork {
        self.work
    }

    /// Returns true if a node stood for the same in `generation` as now, so that results from then
    /// still hold.
    #[must_use]
    pub fn is_same_since(&self, node: NodeId, generation: Generation) -> bool {
        let born = self.births.get(node.0 as usize);
        generation <= self.generation && born.is_some_and(|born| *born <= generation)
    }

    /// Returns true if an object is there and was there in `generation`, so that results from then
    /// are not about an earlier object with the same id.
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

    /// Returns the changes of objects' boxes after the first `count`, the oldest first: moves, also
    /// to the same box, removals and insertions. `None` if they are not known any more: after a
    /// [rebuild](Hierarchy::rebuild), or more changes than are held.
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
        occupancy::refit_above(topology, nodes, leaf, |nodes, node| {
            work.refitted_nodes += 1;
            worn.consider(topology, nodes, node, LEAVES_PER_UPDATE);
        });
    }

    /// Rebuilds a subtree, with `more` leaves if it is the last one.
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

    /// Numbers a change. After 2^32 of them the numbers start again: no history and no result is
    /// older than that.
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
        // As much as a few full rebuilds are: enough for views that pause for a while.
        const ENTRIES_MIN: usize = 1 << 14;
        let most_entries = ENTRIES_MIN.max(8 * self.topology.nodes.len());
        self.journal.push(generation, change, most_entries);
        self.list_whole();
    }
}
