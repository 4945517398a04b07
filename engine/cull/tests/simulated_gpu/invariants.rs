//! Checks of the invariants of every plan, from the plan alone.

use antumbra_cull::{
    CullView, FramePlan, Hierarchy, LeafIndex, MultiView, ObjectId, QueryKind, SectionMember,
    SectionMode, SectionPlane, Strategy, VisibilityTest,
};
use glam::DVec4;

/// Checks a plan: each leaf in the frustum appears once, and order, rounds, budget and counts are
/// right.
pub fn check<'v>(
    hierarchy: &Hierarchy,
    strategy: Strategy,
    views: impl Into<MultiView<'v>>,
    budget: usize,
    plan: &FramePlan,
) -> Result<(), String> {
    let views: &[CullView] = views.into().as_slice();
    let mut places = vec![0_u32; hierarchy.leaf_objects().len()];
    let queried = plan.queried_draws.iter().map(|(leaf, _)| *leaf);
    let tested = plan.tests.iter().flat_map(|test| test.leaves.iter());
    for leaf in plan.draws.iter().copied().chain(queried).chain(tested) {
        places[leaf.0 as usize] += 1;
    }
    for (leaf, places) in places.iter().enumerate() {
        let needed = u32::from(views.iter().any(|view| meets_frustum(hierarchy, view, leaf)));
        if *places > 1 || *places < needed {
            return Err(format!("leaf {leaf} is in {places} places, needs {needed}"));
        }
    }
    if plan.query_count() > budget {
        return Err(format!("{} queries of {budget}", plan.query_count()));
    }
    let mut next = 0;
    for round in &plan.rounds {
        if round.start != next || round.is_empty() {
            return Err(format!("rounds {:?}", plan.rounds));
        }
        next = round.end;
    }
    if next != plan.tests.len() {
        return Err(format!("rounds {:?} of {}", plan.rounds, plan.tests.len()));
    }
    let stats = &plan.stats;
    if (stats.frontier + stats.pull_up_queries + stats.visible_box_queries) as usize
        != plan.tests.len()
    {
        return Err(format!("{stats:?} of {} tests", plan.tests.len()));
    }
    if strategy == Strategy::FRUSTUM && plan.query_count() > 0 {
        return Err("frustum culling asks nothing".to_owned());
    }
    fronts_answer_in_time(plan)?;
    is_front_to_back(hierarchy, views, plan)
}

fn is_front_to_back(
    hierarchy: &Hierarchy,
    views: &[CullView],
    plan: &FramePlan,
) -> Result<(), String> {
    let node_distance = |node| {
        let distance = |view: &CullView| view.rays.distance_squared(&hierarchy.bounds(node));
        views.iter().map(distance).fold(f32::INFINITY, f32::min)
    };
    let leaf_distance = |leaf: &LeafIndex| {
        let object = hierarchy.leaf_objects()[leaf.0 as usize];
        node_distance(hierarchy.node_of(object).unwrap())
    };
    let queried = plan.queried_after.iter().zip(&plan.queried_draws);
    let queried = queried.map(|(after, (leaf, _))| (*after, leaf_distance(leaf)));
    let is_sorted = plan.draws.iter().map(leaf_distance).is_sorted()
        && plan.queried_after.len() == plan.queried_draws.len()
        && plan.queried_after.iter().all(|after| *after as usize <= plan.draws.len())
        && queried.is_sorted()
        && [Answers::Queries, Answers::Compute, Answers::Flags, Answers::Others].iter().all(
            |answers| {
                let tests = plan.tests.iter().filter(|test| Answers::of(test.tester) == *answers);
                tests.map(|test| node_distance(test.tag.node)).is_sorted()
            },
        );
    is_sorted.then_some(()).ok_or_else(|| "not front to back".to_owned())
}

#[derive(PartialEq)]
enum Answers {
    Queries,
    Compute,
    Flags,
    Others,
}

impl Answers {
    fn of(tester: VisibilityTest) -> Self {
        match tester {
            VisibilityTest::Query => Self::Queries,
            VisibilityTest::Compute => Self::Compute,
            VisibilityTest::Flag => Self::Flags,
            VisibilityTest::SharedProxy(_) => Self::Others,
        }
    }
}

/// Checks that a test with a shared result refers to a test with its own flag in the same round or
/// earlier.
fn fronts_answer_in_time(plan: &FramePlan) -> Result<(), String> {
    for round in &plan.rounds {
        for (number, test) in round.clone().zip(&plan.tests[round.clone()]) {
            let VisibilityTest::SharedProxy(front) = test.tester else { continue };
            let in_time = plan.tests[..round.end].get(front as usize);
            let is_right = in_time.is_some_and(|front| {
                front.tester == VisibilityTest::Flag && front.leaves.count > 0
            });
            if !is_right || test.tag.kind != QueryKind::PerLeaf {
                return Err(format!("test {number} is behind {front}"));
            }
        }
    }
    Ok(())
}

/// Returns true if section planes leave something of an object's box.
fn is_left(hierarchy: &Hierarchy, view: &CullView, object: ObjectId) -> bool {
    let corners = hierarchy.bounds(hierarchy.node_of(object).unwrap()).corners();
    let keeps = |plane: &SectionPlane| {
        corners.iter().any(|corner| plane.distance_m(corner.as_dvec3()) >= 0.0)
    };
    let is_whole = hierarchy.section_member(object) == SectionMember::Whole;
    let mut planes = view.section.planes().iter();
    match view.section.mode() {
        _ if view.section.is_empty() || is_whole => true,
        SectionMode::Intersection => planes.all(keeps),
        SectionMode::Union => planes.any(keeps),
    }
}

/// Returns true if no frustum plane has the whole box outside, computed in 64 bits without any
/// allowance, and section planes leave something of the box.
fn meets_frustum(hierarchy: &Hierarchy, view: &CullView, leaf: usize) -> bool {
    let object = hierarchy.leaf_objects()[leaf];
    let bounds = hierarchy.bounds(hierarchy.node_of(object).unwrap());
    if bounds.is_empty() {
        return false;
    }
    let corners = bounds.corners().map(|corner| view.clip(corner));
    let reaches = |plane: fn(DVec4) -> f64| {
        corners.iter().any(|corner| plane(*corner) > 1e-9 * corner.abs().max_element())
    };
    is_left(hierarchy, view, object)
        && reaches(|clip| clip.w + clip.x)
        && reaches(|clip| clip.w - clip.x)
        && reaches(|clip| clip.w + clip.y)
        && reaches(|clip| clip.w - clip.y)
        && reaches(|clip| clip.w - clip.z)
        && reaches(|clip| clip.z)
}
