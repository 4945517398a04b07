//! Tests of the boundary from inside: panics, locks, messages.

use std::ffi::{CStr, c_char, c_void};
use std::ptr;
use std::sync::Mutex;

use crate::api::context::{antumbra_context_create, antumbra_context_destroy};
use crate::api::hierarchy::{
    antumbra_hierarchy_create, antumbra_hierarchy_destroy, antumbra_hierarchy_leaves,
    antumbra_hierarchy_update,
};
use crate::context::{AntumbraContext, AntumbraContextDesc, entry};
use crate::decisions::hierarchy::{
    AntumbraAabb, AntumbraHierarchy, AntumbraHierarchyDesc, AntumbraLeaves,
};
use crate::error::{AntumbraError, AntumbraResult};
use crate::layout::Versioned;
use crate::log::ANTUMBRA_LOG_INFO;

fn no_error() -> AntumbraError {
    let struct_size = size_of::<AntumbraError>() as u32;
    AntumbraError { struct_size, result: 7, message: [1; 504] }
}

fn text(error: &AntumbraError) -> String {
    // SAFETY: every call ends the message.
    unsafe { CStr::from_ptr(error.message.as_ptr()) }.to_str().unwrap().to_owned()
}

/// Calls a function with a context that has one hierarchy.
fn with_hierarchy(
    desc: &AntumbraContextDesc,
    call: impl FnOnce(*mut AntumbraContext, AntumbraHierarchy, &mut AntumbraError),
) {
    let mut error = no_error();
    let mut context = ptr::null_mut();
    let bounds = AntumbraAabb { min: [0.0; 3], max: [1.0; 3] };
    let boxes = AntumbraHierarchyDesc { boxes: &bounds, box_count: 1, ..Versioned::INIT };
    let mut hierarchy = AntumbraHierarchy { id: 0 };
    // SAFETY: all pointers are to values on this stack.
    unsafe {
        let created = antumbra_context_create(desc, &mut context, &mut error);
        assert_eq!(created, AntumbraResult::Ok);
        let created = antumbra_hierarchy_create(context, &boxes, &mut hierarchy, &mut error);
        assert_eq!((created, error.result, text(&error).as_str()), (AntumbraResult::Ok, 0, ""));
        call(context, hierarchy, &mut error);
        let destroyed = antumbra_context_destroy(context, &mut error);
        assert_eq!(destroyed, AntumbraResult::Ok);
    }
}

#[test]
fn a_panic_is_an_error_and_poisons_what_was_being_changed() {
    with_hierarchy(&AntumbraContextDesc::current(), |context, hierarchy, error| {
        let mut leaves = AntumbraLeaves::INIT;
        // SAFETY: as in `with_hierarchy`.
        unsafe {
            let result = entry(context, error, |context| {
                let hierarchy = context.hierarchies.find(hierarchy)?;
                let _read = hierarchy.read()?;
                panic!("while {}", "reading")
            });
            assert_eq!(result, AntumbraResult::Panic);
            assert_eq!(error.result, AntumbraResult::Panic as i32);
            assert!(text(error).ends_with("report it: while reading"), "{}", text(error));
            let read = antumbra_hierarchy_leaves(context, hierarchy, &mut leaves, error);
            assert_eq!(read, AntumbraResult::Ok, "nothing was being changed");

            let result = entry(context, error, |context| {
                let hierarchy = context.hierarchies.find(hierarchy)?;
                let _write = hierarchy.write()?;
                std::panic::panic_any(3)
            });
            assert_eq!(result, AntumbraResult::Panic);
            let read = antumbra_hierarchy_leaves(context, hierarchy, &mut leaves, error);
            let written = antumbra_hierarchy_update(context, hierarchy, error);
            assert_eq!([read, written], [AntumbraResult::Poisoned; 2]);
            assert!(text(error).contains("destroy it"), "{}", text(error));
            let destroyed = antumbra_hierarchy_destroy(context, hierarchy, error);
            assert_eq!(destroyed, AntumbraResult::Ok);
        }
    });
}

