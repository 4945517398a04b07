//! Changes of the scene between frames. They are applied to the hierarchy at once, and to the data
//! on the GPU at the start of the next frame. Nothing waits.

use occlusion::ScenePartsMut;
use std::collections::HashSet;
use std::time::Instant;

use cull::{Aabb, HierarchyError, HierarchyWork, LeafRange, ObjectId};
use scene::{LightMove, MeshId, Object, ObjectChange, SceneUpdate, TransparentMove};

use crate::error::Error;
use crate::renderer::Renderer;
use crate::resources::limits::check_memory;
use crate::resources::mesh_slots::Residency;
use crate::update::{ObjectSet, UpdateReport, UpdateScratch};
use crate::update_errors::ChangeError;

/// The most memory that a change takes in the lists of an update, of the hierarchy and of the
/// leaves, while all of them grow (bytes).
const BYTES_PER_CHANGE: usize = 512;

/// The most memory that an object takes while the hierarchy is built again beside the present one
/// (bytes).
const BYTES_PER_REBUILT_OBJECT: usize =
    size_of::<Aabb>() + cull::BUILD_BYTES_PER_OBJECT + size_of::<[u32; 16]>();

impl Renderer {
    /// Applies all changes between two frames: objects first, with [`Renderer::update`], then
    /// poses, transparent objects and lights. The next frame shows them.
    ///
    /// # Errors
    /// The first impossible change. The changes before it are made.
    pub fn apply(&mut self, update: &SceneUpdate) -> Result<UpdateReport, Error> {
        let began = Instant::now();
        let before = self.scene.hierarchy().work();
        let added = match update.objects.as_slice() {
            [] => Vec::new(),
            objects => self.update(objects)?.added,
        };
        let poses = self.set_poses(update)?;
        for TransparentMove { transparent, transform } in &update.transparent {
            self.move_transparent(*transparent, *transform)?;
        }
        for LightMove { light, to } in &update.lights {
            self.set_light(*light, *to)?;
        }
        let report = self.report_since(before);
        Ok(UpdateReport { added, poses, cpu: began.elapsed(), ..report })
    }

    /// Applies `changes` in their order, all or none. The next frame shows them; frames in flight
    /// do not. The cost grows with the changes, not with the scene: ancestors of moved leaves are
    /// refitted, and the GPU itself writes the changed leaves.
    ///
    /// Changes concern objects that existed before the update. An id that a change frees may be
    /// given to the object of a later change at once; that object can be moved or removed by the
    /// next update, when its id is known.
    ///
    /// # Errors
    /// [`Error::Change`] for the first impossible change; [`Error::NoMemory`]. Nothing has changed
    /// then.
    pub fn update(&mut self, changes: &[ObjectChange]) -> Result<UpdateReport, Error> {
        let began = Instant::now();
        check_memory("changes of objects", changes.len(), BYTES_PER_CHANGE)?;
        let mut scratch = std::mem::take(&mut self.update_scratch);
        let outcome = self.check_changes(changes, &mut scratch);
        let outcome = outcome.and_then(|()| self.make_changes(changes, &mut scratch));
        self.update_scratch = scratch;
        Ok(UpdateReport { cpu: began.elapsed(), ..outcome? })
    }

    /// Finds the first change that is impossible after the changes before it, and the boxes of all
    /// changes.
    fn check_changes(
        &self,
        changes: &[ObjectChange],
        scratch: &mut UpdateScratch,
    ) -> Result<(), Error> {
        let UpdateScratch { bounds, gone, taken, .. } = scratch;
        bounds.clear();
        gone.clear();
        taken.clear();
        let mut free_leaves = self.scene.hierarchy().free_leaves();
        for (index, change) in changes.iter().enumerate() {
            let found = match change {
                ObjectChange::Move { object, transform } => {
                    self.check_there(*object, gone).and_then(|()| {
                        let bounds = self.passes.gpu_scene.geometry.bounds_at(*object, transform);
                        bounds.ok_or(ChangeError::BadTransform)
                    })
                }
                ObjectChange::Remove { object } => self.check_there(*object, gone).map(|()| {
                    gone.insert(*object);
                    free_leaves += 1;
                    Aabb::EMPTY
                }),
                ObjectChange::Add { object } => {
                    let found = self
                        .check_alone(object, gone, taken)
                        .and_then(|()| self.bounds_of_added(object));
                    found.and_then(|found| match free_leaves.checked_sub(1) {
                        Some(left) => {
                            free_leaves = left;
                            Ok(found)
                        }
                        None => Err(ChangeError::NoFreeLeaf),
                    })
                }
            };
            bounds.push(found.map_err(|reason| Error::Change { index, reason })?);
        }
        Ok(())
    }

    /// Refuses an object that did not exist before the update or that the update removes.
    fn check_there(&self, object: ObjectId, gone: &ObjectSet) -> Result<(), ChangeError> {
        if self.scene.hierarchy().contains(object) && !gone.contains(object) {
            return Ok(());
        }
        Err(ChangeError::UnknownObject { object })
    }

    /// Refuses a second object with a skinned mesh: the box of one object would not hold the other.
    fn check_alone(
        &self,
        object: &Object,
        gone: &ObjectSet,
        taken: &mut HashSet<MeshId>,
    ) -> Result<(), ChangeError> {
        let mesh = object.mesh;
        let geometry = &self.passes.gpu_scene.geometry;
        if !geometry.is_skinned(mesh) {
            return Ok(());
        }
        let is_there = geometry.owner(mesh).is_some_and(|owner| !gone.contains(owner));
        if is_there || !taken.insert(mesh) {
            return Err(ChangeError::SkinnedMeshInUse { mesh });
        }
        Ok(())
    }

