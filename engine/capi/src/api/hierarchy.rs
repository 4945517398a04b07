//! Functions of hierarchies.

use crate::context::{AntumbraContext, entry};
use crate::decisions::hierarchy::{
    AntumbraAabb, AntumbraHierarchy, AntumbraHierarchyDesc, AntumbraLeaves, BoxHierarchy, usable,
};
use crate::error::{AntumbraError, AntumbraResult, Failure};
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
            if desc.reserved != 0 {
                return Err(Failure::argument("desc.reserved must be 0"));
            }
            *hierarchy = context.hierarchies.insert(BoxHierarchy::new(boxes, desc.capacity)?)?;
            Ok(())
        })
    }
}

/// Destroys a hierarchy. A handle of 0 is no error.
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

/// Moves objects: object `objects[i]` has the box `boxes[i]` from now on. After an error those
/// before the one that the message names have moved.
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

/// Adds objects and writes their ids, which may be those of objects that were removed. Without room
/// left everything is built again with twice the room; ids and histories stay. After an error
/// `added` says how many objects were added.
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
    added: *mut usize,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            if !added.is_null() {
                check_output("added", added)?;
                *added = 0;
            }
            let boxes = slice("boxes", boxes, count)?;
            let ids = output_slice("objects", objects, count)?;
            let hierarchy = context.hierarchies.find(hierarchy)?;
            let mut hierarchy = hierarchy.write()?;
            for (number, (bounds, id)) in boxes.iter().zip(ids).enumerate() {
                id.write(hierarchy.insert(usable(number, *bounds)?)?);
                if !added.is_null() {
                    *added = number + 1;
                }
            }
            Ok(())
        })
    }
}

/// Removes objects. Their ids are given to objects that are added later. After an error those
/// before the one that the message names were removed.
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

/// Rebuilds parts that moving has worn, a bounded number of leaves. To be called once per frame,
/// after the frame's other changes, if objects move.
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

/// Writes the objects of all leaves, in the order that plans refer to.
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
