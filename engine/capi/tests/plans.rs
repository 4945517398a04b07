//! Plans through the interface equal those of the culler, and planning allocates no memory.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]
#![allow(unsafe_code, reason = "a host in C calls it so")]

use std::collections::VecDeque;
use std::ptr::null_mut;

use allocation_counter::measure;
use antumbra_capi::api::context::{antumbra_context_create, antumbra_context_destroy};
use antumbra_capi::api::culler::*;
use antumbra_capi::api::hierarchy::*;
use antumbra_capi::context::{AntumbraContext, AntumbraContextDesc};
use antumbra_capi::decisions::camera::AntumbraCamera;
use antumbra_capi::decisions::culler::*;
use antumbra_capi::decisions::hierarchy::*;
use antumbra_capi::decisions::plan::*;
use antumbra_capi::error::AntumbraResult::Ok;
use antumbra_capi::layout::Versioned;
use cull::{
    Aabb, Answer, ClipY, CullConfig, CullView, Culler, DepthConvention, FramePlan, Hierarchy,
    Strategy, ViewProjection, VisibilityTestSupport,
};
use glam::{Mat4, Vec3, vec3};

/// Returns a wall, and boxes behind it. The boxes at the edge of the wall show.
fn boxes() -> Vec<Aabb> {
    let wall = Aabb::new(vec3(-4.0, -3.0, -6.0), vec3(4.0, 3.0, -5.5));
    let small = (0..1_000).map(|number| {
        let [x, y, z] = [number % 20, number / 20 % 10, number / 200].map(|part| part as f32);
        let low = vec3(x * 0.7 - 7.0, y * 0.7 - 3.5, -12.0 - z * 1.3);
        Aabb::new(low, low + Vec3::splat(0.45))
    });
    std::iter::once(wall).chain(small).collect()
}

/// A hierarchy and a culler through the interface.
struct Interface {
    context: *mut AntumbraContext,
    hierarchy: AntumbraHierarchy,
    culler: AntumbraCuller,
}

impl Interface {
    fn new(boxes: &[Aabb]) -> Self {
        let boxes: Vec<AntumbraAabb> = boxes.iter().map(|bounds| (*bounds).into()).collect();
        let hierarchy_desc = AntumbraHierarchyDesc {
            boxes: boxes.as_ptr(),
            box_count: boxes.len(),
            ..Versioned::INIT
        };
        let culler_desc =
            AntumbraCullerDesc { testers: ANTUMBRA_HAS_FLAGS, seed: 5, ..Versioned::INIT };
        let mut context = null_mut();
        let mut hierarchy = AntumbraHierarchy { id: 0 };
        let mut culler = AntumbraCuller { id: 0 };
        // SAFETY: pointers to values on this stack.
        unsafe {
            antumbra_context_create(&AntumbraContextDesc::current(), &mut context, null_mut());
            antumbra_hierarchy_create(context, &hierarchy_desc, &mut hierarchy, null_mut());
            antumbra_culler_create(context, &culler_desc, &mut culler, null_mut());
        }
        Self { context, hierarchy, culler }
    }

    fn ingest(&self, answers: &[AntumbraAnswer]) {
        let Self { context, hierarchy, culler } = *self;
        let first = answers.as_ptr();
        let count = answers.len();
        // SAFETY: a slice.
        let result =
            unsafe { antumbra_culler_ingest(context, culler, hierarchy, first, count, null_mut()) };
        assert_eq!(result, Ok);
    }

    fn plan(&self, camera: &AntumbraCamera, query_budget: usize) -> AntumbraFramePlan {
        let Self { context, hierarchy, culler } = *self;
        let desc = AntumbraPlanDesc { camera, query_budget, ..Versioned::INIT };
        let mut plan = AntumbraFramePlan::INIT;
        // SAFETY: pointers to values on this stack.
        let result = unsafe {
            antumbra_culler_plan(context, culler, hierarchy, &desc, &mut plan, null_mut())
        };
        assert_eq!(result, Ok);
        plan
    }
}

impl Drop for Interface {
    fn drop(&mut self) {
        // SAFETY: it is no longer used.
        unsafe { antumbra_context_destroy(self.context, null_mut()) };
    }
}

/// Returns the view of a frame for both.
fn view(frame: u32) -> (AntumbraCamera, CullView) {
    let eye = vec3(f32::from(frame as u16 / 10 % 3) * 6.0 - 6.0, 0.0, 3.0);
    let projection = Mat4::from_cols_array(&[
        1.0, 0.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.1, 0.0,
    ]);
    let clip_from_world = (projection * Mat4::from_translation(-eye)).to_cols_array();
    let desc = AntumbraCamera {
        clip_from_world,
        sub_pixel_bits: 8,
        width: 160,
        height: 80,
        ..Versioned::INIT
    };
    let matrix = Mat4::from_cols_array(&clip_from_world);
    let projection = ViewProjection { matrix, depth: DepthConvention::Reversed, y: ClipY::Down };
    (desc, CullView::from_matrix(&projection, [160, 80], 8).unwrap())
}

/// Answers the queries of a plan: boxes at the wall and far to the right show.
fn answers(hierarchy: &Hierarchy, plan: &FramePlan) -> Vec<Answer> {
    let tested = plan.tests.iter().map(|test| test.tag);
    let queried = plan.queried_draws.iter().map(|(_, tag)| *tag);
    let shows = |bounds: Aabb| bounds.max.z > -7.0 || bounds.max.x > 6.0;
    let answer = |tag: cull::QueryTag| {
        let samples = u32::from(shows(hierarchy.bounds(tag.node)));
        Answer { tag, samples }
    };
    tested.chain(queried).map(answer).collect()
}

