//! What every plan promises, checked without looking at how it came about.

use antumbra_cull::{FramePlan, Hierarchy, LeafIndex, Strategy, View};

/// Checks a plan: each leaf in the frustum in one place, order, rounds, budget, counts.
pub fn check(
    hierarchy: &Hierarchy,
    strategy: Strategy,
    view: &View,
    budget: usize,
    plan: &FramePlan,
) -> Result<(), String> {
    let mut places = vec![0_u32; hierarchy.leaf_objects().len()];
    let queried = plan.queried_draws.iter().map(|(leaf, _)| *leaf);
    let tested = plan.tests.iter().flat_map(|test| test.leaves.iter());
    for leaf in plan.draws.iter().copied().chain(queried).chain(tested) {
        places[leaf.0 as usize] += 1;
    }
    for (leaf, places) in places.iter().enumerate() {
        let needed = u32::from(meets_frustum(hierarchy, view, leaf));
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
    if (stats.frontier + stats.probes) as usize != plan.tests.len() {
        return Err(format!("{stats:?} of {} tests", plan.tests.len()));
    }
    if strategy == Strategy::Frustum && plan.query_count() > 0 {
        return Err("frustum culling asks nothing".to_owned());
    }
    is_front_to_back(hierarchy, view, plan)
}

fn is_front_to_back(hierarchy: &Hierarchy, view: &View, plan: &FramePlan) -> Result<(), String> {
    let leaf_distance = |leaf: &LeafIndex| {
        let object = hierarchy.leaf_objects()[leaf.0 as usize];
        let node = hierarchy.node_of(object).unwrap();
        hierarchy.bounds(node).distance_squared(view.eye)
    };
    let test_distance = |node| hierarchy.bounds(node).distance_squared(view.eye);
    let is_sorted = plan.draws.iter().map(leaf_distance).is_sorted()
        && plan.queried_draws.iter().map(|(leaf, _)| leaf_distance(leaf)).is_sorted()
        && plan.tests.iter().map(|test| test_distance(test.tag.node)).is_sorted();
    is_sorted.then_some(()).ok_or_else(|| "not front to back".to_owned())
}

/// In 64 bits and without any allowance: no plane of the frustum has the whole box outside.
fn meets_frustum(hierarchy: &Hierarchy, view: &View, leaf: usize) -> bool {
    let object = hierarchy.leaf_objects()[leaf];
    let bounds = hierarchy.bounds(hierarchy.node_of(object).unwrap());
    if bounds.is_empty() {
        return false;
    }
    let corners = bounds.corners().map(|corner| corner.as_dvec3() - view.eye.as_dvec3());
    let [right, up, forward] = [view.right, view.up, view.forward].map(|axis| axis.as_dvec3());
    let [tan_x, tan_y] = view.tan_half.map(f64::from);
    let reaches = |normal: glam::DVec3, offset: f64| {
        corners.iter().any(|corner| corner.dot(normal) > offset + 1e-9)
    };
    reaches(forward, f64::from(view.near))
        && reaches(right + forward * tan_x, 0.0)
        && reaches(-right + forward * tan_x, 0.0)
        && reaches(up + forward * tan_y, 0.0)
        && reaches(-up + forward * tan_y, 0.0)
}
