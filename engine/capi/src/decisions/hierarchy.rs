//! The hierarchy over the boxes of objects.

use std::fmt::Display;

use cull::{Aabb, Hierarchy, HierarchyError, LeafRange, ObjectId};
use glam::Vec3;

use crate::error::Failure;
use crate::layout::{Versioned, layout, versioned};
use crate::table::handle;

/// The object number of a leaf without an object.
pub const ANTUMBRA_NO_OBJECT: u32 = u32::MAX;

/// A hierarchy of bounding volumes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraHierarchy {
    /// The number of the handle; 0 for none.
    pub id: u64,
}
handle!(AntumbraHierarchy = "hierarchy");

/// An axis-aligned box in world space (metres). Coordinates are finite and at most 1e15, and no
/// minimum is above its maximum.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AntumbraAabb {
    /// The corner with the smallest coordinates.
    pub min: [f32; 3],
    /// The corner with the largest coordinates.
    pub max: [f32; 3],
}
layout!(AntumbraAabb: min, max);

impl From<AntumbraAabb> for Aabb {
    fn from(bounds: AntumbraAabb) -> Self {
        Self::new(Vec3::from(bounds.min), Vec3::from(bounds.max))
    }
}

impl From<Aabb> for AntumbraAabb {
    fn from(bounds: Aabb) -> Self {
        Self { min: bounds.min.to_array(), max: bounds.max.to_array() }
    }
}

/// The objects of a new hierarchy.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraHierarchyDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Must be 0.
    pub reserved: u32,
    /// The boxes of the objects; the position of a box is its object's id. They are copied.
    /// Default: null, with a `box_count` of 0.
    pub boxes: *const AntumbraAabb,
    /// The number of boxes, up to 2^30. Default: 0.
    pub box_count: usize,
    /// The number of objects that fit before the hierarchy must grow, up to 2^30. A value below
    /// `box_count` counts as `box_count`. Default: 0.
    pub capacity: usize,
}
layout!(AntumbraHierarchyDesc: struct_size, reserved, boxes, box_count, capacity);

versioned!(AntumbraHierarchyDesc: 4, required: [], defaults: {});

/// The leaves of a hierarchy, in the order that plans refer to. Objects near each other in space
/// are near each other in this order, and a test decides about one range of leaves.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraLeaves {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Is 0.
    pub reserved: u32,
    /// The object of each leaf; `ANTUMBRA_NO_OBJECT` for a leaf without one. Valid until objects
    /// are added or removed, or the hierarchy is updated or rebuilt. Moves change nothing.
    pub objects: *const u32,
    /// The number of leaves.
    pub count: usize,
    /// A number that changes whenever an entry of `objects` changes.
    pub revision: u64,
}
layout!(AntumbraLeaves: struct_size, reserved, objects, count, revision);

versioned!(AntumbraLeaves: 5, required: [], defaults: {});

/// A hierarchy that grows when needed, and the objects of its leaves as C reads them.
pub(crate) struct BoxHierarchy {
    pub hierarchy: Hierarchy,
    leaf_objects: Vec<u32>,
    revision: u64,
    /// Scratch memory, kept to avoid allocations.
    reordered: Vec<LeafRange>,
}

impl BoxHierarchy {
    pub fn new(boxes: &[AntumbraAabb], capacity: usize) -> Result<Self, Failure> {
        let count = boxes.len().max(capacity);
        if count > cull::MAX_OBJECTS {
            return Err(HierarchyError::TooMany { count }.into());
        }
        let mut all = Vec::with_capacity(count);
        for (number, bounds) in boxes.iter().enumerate() {
            all.push(usable(format_args!("desc.boxes[{number}]"), *bounds)?);
        }
        all.resize(count, Aabb::EMPTY);
        let boxes = all;
        let hierarchy = Hierarchy::build(&boxes)?;
        let mut new =
            Self { hierarchy, leaf_objects: Vec::new(), revision: 0, reordered: Vec::new() };
        new.list_all_leaves();
        Ok(new)
    }