    fn bounds_of_added(&self, object: &Object) -> Result<Aabb, ChangeError> {
        let geometry = &self.passes.gpu_scene.geometry;
        let mesh = object.mesh;
        if geometry.meshes.residency(mesh) == Residency::Free {
            return Err(ChangeError::UnknownMesh { mesh });
        }
        geometry.bounds_of(mesh.0, &object.transform).ok_or(ChangeError::BadTransform)
    }

    /// Makes changes that have been checked.
    fn make_changes(
        &mut self,
        changes: &[ObjectChange],
        scratch: &mut UpdateScratch,
    ) -> Result<UpdateReport, Error> {
        if !changes.is_empty() {
            self.revision.advance();
        }
        let before = self.scene.hierarchy().work();
        let mut added = Vec::new();
        let bounds = std::mem::take(&mut scratch.bounds);
        for (change, bounds) in changes.iter().zip(&bounds) {
            added.extend(self.make(change, *bounds, scratch)?);
        }
        scratch.bounds = bounds;
        self.settle(scratch)?;
        Ok(UpdateReport { added, ..self.report_since(before) })
    }

    /// Applies the changes to the hierarchy, and marks the leaves that changed.
    pub(crate) fn settle(&mut self, scratch: &mut UpdateScratch) -> Result<(), HierarchyError> {
        self.move_all(scratch)?;
        self.scene.parts_mut().hierarchy.rebuild_subtrees(&mut scratch.reordered);
        self.mark_dirty(scratch);
        Ok(())
    }

    /// Reports the work on the hierarchy after `before`, and the uploads left for the next frame.
    fn report_since(&self, before: HierarchyWork) -> UpdateReport {
        let work = self.scene.hierarchy().work();
        UpdateReport {
            refitted_nodes: work.refitted_nodes - before.refitted_nodes,
            rebuilt_leaves: work.rebuilt_leaves - before.rebuilt_leaves,
            dirty_leaves: self.scene.leaves().dirty().len(),
            is_degraded: self.scene.hierarchy().is_degraded(),
            ..UpdateReport::default()
        }
    }

    /// Builds the hierarchy again over the present objects, for large scenes: when an
    /// [update](Renderer::update) reports that it has degraded. The CPU's work is the same as when
    /// the scene is loaded; nothing waits for the GPU. Views keep their history of objects.
    ///
    /// # Errors
    /// [`Error::NoMemory`] or [`Error::Hierarchy`] without memory for it. Nothing has changed then.
    pub fn rebuild_hierarchy(&mut self) -> Result<(), Error> {
        let count = self.scene.hierarchy().leaf_objects().len();
        check_memory("another hierarchy", count, BYTES_PER_REBUILT_OBJECT)?;
        let boxes = self.scene.hierarchy().boxes_of_objects();
        self.scene.parts_mut().hierarchy.rebuild(&boxes)?;
        self.revision.advance();
        let mut scratch = std::mem::take(&mut self.update_scratch);
        scratch
            .reordered
            .extend(self.scene.hierarchy().root().map(|root| self.scene.hierarchy().leaves(root)));
        self.mark_dirty(&mut scratch);
        self.update_scratch = scratch;
        Ok(())
    }

    /// Makes one change and returns the id of an added object.
    fn make(
        &mut self,
        change: &ObjectChange,
        bounds: Aabb,
        scratch: &mut UpdateScratch,
    ) -> Result<Option<ObjectId>, HierarchyError> {
        match change {
            ObjectChange::Move { object, transform } => {
                self.passes.gpu_scene.geometry.place(*object, transform);
                scratch.moves.push((*object, bounds));
                scratch.changed.push(*object);
                Ok(None)
            }
            ObjectChange::Remove { object } => {
                self.move_all(scratch)?;
                self.scene.parts_mut().hierarchy.remove(*object)?;
                self.passes.gpu_scene.geometry.replace(*object, None);
                scratch.changed.push(*object);
                Ok(None)
            }
            ObjectChange::Add { object } => {
                self.move_all(scratch)?;
                let id = self.scene.parts_mut().hierarchy.insert(bounds)?;
                self.passes.gpu_scene.geometry.replace(id, Some(object));
                scratch.changed.push(id);
                Ok(Some(id))
            }
        }
    }

    /// Refits the hierarchy to the moves that were collected.
    fn move_all(&mut self, scratch: &mut UpdateScratch) -> Result<(), HierarchyError> {
        if scratch.moves.is_empty() {
            return Ok(());
        }
        self.scene.parts_mut().hierarchy.refit(scratch.moves.drain(..))
    }

    /// Marks the leaves of all changed objects, where they are now.
    fn mark_dirty(&mut self, scratch: &mut UpdateScratch) {
        let geometry = &mut self.passes.gpu_scene.geometry;
        let ScenePartsMut { hierarchy, leaves, .. } = self.scene.parts_mut();
        for object in scratch.changed.drain(..) {
            geometry.find_lights(hierarchy, object);
            if let Some(leaf) = hierarchy.leaf_of(object) {
                leaves.mark_dirty(leaf, geometry.draw_of(object));
            }
        }
        for leaf in scratch.reordered.drain(..).flat_map(LeafRange::iter) {
            if let Some(object) = hierarchy.leaf_objects().get(leaf.0 as usize) {
                leaves.mark_dirty(leaf, geometry.draw_of(*object));
            }
        }
    }
}