/// Returns the arrays of a plan for C as slices.
///
/// # Safety
/// The plan is the newest one of its culler.
unsafe fn parts(
    plan: &AntumbraFramePlan,
) -> (&[AntumbraDraw], &[AntumbraQueryTag], &[AntumbraTest], &[AntumbraRound]) {
    // SAFETY: the promise above.
    unsafe {
        (
            std::slice::from_raw_parts(plan.draws, plan.draw_count),
            std::slice::from_raw_parts(plan.queries, plan.query_count),
            std::slice::from_raw_parts(plan.tests, plan.test_count),
            std::slice::from_raw_parts(plan.rounds, plan.round_count),
        )
    }
}

#[test]
fn plans_are_those_of_the_culler_and_allocate_nothing_when_calm() {
    let boxes = boxes();
    let interface = Interface::new(&boxes);
    let hierarchy = Hierarchy::build(&boxes).unwrap();
    let support = VisibilityTestSupport { flags: true, ..Default::default() };
    let mut culler = Culler::with_testers(CullConfig { seed: 5, ..Default::default() }, support);
    let mut expected = FramePlan::default();
    let mut late: VecDeque<(Vec<AntumbraAnswer>, Vec<Answer>)> = VecDeque::new();
    let mut queried = 0;
    for frame in 0..90 {
        let (desc, view) = view(frame.min(40));
        let (known, known_here) = match late.len() {
            2 => late.pop_front().unwrap(),
            _ => Default::default(),
        };
        culler.ingest(&hierarchy, known_here);
        culler.plan(&hierarchy, Strategy::ANTUMBRA, &view, 100, &mut expected);

        let mut plan = AntumbraFramePlan::INIT;
        let allocated = measure(|| {
            interface.ingest(&known);
            plan = interface.plan(&desc, 100);
        });
        let allocated = allocated.count_total;
        assert!(frame < 60 || allocated == 0, "frame {frame}: {allocated} allocations");

        // SAFETY: it was just made.
        let (draws, queries, tests, rounds) = unsafe { parts(&plan) };
        assert_eq!(plan.frame, expected.frame.0);
        let plain = draws.iter().filter(|draw| draw.query == ANTUMBRA_NO_QUERY);
        let plain: Vec<u32> = plain.map(|draw| draw.leaf).collect();
        assert_eq!(plain, expected.draws.iter().map(|leaf| leaf.0).collect::<Vec<_>>());
        let mut before = expected.queried_after.iter();
        for (at, draw) in draws.iter().enumerate() {
            assert_eq!(draw.object, hierarchy.leaf_objects()[draw.leaf as usize].0);
            if draw.query != ANTUMBRA_NO_QUERY {
                let number = draw.query as usize;
                assert_eq!(draw.leaf, expected.queried_draws[number].0.0);
                assert_eq!(queries[number].node, expected.queried_draws[number].1.node.0);
                let after = at - number;
                assert_eq!(Some(&(after as u32)), before.next(), "its place, front to back");
            }
        }
        assert_eq!(queries.len(), expected.queried_draws.len());
        assert_eq!(tests.len(), expected.tests.len());
        for (test, wanted) in tests.iter().zip(&expected.tests) {
            assert_eq!(test.bounds, wanted.bounds.into());
            assert_eq!(test.first_leaf, wanted.leaves.first.0);
            assert_eq!(test.leaf_count, wanted.leaves.count);
            assert_eq!(test.tag.node, wanted.tag.node.0);
        }
        let ranges = rounds.iter().map(|round| {
            let first = round.first_test as usize;
            first..first + round.test_count as usize
        });
        assert_eq!(ranges.collect::<Vec<_>>(), expected.rounds);
        queried += queries.len();

        let answers = answers(&hierarchy, &expected);
        let for_c = tests.iter().map(|test| test.tag).chain(queries.iter().copied());
        let for_c = for_c.zip(&answers).map(|(tag, answer)| AntumbraAnswer {
            tag,
            samples: answer.samples,
            reserved: 0,
        });
        late.push_back((for_c.collect(), answers));
    }
    assert!(queried > 20, "{queried} draws with queries");
}

/// Checks that 0 means the documented default. It once meant no queries, and 2,914 boxes of a town
/// were drawn in place of 149.
#[test]
fn a_budget_of_zero_is_the_default_and_no_queries_are_another() {
    let boxes = boxes();
    let hierarchy = Hierarchy::build(&boxes).unwrap();
    let budgets = [0, 4096, ANTUMBRA_NO_QUERIES];
    let walk = budgets.map(|budget| {
        let interface = Interface::new(&boxes);
        let mut counts = Vec::new();
        for frame in 0..20 {
            let plan = interface.plan(&view(frame).0, budget);
            // SAFETY: it was just made.
            let (draws, queries, tests, _) = unsafe { parts(&plan) };
            counts.push([draws.len(), queries.len(), tests.len()]);
            let shows = |node| hierarchy.bounds(cull::NodeId(node)).max.z > -7.0;
            let tags = tests.iter().map(|test| test.tag).chain(queries.iter().copied());
            let answer = |tag: AntumbraQueryTag| AntumbraAnswer {
                tag,
                samples: u32::from(shows(tag.node)),
                reserved: 0,
            };
            interface.ingest(&tags.map(answer).collect::<Vec<_>>());
        }
        counts
    });
    assert_eq!(walk[0], walk[1]);
    assert!(walk[0].iter().any(|[_, queries, tests]| queries + tests > 20), "{:?}", walk[0]);
    assert!(walk[2].iter().all(|[_, queries, _]| *queries == 0), "{:?}", walk[2]);
}
