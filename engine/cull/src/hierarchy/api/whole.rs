//! The objects that section planes leave whole. Nodes above them are not cut away.

use std::collections::BTreeSet;

use super::super::Hierarchy;
use crate::geom::section::SectionMember;
use crate::ids::{LeafIndex, NodeId, ObjectId};

/// Objects, and their leaves in order: a subtree contains such an object if a leaf is in its range.
#[derive(Clone, Debug, Default)]
pub(crate) struct WholeObjects {
    objects: BTreeSet<ObjectId>,
    leaves: Vec<LeafIndex>,
}

impl Hierarchy {
    /// Sets whether section planes cut an object or leave it whole from now on. Has no effect on an
    /// object that is not in the hierarchy. An object that reuses a free id is cut.
    pub fn set_section_member(&mut self, object: ObjectId, member: SectionMember) {
        let is_changed = match member {
            SectionMember::Whole => self.contains(object) && self.whole.objects.insert(object),
            SectionMember::Cut => self.whole.objects.remove(&object),
        };
        if is_changed {
            self.list_whole();
        }
    }

    /// Returns the effect of section planes on an object.
    #[must_use]
    pub fn section_member(&self, object: ObjectId) -> SectionMember {
        if self.whole.objects.contains(&object) { SectionMember::Whole } else { SectionMember::Cut }
    }

    /// Returns the leaves that section planes leave whole, in their order.
    #[must_use]
    pub fn whole_leaves(&self) -> &[LeafIndex] {
        &self.whole.leaves
    }

    /// Returns true if section planes leave some object under a node whole, wherever it lies.
    #[must_use]
    pub fn has_whole(&self, node: NodeId) -> bool {
        if self.whole.leaves.is_empty() {
            return false;
        }
        let range = self.leaves(node);
        let place = self.whole.leaves.partition_point(|leaf| *leaf < range.first);
        self.whole.leaves.get(place).is_some_and(|leaf| range.contains(*leaf))
    }

    /// Updates the list of leaves after their positions changed.
    pub(crate) fn list_whole(&mut self) {
        if self.whole.objects.is_empty() && self.whole.leaves.is_empty() {
            return;
        }
        let mut whole = std::mem::take(&mut self.whole);
        whole.objects.retain(|object| self.contains(*object));
        whole.leaves.clear();
        whole.leaves.extend(whole.objects.iter().filter_map(|object| self.leaf_of(*object)));
        whole.leaves.sort_unstable();
        self.whole = whole;
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geom::bounds::Aabb;

    fn row(count: u32) -> Vec<Aabb> {
        let at = |x: u32| Vec3::new(x as f32 * 2.0, 0.0, 0.0);
        (0..count).map(|x| Aabb::new(at(x), at(x) + 1.0)).collect()
    }

    fn wholes(hierarchy: &Hierarchy) -> Vec<ObjectId> {
        let objects = hierarchy.leaf_objects();
        let mut found: Vec<ObjectId> =
            hierarchy.whole_leaves().iter().map(|leaf| objects[leaf.0 as usize]).collect();
        found.sort_unstable();
        found
    }

    #[test]
    fn exactly_the_nodes_above_a_whole_object_have_one() {
        let mut hierarchy = Hierarchy::build(&row(9)).unwrap();
        let object = ObjectId(4);
        hierarchy.set_section_member(object, SectionMember::Whole);
        let leaf = hierarchy.leaf_of(object).unwrap();
        for node in (0..hierarchy.node_count() as u32).map(NodeId) {
            assert_eq!(hierarchy.has_whole(node), hierarchy.leaves(node).contains(leaf));
        }
        hierarchy.set_section_member(object, SectionMember::Cut);
        assert!(!hierarchy.has_whole(NodeId(0)));
    }

    #[test]
    fn whole_objects_stay_so_when_leaves_move_and_their_ids_are_cut_again_when_they_go() {
        let mut hierarchy = Hierarchy::build(&row(9)).unwrap();
        for object in [2, 7].map(ObjectId) {
            hierarchy.set_section_member(object, SectionMember::Whole);
        }
        let mut boxes = row(9);
        boxes.reverse();
        hierarchy.rebuild(&boxes).unwrap();
        assert_eq!(wholes(&hierarchy), [2, 7].map(ObjectId));
        hierarchy.remove(ObjectId(2)).unwrap();
        assert_eq!(wholes(&hierarchy), [ObjectId(7)]);
        assert_eq!(hierarchy.insert(boxes[2]), Ok(ObjectId(2)));
        assert_eq!(hierarchy.section_member(ObjectId(2)), SectionMember::Cut);
        hierarchy.set_section_member(ObjectId(99), SectionMember::Whole);
        assert_eq!(wholes(&hierarchy), [ObjectId(7)], "an object that is not there");
    }
}
