//! Changes of the scene between frames: applied to the hierarchy at once, and to what the GPU reads
//! at the start of the next frame, in its order. Nobody waits.

use std::time::{Duration, Instant};

use cull::{Aabb, LeafRange, ObjectId};

use crate::error::Error;
use crate::renderer::Renderer;
use crate::scene::{Cast, Motion, ObjectChange};

/// What an update did.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct UpdateReport {
    /// Time the CPU spent.
    pub cpu: Duration,
    /// The ids of the objects that were added, in the order of their changes. An id may be that of
    /// an object that is gone.
    pub added: Vec<ObjectId>,
    /// Inner nodes of the hierarchy whose box was computed again.
    pub refitted_nodes: u64,
    /// Leaves under nodes that were rebuilt because moving had worn them.
    pub rebuilt_leaves: u64,
    /// Leaves that the next frame brings to the GPU.
    pub stale_leaves: usize,
    /// The hierarchy is worn as a whole and too large to be rebuilt within a frame: frames cost more
    /// than they need to until [`Renderer::rebuild_hierarchy`] was called.
    pub is_worn: bool,
}

/// Lists of an update in the making, kept to allocate nothing.
#[derive(Default)]
pub(crate) struct UpdateScratch {
    moves: Vec<(ObjectId, Aabb)>,
    changed: Vec<ObjectId>,
    reordered: Vec<LeafRange>,
}

impl Renderer {
    /// Applies `changes` in their order. The next frame shows them; frames on their way do not. The
    /// cost is that of the changes, not of the scene: ancestors of what moved are refitted, leaves
    /// that changed are written by the GPU itself.
    ///
    /// # Errors
    /// [`Error::Change`] for the first change that cannot be made; those before it were.
    pub fn update(&mut self, changes: &[ObjectChange]) -> Result<UpdateReport, Error> {
        let began = Instant::now();
        if !changes.is_empty() {
            self.edition.advance();
        }
        let before = self.hierarchy.work();
        let mut scratch = std::mem::take(&mut self.update_scratch);
        let mut added = Vec::new();
        let outcome = changes.iter().enumerate().try_for_each(|(index, change)| {
            self.apply(change, &mut scratch, &mut added)
                .map_err(|reason| Error::Change { index, reason })
        });
        let outcome = outcome.and(self.move_all(&mut scratch).map_err(Error::from));
        self.hierarchy.restructure(&mut scratch.reordered);
        self.mark(&mut scratch);
        self.update_scratch = scratch;
        outcome?;
        let work = self.hierarchy.work();
        Ok(UpdateReport {
            added,
            refitted_nodes: work.refitted_nodes - before.refitted_nodes,
            rebuilt_leaves: work.rebuilt_leaves - before.rebuilt_leaves,
            stale_leaves: self.passes.geometry.stale_count(),
            is_worn: self.hierarchy.is_worn(),
            cpu: began.elapsed(),
        })
    }

    /// Builds the hierarchy anew over the objects as they are now, for large scenes whose
    /// [update](Renderer::update) says that it is worn. The CPU's work is that of loading the scene;
    /// the GPU is not waited for. Views keep what they know of objects.
    ///
    /// # Errors
    /// None for objects that were accepted before.
    pub fn rebuild_hierarchy(&mut self) -> Result<(), Error> {
        let boxes: Vec<Aabb> = (0..self.hierarchy.leaf_objects().len() as u32)
            .map(|object| {
                let node = self.hierarchy.node_of(ObjectId(object));
                node.map_or(Aabb::EMPTY, |node| self.hierarchy.bounds(node))
            })
            .collect();
        self.hierarchy.rebuild(&boxes)?;
        self.edition.advance();
        let mut scratch = std::mem::take(&mut self.update_scratch);
        scratch.reordered.extend(self.hierarchy.root().map(|root| self.hierarchy.leaves(root)));
        self.mark(&mut scratch);
        self.update_scratch = scratch;
        Ok(())
    }

    /// Shows `motion` as it is in `frame`, with [`Renderer::update`].
    ///
    /// # Errors
    /// As [`Renderer::update`], for instance when someone else removed a mover.
    pub fn show(
        &mut self,
        motion: &Motion,
        cast: &mut Cast,
        frame: u32,
    ) -> Result<UpdateReport, Error> {
        let report = self.update(cast.changes(motion, frame))?;
        cast.came(&report.added);
        Ok(report)
    }

    fn apply(
        &mut self,
        change: &ObjectChange,
        scratch: &mut UpdateScratch,
        added: &mut Vec<ObjectId>,
    ) -> Result<(), String> {
        const NOWHERE: &str = "its transform takes it nowhere: check it for infinities and NaN";
        let geometry = &mut self.passes.geometry;
        match change {
            ObjectChange::Move { object, transform } => {
                if !self.hierarchy.contains(*object) {
                    return Err(cull::HierarchyError::UnknownObject { object: *object }.to_string());
                }
                let bounds = geometry.bounds_at(*object, transform).ok_or(NOWHERE)?;
                geometry.place(*object, transform);
                scratch.moves.push((*object, bounds));
                scratch.changed.push(*object);
            }
            ObjectChange::Remove { object } => {
                self.move_all(scratch).map_err(|error| error.to_string())?;
                self.hierarchy.remove(*object).map_err(|error| error.to_string())?;
                self.passes.geometry.replace(*object, None);
                scratch.changed.push(*object);
            }
            ObjectChange::Add { object } => {
                let bounds = geometry.bounds_of(object.mesh.0, &object.transform);
                let bounds =
                    bounds.ok_or("the scene has no such mesh, or its transform is no number")?;
                self.move_all(scratch).map_err(|error| error.to_string())?;
                let id = self.hierarchy.insert(bounds).map_err(|error| error.to_string())?;
                self.passes.geometry.replace(id, Some(object));
                scratch.changed.push(id);
                added.push(id);
            }
        }
        Ok(())
    }

    /// Refits the hierarchy to the moves that were collected.
    fn move_all(&mut self, scratch: &mut UpdateScratch) -> Result<(), cull::HierarchyError> {
        if scratch.moves.is_empty() {
            return Ok(());
        }
        self.hierarchy.refit(scratch.moves.drain(..))
    }

    /// Marks the leaves of everything that changed, where they are now.
    fn mark(&mut self, scratch: &mut UpdateScratch) {
        let geometry = &mut self.passes.geometry;
        for object in scratch.changed.drain(..) {
            if let Some(leaf) = self.hierarchy.leaf_of(object) {
                geometry.mark(leaf, object);
            }
        }
        for leaf in scratch.reordered.drain(..).flat_map(LeafRange::iter) {
            if let Some(object) = self.hierarchy.leaf_objects().get(leaf.0 as usize) {
                geometry.mark(leaf, *object);
            }
        }
    }
}
