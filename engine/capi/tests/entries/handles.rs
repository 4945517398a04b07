//! Invalid handles: 0, destroyed, foreign, of another kind.

use std::ptr::{null, null_mut};

use antumbra_capi::api::culler::*;
use antumbra_capi::api::hierarchy::*;
use antumbra_capi::context::*;
use antumbra_capi::decisions::culler::*;
use antumbra_capi::decisions::hierarchy::*;
use antumbra_capi::decisions::plan::*;
use antumbra_capi::error::AntumbraError;
use antumbra_capi::error::AntumbraResult::{self, BadPointer, Ok, UnknownHandle};
use antumbra_capi::layout::Versioned;

use crate::{CAMERA, Host};

/// A function of the interface, called with a context and handles. All other values are valid.
type Call<'a> = (&'a str, &'a dyn Fn(*const AntumbraContext, u64, u64) -> AntumbraResult);

#[test]
fn every_function_checks_its_handles() {
    let mut host = Host::new();
    let box_desc = AntumbraHierarchyDesc::INIT;
    let culler_desc = AntumbraCullerDesc::INIT;
    let plan_desc = AntumbraPlanDesc { camera: &CAMERA, ..Versioned::INIT };
    let h = |id| AntumbraHierarchy { id };
    let c = |id| AntumbraCuller { id };
    let none = null_mut::<AntumbraError>();
    // SAFETY: of all closures: pointers to values that live as long as the call.
    let calls: [Call; 13] = unsafe {
        [
            ("hierarchy_create", &|x, _, _| {
                antumbra_hierarchy_create(x, &box_desc, &mut h(0), none)
            }),
            ("hierarchy_destroy", &|x, id, _| antumbra_hierarchy_destroy(x, h(id), none)),
            ("hierarchy_move", &|x, id, _| {
                antumbra_hierarchy_move(x, h(id), null(), null(), 0, none)
            }),
            ("hierarchy_insert", &|x, id, _| {
                antumbra_hierarchy_insert(x, h(id), null(), 0, null_mut(), none)
            }),
            ("hierarchy_remove", &|x, id, _| antumbra_hierarchy_remove(x, h(id), null(), 0, none)),
            ("hierarchy_update", &|x, id, _| antumbra_hierarchy_update(x, h(id), none)),
            ("hierarchy_rebuild", &|x, id, _| antumbra_hierarchy_rebuild(x, h(id), none)),
            ("hierarchy_leaves", &|x, id, _| {
                let mut leaves = AntumbraLeaves::INIT;
                antumbra_hierarchy_leaves(x, h(id), &mut leaves, none)
            }),
            ("culler_create", &|x, _, _| antumbra_culler_create(x, &culler_desc, &mut c(0), none)),
            ("culler_destroy", &|x, _, id| antumbra_culler_destroy(x, c(id), none)),
            ("culler_reset", &|x, _, id| antumbra_culler_reset(x, c(id), none)),
            ("culler_ingest", &|x, first, second| {
                antumbra_culler_ingest(x, c(second), h(first), null(), 0, none)
            }),
            ("culler_plan", &|x, first, second| {
                let mut plan = AntumbraFramePlan::INIT;
                antumbra_culler_plan(x, c(second), h(first), &plan_desc, &mut plan, none)
            }),
        ]
    };
    let other = Host::new();
    let hierarchy = host.hierarchy.id;
    let culler = host.culler.id;
    let wrong = [0, u64::MAX, hierarchy ^ (1 << 40), other.hierarchy.id, other.culler.id];
    for (name, call) in calls {
        assert_eq!(call(null(), hierarchy, culler), BadPointer, "{name}");
        if name.ends_with("create") {
            assert_eq!(call(host.context, 0, 0), Ok, "{name}");
            continue;
        }
        let is_destroy = name.ends_with("destroy");
        for id in wrong.into_iter().filter(|id| !is_destroy || *id != 0) {
            let takes_hierarchy = name.starts_with("hierarchy");
            let result = if takes_hierarchy {
                call(host.context, id, culler)
            } else {
                call(host.context, hierarchy, id)
            };
            assert_eq!(result, UnknownHandle, "{name} {id:#x}");
        }
        // A handle of another kind.
        assert_eq!(call(host.context, culler, hierarchy), UnknownHandle, "{name}");
        if is_destroy {
            assert_eq!(call(host.context, 0, 0), Ok, "{name}");
        } else {
            assert_eq!(call(host.context, hierarchy, culler), Ok, "{name}");
        }
    }
    // The functions that destroy succeed once, and fail the second time.
    for (name, call) in calls.iter().filter(|(name, _)| name.ends_with("destroy")) {
        assert_eq!(call(host.context, hierarchy, culler), Ok, "{name}");
        assert_eq!(call(host.context, hierarchy, culler), UnknownHandle, "{name}");
    }
    // The slot of a destroyed object is used again, its handle is not.
    let mut again = h(0);
    // SAFETY: as above.
    let created =
        unsafe { antumbra_hierarchy_create(host.context, &box_desc, &mut again, &mut host.error) };
    assert_eq!(created, Ok);
    assert_eq!(again.id as u32, hierarchy as u32, "the place of the first");
    assert_ne!(again.id, hierarchy);
}
