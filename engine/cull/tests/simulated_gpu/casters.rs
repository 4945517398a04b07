//! Tests of plans of casters: every object that shadows something in view is drawn, whatever
//! happens to the answers, and most other objects are left out.

use antumbra_cull::{
    Aabb, Answer, BoxShadowVolumes, Containment, CullConfig, CullView, Culler, DrawPhases,
    FramePlan, Frustum, Hierarchy, LightReach, MultiView, ObjectId, PlaneMask, Strategy,
    VisibilityTestSupport, VolumeLength,
};
use glam::{DVec2, DVec3, Vec4};

use crate::random::Random;
use crate::scene::{Lens, PATHS, Path, Scene};

const SEEDS: u64 = 400;
const FRAMES: u64 = 16;
const SIZE: [u32; 2] = [24, 16];

/// The ray of a pixel from the near plane on.
#[derive(Clone, Copy)]
struct Ray {
    from: DVec3,
    way: DVec3,
}

fn rays(view: &CullView) -> Vec<Ray> {
    let [width, height] = SIZE;
    let pixel = |number: u32| {
        let place = DVec2::new(f64::from(number % width), f64::from(number / width)) + 0.5;
        let ndc = place / DVec2::new(f64::from(width), f64::from(height)) * 2.0 - 1.0;
        let at = |depth_m: f32| view.rays.point(ndc.as_vec2(), depth_m).as_dvec3();
        let from = at(view.rays.near);
        Ray { from, way: at(view.rays.near + 1.0) - from }
    };
    (0..width * height).map(pixel).collect()
}

/// Returns the distances along a ray at which it enters and leaves a box, within `most`.
fn span(bounds: &Aabb, ray: Ray, most: f64) -> Option<[f64; 2]> {
    let mut first = 0.0_f64;
    let mut last = most;
    for axis in 0..3 {
        let low = f64::from(bounds.min[axis]) - ray.from[axis];
        let high = f64::from(bounds.max[axis]) - ray.from[axis];
        if ray.way[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let a = low / ray.way[axis];
        let b = high / ray.way[axis];
        (first, last) = (first.max(a.min(b)), last.min(a.max(b)));
    }
    (first <= last).then_some([first, last])
}

/// Returns the distance at which a ray meets the first solid, if it is before the far plane.
fn depth(solids: &[Aabb], ray: Ray, view: &CullView) -> Option<f64> {
    let entries = solids.iter().filter_map(|solid| span(solid, ray, f64::INFINITY));
    // From inside of a box, its far faces are visible.
    let hits = entries.map(|[first, last]| if first > 0.0 { first } else { last });
    let first = hits.min_by(f64::total_cmp)?;
    let point = (ray.from + ray.way * first).as_vec3();
    let place = view.frustum.classify(&Aabb::new(point, point), PlaneMask::ALL).0;
    (place != Containment::Outside).then_some(first)
}

/// Returns the distance at which a ray enters the shadow volume of a box: the least `t` of a linear
/// program in `t` and the factor `k` that moves a point of the box to the ray.
fn entry(proxy: &Aabb, length: VolumeLength, light: Vec4, ray: Ray) -> Option<f64> {
    let l = light.truncate().as_dvec3();
    let w = f64::from(light.w);
    // Each bound is `a t + b k <= c`.
    let mut bounds = vec![
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, f64::from(length.away)],
        [0.0, -1.0, f64::from(length.towards)],
    ];
    for axis in 0..3 {
        let low = f64::from(proxy.min[axis]);
        let high = f64::from(proxy.max[axis]);
        bounds.push([ray.way[axis], l[axis] - high * w, high - ray.from[axis]]);
        bounds.push([-ray.way[axis], low * w - l[axis], ray.from[axis] - low]);
    }
    let is_inside = |t: f64, k: f64| {
        let slack = 1.0e-7 * (1.0 + t.abs() + k.abs());
        bounds.iter().all(|[a, b, c]| a * t + b * k <= c + slack)
    };
    let mut least: Option<f64> = None;
    for (number, [a, b, c]) in bounds.iter().enumerate() {
        for [d, e, f] in &bounds[..number] {
            let determinant = a * e - b * d;
            let t = (c * e - b * f) / determinant;
            let k = (a * f - c * d) / determinant;
            if determinant.abs() > 1.0e-12 && is_inside(t, k) {
                least = Some(least.map_or(t, |least| least.min(t)));
            }
        }
    }
    least
}

fn light(random: &mut Random) -> LightReach {
    let (light, reach_m) = match random.below(2) {
        0 => (random.point(-1.0, 1.0).normalize().extend(0.0), f32::INFINITY),
        _ => (random.point(-12.0, 12.0).extend(1.0), random.between(3.0, 40.0)),
    };
    let spread_m = random.between(0.0, 0.2);
    let lead = random.between(0.0, 0.9);
    LightReach { light, reach_m, spread_m, lead }
}

