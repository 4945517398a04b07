//! Pointers and values that are refused, with their names in the message.

use std::ptr::{from_ref, null, null_mut};

use antumbra_capi::api::culler::*;
use antumbra_capi::api::hierarchy::*;
use antumbra_capi::decisions::camera::*;
use antumbra_capi::decisions::culler::*;
use antumbra_capi::decisions::hierarchy::*;
use antumbra_capi::decisions::plan::*;
use antumbra_capi::error::AntumbraError;
use antumbra_capi::error::AntumbraResult::{self, BadArgument, BadPointer};
use antumbra_capi::layout::Versioned;

use crate::{CAMERA, Host, cube, text};

/// Returns a camera whose matrix has this element.
fn with_element(element: f32) -> AntumbraCamera {
    let mut camera = CAMERA;
    camera.clip_from_world[5] = element;
    camera
}

#[test]
fn bad_pointers_and_values_are_named() {
    let mut host = Host::new();
    let context = host.context;
    let hierarchy = host.hierarchy;
    let culler = host.culler;
    let error = &mut host.error;
    let bad = AntumbraAabb { min: [1.0; 3], max: [0.0; 3] };
    let infinite = AntumbraAabb { max: [f32::INFINITY; 3], ..bad };
    let odd = from_ref(&bad).wrapping_byte_add(1);
    let mut ids = [9; 2];
    let mut none = AntumbraHierarchy { id: 3 };
    let expect = |result, expected: (AntumbraResult, &str), error: &AntumbraError| {
        let (wanted, words) = expected;
        assert_eq!(result, wanted, "{}", text(error));
        assert!(text(error).contains(words), "\"{}\" does not say \"{words}\"", text(error));
    };
    // SAFETY: pointers are null or misaligned, which is refused, or to values on this stack.
    unsafe {
        for (boxes, box_count, expected) in [
            (null(), 1, (BadPointer, "desc.boxes is null")),
            (odd, 1, (BadPointer, "desc.boxes is not aligned to 4")),
            (from_ref(&bad), usize::MAX, (BadArgument, "more than memory")),
            (from_ref(&bad), 1, (BadArgument, "desc.boxes[0] is no box")),
            (from_ref(&infinite), 1, (BadArgument, "desc.boxes[0] is no box")),
        ] {
            let desc = AntumbraHierarchyDesc { boxes, box_count, ..Versioned::INIT };
            let result = antumbra_hierarchy_create(context, &desc, &mut none, error);
            expect(result, expected, error);
        }
        let huge = AntumbraHierarchyDesc { capacity: usize::MAX, ..Versioned::INIT };
        let result = antumbra_hierarchy_create(context, &huge, &mut none, error);
        expect(result, (BadArgument, "more than one hierarchy holds"), error);
        let reserved = AntumbraHierarchyDesc { reserved: 1, ..Versioned::INIT };
        let result = antumbra_hierarchy_create(context, &reserved, &mut none, error);
        expect(result, (BadArgument, "reserved"), error);
        let result = antumbra_hierarchy_create(context, &Versioned::INIT, null_mut(), error);
        expect(result, (BadPointer, "hierarchy is null"), error);
        assert_eq!(none.id, 3, "nothing is written after an error");

        let boxes = [cube(0.0, -5.0), bad];
        let boxes = boxes.as_ptr();
        let ids_at = ids.as_mut_ptr();
        let result = antumbra_hierarchy_insert(context, hierarchy, boxes, 2, ids_at, error);
        expect(result, (BadArgument, "boxes[1] is no box"), error);
        assert_eq!(ids, [9; 2]);
        let result = antumbra_hierarchy_insert(context, hierarchy, boxes, 2, null_mut(), error);
        expect(result, (BadPointer, "objects is null"), error);

        let testers = AntumbraCullerDesc { testers: 4, ..Versioned::INIT };
        let mut new = culler;
        let result = antumbra_culler_create(context, &testers, &mut new, error);
        expect(result, (BadArgument, "ANTUMBRA_HAS_"), error);
        let tag =
            AntumbraQueryTag { frame: 1, node: 0, generation: 0, kind: 9, sample_threshold: 0 };
        let answer = AntumbraAnswer { tag, samples: 1, reserved: 0 };
        let result = antumbra_culler_ingest(context, culler, hierarchy, &answer, 1, error);
        expect(result, (BadArgument, "answers[0] has a tag of kind 9"), error);

        let tag = AntumbraQueryTag { kind: ANTUMBRA_QUERY_PROXY, ..tag };
        let answers = [0, 1].map(|reserved| AntumbraAnswer { tag, samples: 1, reserved });
        let result = antumbra_culler_ingest(context, culler, hierarchy, answers.as_ptr(), 2, error);
        expect(result, (BadArgument, "answers[1].reserved must be 0"), error);

        let mut plan = AntumbraFramePlan::INIT;
        for (strategy, camera, expected) in [
            (7, from_ref(&CAMERA), (BadArgument, "STRATEGY_.. 7")),
            (1, null(), (BadPointer, "desc.camera is null")),
            (1, &AntumbraCamera { width: 0, ..CAMERA }, (BadArgument, "width")),
            (1, &AntumbraCamera { height: 0, ..CAMERA }, (BadArgument, "height")),
            (1, &with_element(f32::NAN), (BadArgument, "clip_from_world: the matrix of the view")),
            (1, &with_element(f32::INFINITY), (BadArgument, "that is not finite")),
            (
                1,
                &AntumbraCamera { clip_from_world: [0.0; 16], ..CAMERA },
                (BadArgument, "clip_from_world"),
            ),
            (1, &AntumbraCamera { depth: 7, ..CAMERA }, (BadArgument, "ANTUMBRA_DEPTH_")),
            (1, &AntumbraCamera { clip_y: 7, ..CAMERA }, (BadArgument, "ANTUMBRA_CLIP_Y_")),
        ] {
            let desc = AntumbraPlanDesc { strategy, camera, ..Versioned::INIT };
            let result = antumbra_culler_plan(context, culler, hierarchy, &desc, &mut plan, error);
            expect(result, expected, error);
        }
        let desc = AntumbraPlanDesc { camera: &CAMERA, ..Versioned::INIT };
        let result = antumbra_culler_plan(context, culler, hierarchy, &desc, null_mut(), error);
        expect(result, (BadPointer, "plan is null"), error);
    }
}