#[test]
fn two_calls_change_one_object_one_after_the_other_or_not_at_all() {
    with_hierarchy(&AntumbraContextDesc::current(), |context, hierarchy, error| {
        let mut leaves = AntumbraLeaves::INIT;
        // SAFETY: as in `with_hierarchy`.
        let results = unsafe {
            let found = (*context).hierarchies.find(hierarchy).unwrap();
            let reading = found.read().unwrap();
            let read = antumbra_hierarchy_leaves(context, hierarchy, &mut leaves, error);
            let written = antumbra_hierarchy_update(context, hierarchy, error);
            drop(reading);
            let _writing = found.write().unwrap();
            let late = antumbra_hierarchy_leaves(context, hierarchy, &mut leaves, error);
            // What a call still uses lives on.
            let destroyed = antumbra_hierarchy_destroy(context, hierarchy, error);
            [read, written, late, destroyed]
        };
        use AntumbraResult::{Busy, Ok};
        assert_eq!(results, [Ok, Busy, Busy, Ok]);
    });
}

unsafe extern "C" fn note(user: *mut c_void, level: u32, message: *const c_char) {
    // SAFETY: the test passes this as user.
    let notes = unsafe { &*user.cast::<Mutex<Vec<(u32, String)>>>() };
    // SAFETY: the promise of `AntumbraLogCallback`.
    let message = unsafe { CStr::from_ptr(message) };
    notes.lock().unwrap().push((level, message.to_str().unwrap().to_owned()));
}

#[test]
fn messages_go_to_the_log_of_their_context() {
    let notes: [Mutex<Vec<(u32, String)>>; 2] = Default::default();
    let descs = [(&notes[0], ANTUMBRA_LOG_INFO), (&notes[1], 1)].map(|(notes, log_level)| {
        let log_user = ptr::from_ref(notes).cast_mut().cast();
        AntumbraContextDesc {
            log: Some(note),
            log_user,
            log_level,
            ..AntumbraContextDesc::current()
        }
    });
    let speak = |context: *mut AntumbraContext, _, error: &mut AntumbraError| {
        // SAFETY: as in `with_hierarchy`.
        let result = unsafe {
            entry(context, error, |_| {
                tracing::info!(objects = 3, "made");
                tracing::debug!("details");
                tracing::error!("with a \0 inside");
                Ok(())
            })
        };
        assert_eq!(result, AntumbraResult::Ok);
        tracing::error!("outside of a call");
    };
    for desc in &descs {
        with_hierarchy(desc, speak);
    }
    let [all, errors] = notes.map(|notes| notes.into_inner().unwrap());
    let error = (1, "with a  inside".to_owned());
    assert_eq!(all, [(3, "made, objects: 3".to_owned()), error.clone()]);
    assert_eq!(errors, [error]);
}

#[test]
fn a_message_fits_into_the_memory_of_the_caller() {
    for (struct_size, kept) in
        [(0, None), (8, None), (9, Some("")), (12, Some("con")), (4000, None)]
    {
        let mut error = AntumbraError { struct_size, ..no_error() };
        // SAFETY: a null context is an error.
        let result = unsafe {
            antumbra_hierarchy_update(ptr::null(), AntumbraHierarchy { id: 0 }, &mut error)
        };
        assert_eq!(result, AntumbraResult::BadPointer);
        match kept {
            Some(kept) => {
                assert_eq!(text(&error), kept);
                assert_eq!(
                    error.message[struct_size as usize - 8],
                    1,
                    "nothing behind it is written"
                );
            }
            None if struct_size < 9 => assert_eq!((error.result, error.message), (7, [1; 504])),
            None => assert_eq!(text(&error), "context is null"),
        }
    }
}

#[test]
fn a_message_is_cut_between_letters() {
    let mut error = AntumbraError { struct_size: 8 + 1 + 4, ..no_error() };
    // SAFETY: a value on this stack.
    unsafe { AntumbraError::write(&mut error, AntumbraResult::Panic, "aéüö") };
    assert_eq!(text(&error), "aé");
}
