//! The boxes of a scene's objects, and the check of a hierarchy over them.

use cull::{Aabb, Hierarchy, ObjectId};
use scene::Scene;

use crate::error::Error;
use crate::resources::limits::check_memory;

/// Returns the box of each object of `scene` in the world, in the order of the objects, to build a
/// hierarchy over them.
///
/// # Errors
/// The first mesh or object that cannot be drawn.
pub fn object_bounds(scene: &Scene) -> Result<Vec<Aabb>, Error> {
    scene.validate()?;
    check_memory("the boxes of the objects", scene.objects.len(), size_of::<Aabb>())?;
    Ok(scene.objects.iter().filter_map(|object| scene.bounds_of(object)).collect())
}

/// Refuses a hierarchy with other objects than `scene` has, or with a box that does not hold its
/// object.
pub(crate) fn check_hierarchy(scene: &Scene, hierarchy: &Hierarchy) -> Result<(), Error> {
    let bounds = object_bounds(scene)?;
    let leaves = hierarchy.leaf_objects().len() as u32;
    let ids = (0..leaves.max(bounds.len() as u32)).map(ObjectId);
    let is_right = |id: &ObjectId| match bounds.get(id.0 as usize) {
        Some(bounds) => {
            hierarchy.node_of(*id).is_some_and(|node| hierarchy.bounds(node).contains(bounds))
        }
        None => !hierarchy.contains(*id),
    };
    match ids.into_iter().find(|id| !is_right(id)) {
        Some(object) => Err(Error::ForeignHierarchy { object }),
        None => Ok(()),
    }
}
