//! Functions of hierarchies.

use crate::context::{AntumbraContext, entry};
use crate::decisions::hierarchy::{
    AntumbraAabb, AntumbraHierarchy, AntumbraHierarchyDesc, AntumbraLeaves, BoxHierarchy,
};
use crate::error::{AntumbraError, AntumbraResult};
use crate::pointers::{Output, check_output, output_slice, read, slice};

/// Creates a hierarchy over the boxes of objects.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_hierarchy_create(
    context: *const AntumbraContext,
    desc: *const AntumbraHierarchyDesc,
    hierarchy: *mut AntumbraHierarchy,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            check_output("hierarchy", hierarchy)?;
            let desc = read("desc", desc)?;
            let boxes = slice("desc.boxes", desc.boxes, desc.box_count)?;
            *hierarchy = context.hierarchies.insert(BoxHierarchy::new(boxes, desc.capacity)?)?;
            Ok(())
        })
    }
}

/// Destroys a hierarchy. A handle of 0 is not an error.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_hierarchy_destroy(
    context: *const AntumbraContext,
    hierarchy: AntumbraHierarchy,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe { entry(context, error, |context| context.hierarchies.destroy(hierarchy)) }
}

/// Moves objects: object `objects[i]` has the box `boxes[i]` from now on. After an error the
/// objects before the one in the message have moved. The order of leaves does not change.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_hierarchy_move(
    context: *const AntumbraContext,
    hierarchy: AntumbraHierarchy,
    objects: *const u32,
    boxes: *const AntumbraAabb,
    count: usize,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let objects = slice("objects", objects, count)?;
            let boxes = slice("boxes", boxes, count)?;
            context.hierarchies.find(hierarchy)?.write()?.move_objects(objects, boxes)
        })
    }
}

/// Adds objects and writes their ids, which may be those of objects that were removed. Ids and
/// histories of other objects stay. After an error nothing was added.
///
/// The time depends on the number of added objects. If they do not fit
/// (`AntumbraHierarchyDesc::capacity`), the hierarchy grows to hold them and a further sixteenth of
/// all objects: 0.2 seconds for 10,000,000 objects. If their number reaches the number of existing
/// objects, everything is rebuilt: about a second per 1,000,000 objects.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_hierarchy_insert(
    context: *const AntumbraContext,
    hierarchy: AntumbraHierarchy,
    boxes: *const AntumbraAabb,
    count: usize,
    objects: *mut u32,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let boxes = slice("boxes", boxes, count)?;
            let ids = output_slice("objects", objects, count)?;
            let hierarchy = context.hierarchies.find(hierarchy)?;
            let mut hierarchy = hierarchy.write()?;
            for (id, object) in ids.iter_mut().zip(hierarchy.insert(boxes)?) {
                id.write(object.0);
            }
            Ok(())
        })
    }
}

/// Removes objects. Objects that are added later reuse their ids. After an error the objects before
/// the one in the message have been removed.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_hierarchy_remove(
    context: *const AntumbraContext,
    hierarchy: AntumbraHierarchy,
    objects: *const u32,
    count: usize,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let objects = slice("objects", objects, count)?;
            context.hierarchies.find(hierarchy)?.write()?.remove(objects)
        })
    }
}

/// Rebuilds subtrees that moving objects have degraded, up to a bounded number of leaves. If
/// objects move, call it once per frame, after the other changes of the frame.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_hierarchy_update(
    context: *const AntumbraContext,
    hierarchy: AntumbraHierarchy,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            context.hierarchies.find(hierarchy)?.write()?.update();
            Ok(())
        })
    }
}

/// Rebuilds the whole hierarchy for the current boxes. After many insertions or long moves plans
/// become longer, though they stay correct; a rebuild makes them short again. Ids and histories
/// stay. Takes about a second per 1,000,000 objects, so it is meant for a pause of the program.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_hierarchy_rebuild(
    context: *const AntumbraContext,
    hierarchy: AntumbraHierarchy,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| context.hierarchies.find(hierarchy)?.write()?.rebuild())
    }
}

/// Writes the objects of all leaves, in the order that plans refer to. Call it again after
/// `antumbra_hierarchy_insert`, `_remove`, `_update` and `_rebuild`. Moves change nothing.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_hierarchy_leaves(
    context: *const AntumbraContext,
    hierarchy: AntumbraHierarchy,
    leaves: *mut AntumbraLeaves,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("leaves", leaves)?;
            let hierarchy = context.hierarchies.find(hierarchy)?;
            output.write(&hierarchy.read()?.leaves());
            Ok(())
        })
    }
}
