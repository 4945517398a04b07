//! Every function, called with the mistakes that a program in C can make: null, sizes, handles,
//! values.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]
#![allow(unsafe_code, reason = "a host in C calls it so")]

#[cfg(feature = "vulkan")]
mod executor;
#[cfg(feature = "import")]
mod files;
mod guards;
mod handles;
#[cfg(feature = "renderer")]
mod renderer;
mod threads;
mod values;
mod versions;

use std::ffi::CStr;
use std::ptr::null_mut;

use antumbra_capi::api::context::*;
use antumbra_capi::api::culler::*;
use antumbra_capi::api::hierarchy::*;
use antumbra_capi::context::*;
use antumbra_capi::decisions::camera::*;
use antumbra_capi::decisions::culler::*;
use antumbra_capi::decisions::hierarchy::*;
use antumbra_capi::decisions::plan::*;
use antumbra_capi::error::AntumbraError;
use antumbra_capi::error::AntumbraResult::{self, BadArgument, Ok};
use antumbra_capi::layout::Versioned;

/// Returns the last message.
fn text(error: &AntumbraError) -> &str {
    // SAFETY: every call ends the message.
    unsafe { CStr::from_ptr(error.message.as_ptr()) }.to_str().unwrap()
}

fn no_error() -> AntumbraError {
    let struct_size = size_of::<AntumbraError>() as u32;
    AntumbraError { struct_size, result: 0, message: [0; 504] }
}

const CAMERA: AntumbraCamera = AntumbraCamera {
    width: 64,
    height: 64,
    #[rustfmt::skip]
    clip_from_world: [
        1.0, 0.0, 0.0, 0.0,
        0.0, -1.0, 0.0, 0.0,
        0.0, 0.0, 0.0, -1.0,
        0.0, 0.0, 0.1, 0.0,
    ],
    ..AntumbraCamera::INIT
};

fn cube(x: f32, z: f32) -> AntumbraAabb {
    AntumbraAabb { min: [x, -0.5, z], max: [x + 0.5, 0.5, z + 0.5] }
}

/// A context with a hierarchy of two objects and a culler.
struct Host {
    context: *mut AntumbraContext,
    hierarchy: AntumbraHierarchy,
    culler: AntumbraCuller,
    error: AntumbraError,
}

impl Host {
    fn new() -> Self {
        let mut new = Self {
            context: null_mut(),
            hierarchy: AntumbraHierarchy { id: 0 },
            culler: AntumbraCuller { id: 0 },
            error: no_error(),
        };
        let boxes = [cube(-1.0, -5.0), cube(1.0, -5.0)];
        let hierarchy = AntumbraHierarchyDesc {
            boxes: boxes.as_ptr(),
            box_count: boxes.len(),
            ..Versioned::INIT
        };
        let Self { context, hierarchy: made, culler, error } = &mut new;
        // SAFETY: all pointers are to values that live as long as the calls.
        unsafe {
            assert_eq!(
                antumbra_context_create(&AntumbraContextDesc::current(), context, error),
                Ok
            );
            let created = antumbra_hierarchy_create(*context, &hierarchy, made, error);
            assert_eq!(created, Ok, "{}", text(error));
            let created = antumbra_culler_create(*context, &Versioned::INIT, culler, error);
            assert_eq!(created, Ok, "{}", text(error));
        }
        new
    }

    fn plan(&mut self, camera: &AntumbraCamera, plan: &mut AntumbraFramePlan) -> AntumbraResult {
        let desc = AntumbraPlanDesc { camera, ..Versioned::INIT };
        let Self { context, hierarchy, culler, error } = self;
        // SAFETY: all pointers are to values that live as long as the call.
        unsafe { antumbra_culler_plan(*context, *culler, *hierarchy, &desc, plan, error) }
    }

    /// Returns the objects of a plan, drawn at once or tested.
    fn planned(&mut self) -> Vec<u32> {
        let mut plan = AntumbraFramePlan::INIT;
        assert_eq!(self.plan(&CAMERA, &mut plan), Ok, "{}", text(&self.error));
        let leaves = self.leaves().0;
        // SAFETY: the arrays of a plan that was just made.
        let (draws, tests) = unsafe {
            let draws = std::slice::from_raw_parts(plan.draws, plan.draw_count);
            (draws, std::slice::from_raw_parts(plan.tests, plan.test_count))
        };
        let tested = tests.iter().flat_map(|test| {
            let first = test.first_leaf as usize;
            leaves[first..first + test.leaf_count as usize].to_vec()
        });
        let drawn = draws.iter().map(|draw| draw.object);
        let all = drawn.chain(tested).filter(|object| *object != ANTUMBRA_NO_OBJECT);
        let mut objects: Vec<u32> = all.collect();
        objects.sort_unstable();
        objects
    }