/// The counts of the checked cases.
#[derive(Debug, Default)]
struct Checked {
    shadowing: u64,
    drawn: u64,
    casters: u64,
}

/// Returns true for each object that shadows something in a pixel.
fn shadowing(scene: &Scene, reach: &LightReach, seen: &[(Ray, Option<f64>)]) -> Vec<bool> {
    let mut casts = vec![false; scene.solids.len()];
    for (ray, depth) in seen.iter().filter_map(|(ray, depth)| Some((ray, (*depth)?))) {
        let from = ray.from + ray.way * depth;
        let light = reach.light.as_dvec4();
        let way = light.truncate() - from * light.w;
        let is_lit = light.w == 0.0 || way.length() <= f64::from(reach.reach_m);
        // A sun is farther away than all objects.
        let most = if light.w == 0.0 { f64::INFINITY } else { 1.0 };
        for (solid, casts) in scene.solids.iter().zip(&mut casts).filter(|_| is_lit) {
            *casts |= span(solid, Ray { from, way }, most).is_some();
        }
    }
    casts
}

fn verify(seed: u64, checked: &mut Checked) {
    let mut random = Random::new(seed.wrapping_mul(17) + 3);
    let mut scene = Scene::random(&mut random, 8);
    let mut hierarchy = Hierarchy::build(&scene.bounds).unwrap();
    let mut camera = Path::start(&mut random);
    let lens = Lens::random(&mut random, &mut camera);
    let path = PATHS[random.below(PATHS.len())];
    let mut reach = light(&mut random);
    let is_moving = random.chance(0.4);
    let is_light_moving = random.chance(0.3);
    let latency = 1 + random.below(3);
    let lost = [0.0, 0.2][random.below(2)];
    let testers =
        VisibilityTestSupport { flags: true, draw_phases: DrawPhases::Two, ..Default::default() };
    let config = CullConfig { seed, ..CullConfig::default() };
    let mut culler = Culler::with_testers(config, testers);
    let mut plan = FramePlan::default();
    let mut pending = Vec::<Vec<Answer>>::new();
    for frame in 0..FRAMES {
        path.advance(&mut camera, frame, &mut random);
        if is_moving {
            let object = scene.move_one(&mut random);
            hierarchy.refit([(ObjectId(object as u32), scene.bounds[object])]).unwrap();
        }
        if is_light_moving {
            reach.light += (random.point(-0.2, 0.2) * reach.light.w).extend(0.0);
        }
        let view = lens.view(&camera, frame, SIZE, 8);
        let receivers = hierarchy.bounds(hierarchy.root().unwrap());
        let everywhere = [Frustum::EVERYTHING];
        let volumes = BoxShadowVolumes::new(&view, reach, receivers, &everywhere);
        if pending.len() > latency {
            culler.ingest(&hierarchy, pending.remove(0));
        }
        let budget = [4, 1_000][random.below(2)];
        let views = MultiView::of_shadows(&view, &volumes);
        culler.plan(&hierarchy, Strategy::ANTUMBRA, views, budget, &mut plan);
        assert!(plan.has_two_phases());
        let seen: Vec<_> =
            rays(&view).into_iter().map(|ray| (ray, depth(&scene.solids, ray, &view))).collect();
        let mut drawn = vec![false; scene.solids.len()];
        let leaves = hierarchy.leaf_objects();
        plan.draws.iter().for_each(|leaf| drawn[leaves[leaf.0 as usize].0 as usize] = true);
        let mut answers = Vec::new();
        for test in &plan.tests {
            let length = volumes.length(&test.bounds);
            let shows = seen.iter().any(|(ray, depth)| {
                let entry = entry(&test.bounds, length, reach.light, *ray);
                entry.is_some_and(|entry| entry <= depth.unwrap_or(f64::INFINITY))
            });
            if shows {
                let range = test.leaves.first.0 as usize..;
                let revealed = leaves[range].iter().take(test.leaves.count as usize);
                revealed.for_each(|object| drawn[object.0 as usize] = true);
            }
            if !random.chance(lost) {
                answers.push(Answer { tag: test.tag, samples: u32::from(shows) });
            }
        }
        pending.push(answers);
        for (object, casts) in shadowing(&scene, &reach, &seen).into_iter().enumerate() {
            assert!(
                drawn[object] || !casts,
                "seed {seed}, frame {frame}: {object} is missing, {reach:?}"
            );
            checked.shadowing += u64::from(casts);
            checked.drawn += u64::from(drawn[object]);
            checked.casters += 1;
        }
    }
}

#[test]
fn no_caster_of_a_visible_shadow_is_ever_missing() {
    let mut checked = Checked::default();
    (0..SEEDS).for_each(|seed| verify(seed, &mut checked));
    println!("{checked:?}");
    let Checked { shadowing, drawn, casters } = checked;
    assert!(shadowing > 10_000, "hardly anything has a visible shadow");
    assert!(drawn * 4 < casters * 3, "hardly anything was left out");
}