    /// Returns the objects of the leaves, as a pointer into `self`.
    pub fn leaves(&self) -> AntumbraLeaves {
        AntumbraLeaves {
            objects: self.leaf_objects.as_ptr(),
            count: self.leaf_objects.len(),
            revision: self.revision,
            ..AntumbraLeaves::INIT
        }
    }

    /// Notes the objects of all leaves.
    fn list_all_leaves(&mut self) {
        let count = self.hierarchy.leaf_objects().len();
        self.leaf_objects.resize(count, ANTUMBRA_NO_OBJECT);
        self.list_leaves(0..count);
    }

    /// Notes the objects of the ranges that a change listed.
    fn list_reordered(&mut self) {
        let mut reordered = std::mem::take(&mut self.reordered);
        self.leaf_objects.resize(self.hierarchy.leaf_objects().len(), ANTUMBRA_NO_OBJECT);
        for range in reordered.drain(..) {
            self.list_leaves(range.indices());
        }
        self.reordered = reordered;
    }

    /// Notes the objects of a range of leaves.
    fn list_leaves(&mut self, range: std::ops::Range<usize>) {
        for leaf in range {
            let object = self.hierarchy.leaf_objects()[leaf];
            let is_there = self.hierarchy.contains(object);
            self.leaf_objects[leaf] = if is_there { object.0 } else { ANTUMBRA_NO_OBJECT };
        }
        self.revision += 1;
    }

    /// Notes an object in the entry of its leaf.
    fn list_leaf_of(&mut self, object: ObjectId) {
        if let Some(leaf) = self.hierarchy.leaf_of(object) {
            self.list_leaves(leaf.0 as usize..leaf.0 as usize + 1);
        }
    }

    pub fn move_objects(&mut self, objects: &[u32], boxes: &[AntumbraAabb]) -> Result<(), Failure> {
        let boxes = boxes.iter().map(|bounds| Aabb::from(*bounds));
        let mut taken = 0_usize;
        let moves = objects.iter().map(|object| ObjectId(*object)).zip(boxes);
        let outcome = self.hierarchy.refit(moves.inspect(|_| taken += 1));
        // The last one that was taken is the one that was refused.
        outcome.map_err(|error| {
            Failure::from(error).within(format_args!("objects[{}]", taken.saturating_sub(1)))
        })
    }

    /// Adds objects and returns their ids.
    pub fn insert(&mut self, boxes: &[AntumbraAabb]) -> Result<Vec<ObjectId>, Failure> {
        let boxes = boxes
            .iter()
            .enumerate()
            .map(|(number, bounds)| usable(format_args!("boxes[{number}]"), *bounds));
        let boxes = boxes.collect::<Result<Vec<Aabb>, Failure>>()?;
        let mut added = Vec::with_capacity(boxes.len());
        self.hierarchy.insert_all(&boxes, &mut added, &mut self.reordered)?;
        self.list_reordered();
        added.iter().for_each(|object| self.list_leaf_of(*object));
        Ok(added)
    }

    pub fn rebuild(&mut self) -> Result<(), Failure> {
        self.hierarchy.rebuild(&self.hierarchy.boxes_of_objects())?;
        self.list_all_leaves();
        Ok(())
    }

    pub fn remove(&mut self, objects: &[u32]) -> Result<(), Failure> {
        for (number, object) in objects.iter().map(|object| ObjectId(*object)).enumerate() {
            let place = format_args!("objects[{number}]");
            self.hierarchy.remove(object).map_err(|error| Failure::from(error).within(place))?;
            self.list_leaf_of(object);
        }
        Ok(())
    }

    pub fn update(&mut self) {
        self.hierarchy.rebuild_subtrees(&mut self.reordered);
        self.list_reordered();
    }
}

/// Checks that an object can have a box, and returns the box. Messages call the box `name`.
pub(crate) fn usable(name: impl Display, bounds: AntumbraAabb) -> Result<Aabb, Failure> {
    let usable = Some(Aabb::from(bounds)).filter(Aabb::is_usable);
    usable.ok_or_else(|| {
        Failure::argument(format_args!(
            "{name} is no box, from {:?} to {:?}: coordinates must be finite, at most \
             1e15, and none of min above that of max",
            bounds.min, bounds.max
        ))
    })
}
