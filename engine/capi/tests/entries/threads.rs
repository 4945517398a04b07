//! Threads that use one context and the same objects in any order.

use std::ptr::null_mut;
use std::sync::Barrier;
use std::sync::atomic::{AtomicUsize, Ordering};

use antumbra_capi::api::culler::*;
use antumbra_capi::api::hierarchy::*;
use antumbra_capi::context::AntumbraContext;
use antumbra_capi::decisions::culler::*;
use antumbra_capi::decisions::hierarchy::*;
use antumbra_capi::decisions::plan::*;
use antumbra_capi::error::AntumbraResult::{self, Busy, Ok};
use antumbra_capi::layout::Versioned;

use crate::{CAMERA, Host, cube};

/// The calls of each thread.
const CALLS: usize = 2_000;

/// The handles that all threads use.
#[derive(Clone, Copy)]
struct Handles {
    context: usize,
    hierarchy: AntumbraHierarchy,
    culler: AntumbraCuller,
}

/// Calls one of the functions, in turn.
fn call(handles: Handles, number: usize) -> AntumbraResult {
    let Handles { hierarchy: h, culler: c, .. } = handles;
    let x = handles.context as *const AntumbraContext;
    let none = null_mut();
    // SAFETY: pointers to values that live as long as the call; the context outlives the threads.
    unsafe {
        match number % 7 {
            0 => antumbra_hierarchy_move(x, h, &0, &cube(number as f32 % 9.0, -5.0), 1, none),
            1 => {
                let mut leaves = AntumbraLeaves::INIT;
                antumbra_hierarchy_leaves(x, h, &mut leaves, none)
            }
            2 => antumbra_hierarchy_update(x, h, none),
            3 => antumbra_culler_reset(x, c, none),
            4 => antumbra_culler_ingest(x, c, h, std::ptr::null(), 0, none),
            5 => {
                // An object that only this thread uses is never busy.
                let mut own = AntumbraHierarchy { id: 0 };
                let made = antumbra_hierarchy_create(x, &Versioned::INIT, &mut own, none);
                assert_eq!([made, antumbra_hierarchy_destroy(x, own, none)], [Ok; 2]);
                Ok
            }
            _ => {
                let desc = AntumbraPlanDesc { camera: &CAMERA, ..Versioned::INIT };
                let mut plan = AntumbraFramePlan::INIT;
                antumbra_culler_plan(x, c, h, &desc, &mut plan, none)
            }
        }
    }
}

#[test]
fn threads_without_an_order_are_busy_at_times_and_nothing_breaks() {
    let host = Host::new();
    let device =
        Handles { context: host.context as usize, hierarchy: host.hierarchy, culler: host.culler };
    let begin = Barrier::new(4);
    let [done, busy] = [(); 2].map(|()| AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for thread in 0..4 {
            let begin = &begin;
            let done = &done;
            let busy = &busy;
            scope.spawn(move || {
                begin.wait();
                for number in 0..CALLS {
                    match call(device, number + thread) {
                        Ok => done.fetch_add(1, Ordering::Relaxed),
                        Busy => busy.fetch_add(1, Ordering::Relaxed),
                        other => panic!("{other:?} of call {number} in thread {thread}"),
                    };
                }
            });
        }
    });
    assert_eq!(done.into_inner() + busy.into_inner(), 4 * CALLS);
    for number in 0..7 {
        assert_eq!(call(device, number), Ok, "call {number}, with nobody else");
    }
}