#[test]
fn objects_are_named_by_their_indices() {
    let mut host = Host::new();
    let context = host.context;
    let hierarchy = host.hierarchy;
    let error = &mut host.error;
    let bad = AntumbraAabb { min: [1.0; 3], max: [0.0; 3] };
    let expect = |result, expected: (AntumbraResult, &str), error: &AntumbraError| {
        let (wanted, words) = expected;
        assert_eq!(result, wanted, "{}", text(error));
        assert!(text(error).contains(words), "\"{}\" does not say \"{words}\"", text(error));
    };
    // SAFETY: pointers are null, which is refused, or to values on this stack.
    unsafe {
        let result = antumbra_hierarchy_move(context, hierarchy, &5, &cube(0.0, 0.0), 1, error);
        expect(result, (BadArgument, "objects[0]: object 5 is not"), error);
        let moves = [0, 1, 0];
        let boxes = [cube(0.0, -5.0), bad, bad];
        let at = moves.as_ptr();
        let to = boxes.as_ptr();
        let result = antumbra_hierarchy_move(context, hierarchy, at, to, 3, error);
        expect(result, (BadArgument, "objects[1]: object 1 has no usable"), error);
        let result = antumbra_hierarchy_move(context, hierarchy, null(), &bad, 1, error);
        expect(result, (BadPointer, "objects is null"), error);
        let result = antumbra_hierarchy_remove(context, hierarchy, &5, 1, error);
        expect(result, (BadArgument, "objects[0]: object 5 is not"), error);
        let gone = [1, 5];
        let result = antumbra_hierarchy_remove(context, hierarchy, gone.as_ptr(), 2, error);
        expect(result, (BadArgument, "objects[1]: object 5 is not"), error);
    }
}
