//! The draws of objects, with the cells that they are in.

use std::mem::replace;

use cull::{LeafIndex, ObjectId};

use super::{BucketDraw, NONE};

/// A draw and its cell.
#[derive(Clone, Copy)]
pub(super) struct PlacedDraw {
    pub(super) draw: BucketDraw,
    pub(super) leaf: u32,
    /// The next draw of the same object, in the same bucket or a later one.
    pub(super) next: u32,
    pub(super) cell: u32,
}

/// A list of draws per object, and the object of each leaf.
pub(super) struct PlacedDraws {
    all: Vec<PlacedDraw>,
    /// The first unused place in `all`; `next` leads to the others.
    unused: u32,
    /// The first draw of each object.
    firsts: Vec<u32>,
    /// The object of each leaf.
    objects: Vec<ObjectId>,
}

impl PlacedDraws {
    pub(super) const EMPTY: Self =
        Self { all: Vec::new(), unused: NONE, firsts: Vec::new(), objects: Vec::new() };

    /// Returns the number of leaves.
    pub(super) fn leaf_count(&self) -> u32 {
        self.objects.len() as u32
    }

    pub(super) fn at(&self, number: u32) -> Option<&PlacedDraw> {
        self.all.get(number as usize)
    }

    pub(super) fn at_mut(&mut self, number: u32) -> Option<&mut PlacedDraw> {
        self.all.get_mut(number as usize)
    }

    /// Returns the number of the first draw of a leaf.
    pub(super) fn first(&self, leaf: LeafIndex) -> u32 {
        let first = self.object_of(leaf).and_then(|object| self.firsts.get(object));
        first.copied().unwrap_or(NONE)
    }

    /// Returns the draws of a leaf, in the order of their buckets.
    pub(super) fn of(&self, leaf: LeafIndex) -> impl Iterator<Item = &PlacedDraw> {
        let first = self.at(self.first(leaf));
        std::iter::successors(first, move |placed| self.at(placed.next))
    }

    /// Puts a draw before the other draws of a leaf, without a cell.
    pub(super) fn push_front(&mut self, leaf: LeafIndex, draw: BucketDraw) {
        let next = self.first(leaf);
        let placed = PlacedDraw { draw, leaf: leaf.0, next, cell: NONE };
        let number = match self.all.get_mut(self.unused as usize) {
            Some(place) => {
                let unused = replace(place, placed).next;
                replace(&mut self.unused, unused)
            }
            None => {
                self.all.push(placed);
                self.all.len() as u32 - 1
            }
        };
        self.set_first(leaf, number);
    }

    /// Removes the draws of a leaf, which must not be in cells.
    pub(super) fn free_all(&mut self, leaf: LeafIndex) {
        let mut number = self.first(leaf);
        while let Some(placed) = self.all.get_mut(number as usize) {
            let next = replace(&mut placed.next, self.unused);
            self.unused = replace(&mut number, next);
        }
        self.set_first(leaf, NONE);
    }

    /// Replaces the objects of consecutive leaves from `first` on.
    pub(super) fn set_objects(&mut self, first: LeafIndex, objects: &[ObjectId]) {
        let places = self.objects.iter_mut().skip(first.0 as usize);
        places.zip(objects).for_each(|(place, object)| *place = *object);
    }

    /// Makes places for at least `leaf_count` leaves and objects; new leaves have no object yet.
    pub(super) fn grow(&mut self, leaf_count: usize) {
        let leaf_count = leaf_count.max(self.objects.len());
        self.firsts.resize(leaf_count, NONE);
        self.objects.resize(leaf_count, ObjectId(NONE));
    }

    fn object_of(&self, leaf: LeafIndex) -> Option<usize> {
        self.objects.get(leaf.0 as usize).map(|object| object.0 as usize)
    }

    fn set_first(&mut self, leaf: LeafIndex, number: u32) {
        if let Some(object) = self.object_of(leaf)
            && let Some(first) = self.firsts.get_mut(object)
        {
            *first = number;
        }
    }
}