    fn leaves(&mut self) -> (Vec<u32>, u64) {
        let mut leaves = AntumbraLeaves::INIT;
        // SAFETY: as in `plan`.
        unsafe {
            let listed = antumbra_hierarchy_leaves(
                self.context,
                self.hierarchy,
                &mut leaves,
                &mut self.error,
            );
            assert_eq!(listed, Ok);
            let objects = std::slice::from_raw_parts(leaves.objects, leaves.count);
            (objects.to_vec(), leaves.revision)
        }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: it is no longer used.
        unsafe { antumbra_context_destroy(self.context, null_mut()) };
    }
}

#[test]
fn objects_come_move_and_go() {
    let mut host = Host::new();
    assert_eq!(host.planned(), [0, 1]);
    let context = host.context;
    let hierarchy = host.hierarchy;
    let boxes: Vec<AntumbraAabb> = (0..20).map(|n| cube(n as f32 * 0.1 - 1.0, -4.0)).collect();
    let mut ids = [0; 20];
    let revision = host.leaves().1;
    // SAFETY: pointers to values on this stack.
    unsafe {
        let boxes = boxes.as_ptr();
        let ids_at = ids.as_mut_ptr();
        let count = ids.len();
        let error = &mut host.error;
        let inserted = antumbra_hierarchy_insert(context, hierarchy, boxes, count, ids_at, error);
        assert_eq!(inserted, Ok, "{}", text(error));
    }
    let mut expected: Vec<u32> = [0, 1].into_iter().chain(ids).collect();
    expected.sort_unstable();
    assert_eq!(host.planned(), expected);
    let (leaves, grown) = host.leaves();
    assert!(grown > revision);
    let there = leaves.iter().filter(|object| **object != ANTUMBRA_NO_OBJECT).count();
    assert_eq!((there, leaves.len()), (22, 22));
    // One object more than the capacity: its leaf is the last one, except for free leaves.
    let mut last = [0];
    // SAFETY: as above.
    unsafe {
        let bounds = cube(0.0, 5.0);
        let error = &mut host.error;
        let added =
            antumbra_hierarchy_insert(context, hierarchy, &bounds, 1, last.as_mut_ptr(), error);
        assert_eq!((added, last), (Ok, [22]));
        assert_eq!(host.leaves().0.len(), 31);
        let last = last.as_ptr();
        let error = &mut host.error;
        assert_eq!(antumbra_hierarchy_remove(context, hierarchy, last, 1, error), Ok);
        let error = &mut host.error;
        assert_eq!(antumbra_hierarchy_rebuild(context, hierarchy, error), Ok);
    }
    assert_eq!(host.planned(), expected);

    // Behind the eye, or gone.
    let behind = [cube(0.0, 5.0); 10];
    // SAFETY: as above.
    unsafe {
        let error = &mut host.error;
        let ids = ids.as_ptr();
        let boxes = behind.as_ptr();
        assert_eq!(antumbra_hierarchy_move(context, hierarchy, ids, boxes, 10, error), Ok);
        assert_eq!(antumbra_hierarchy_remove(context, hierarchy, ids.add(10), 9, error), Ok);
        let again = antumbra_hierarchy_remove(context, hierarchy, ids.add(10), 1, error);
        assert_eq!(again, BadArgument);
        assert_eq!(antumbra_hierarchy_update(context, hierarchy, error), Ok);
    }
    let mut left = vec![0, 1, ids[19]];
    left.sort_unstable();
    assert_eq!(host.planned(), left);
    let leaves = host.leaves().0;
    let mut there: Vec<u32> =
        leaves.into_iter().filter(|object| *object != ANTUMBRA_NO_OBJECT).collect();
    there.sort_unstable();
    left.extend_from_slice(&ids[..10]);
    left.sort_unstable();
    assert_eq!(there, left);
}
