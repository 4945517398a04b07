//! The margins of volumes: a volume contains what a filter finds beside a receiver's ray and deeper
//! than a receiver, and would not contain it without the margins.

use super::*;

/// A light, a box, and a receiver that a point of the box shades through a filter.
struct Shaded {
    reach: LightReach,
    bounds: Aabb,
    receiver: Vec3,
}

/// Returns a random case. A point of the box is moved along the ray of the light, towards the light
/// by up to the lead or away from it by any factor, and aside by up to the spread.
fn shaded(numbers: &mut Numbers) -> Shaded {
    let spread_m = numbers.between(0.0, 3.0);
    let reach = LightReach { spread_m, ..reaches(numbers) };
    let size = numbers.point(4.0).abs() + 0.05;
    let low = numbers.point(25.0);
    let caster = low + size * (numbers.point(0.5) + 0.5);
    let l = reach.light.truncate();
    let w = Vec3::splat(reach.light.w);
    // Half of the receivers lie between the lead and the box.
    let far = if reach.light.w == 0.0 { 30.0 } else { 3.0 };
    let k = if numbers.between(0.0, 1.0) < 0.5 {
        -reach.lead * numbers.between(0.0, 1.0)
    } else {
        numbers.between(0.0, far) * numbers.between(0.0, 1.0)
    };
    let aside = numbers.point(1.0).normalize_or_zero() * spread_m * numbers.between(0.8, 0.9999);
    let receiver = caster + k * (w * caster - l) + aside;
    Shaded { reach, bounds: Aabb::new(low, low + size), receiver }
}

/// Returns true if a point is in the volume of an enlarged box: if a factor within the bounds of
/// all axes moves some point of the box to it. Computed in 64 bits.
fn holds(proxy: &Aabb, length: VolumeLength, light: Vec4, point: Vec3) -> bool {
    let light = light.as_dvec4();
    let point = point.as_dvec3();
    let mut range = [-length.towards, length.away].map(f64::from);
    // Each side of `min <= (point + k l) / (1 + k w) <= max` bounds k.
    let mut bound = |slope: f64, most: f64| {
        if slope > 0.0 {
            range[1] = range[1].min(most / slope);
        } else if slope < 0.0 {
            range[0] = range[0].max(most / slope);
        } else if most < 0.0 {
            range[0] = f64::INFINITY;
        }
    };
    for axis in 0..3 {
        let [min, max] = [proxy.min[axis], proxy.max[axis]].map(f64::from);
        bound(min * light.w - light[axis], point[axis] - min);
        bound(light[axis] - max * light.w, max - point[axis]);
    }
    range[0] <= range[1]
}

/// Returns true if the receiver is in the volume of the box after `change` changed the margins.
fn is_held(view: &CullView, shaded: &Shaded, change: impl FnOnce(&mut LightReach)) -> bool {
    let mut reach = shaded.reach;
    change(&mut reach);
    let volumes = BoxShadowVolumes::new(view, reach, RECEIVERS, &[]);
    let proxy = volumes.enlarged(&shaded.bounds);
    holds(&proxy, volumes.length(&proxy), reach.light, shaded.receiver)
}

#[test]
fn what_filters_find_aside_and_deeper_is_in_the_volume_by_its_margins() {
    let mut numbers = Numbers(SplitMix64::new(17));
    let projection = Projection::perspective(1.0);
    // With many pixels the margin of proxies is small.
    let camera = Camera { eye: Vec3::ZERO, forward: Vec3::X, up: Vec3::Y, projection, near: 0.1 };
    let view = CullView::new(&camera, [8192, 8192], 8);
    let mut counted = [0; 2];
    let mut lost_without = [[0; 2]; 2];
    for round in 0..20_000 {
        let scene = shaded(&mut numbers);
        let LightReach { light, reach_m, .. } = scene.reach;
        let is_sun = light.w == 0.0;
        let is_lit = is_sun || scene.receiver.distance(light.truncate()) <= reach_m;
        if !is_lit || !RECEIVERS.contains_point(scene.receiver) {
            continue;
        }
        let kind = usize::from(is_sun);
        counted[kind] += 1;
        assert!(is_held(&view, &scene, |_| {}), "{round}: {:?} {:?}", scene.reach, scene.bounds);
        let without = [
            is_held(&view, &scene, |reach| reach.spread_m = 0.0),
            is_held(&view, &scene, |reach| reach.lead = 0.0),
        ];
        for (lost, is_held) in lost_without[kind].iter_mut().zip(without) {
            *lost += u32::from(!is_held);
        }
    }
    assert!(counted.iter().all(|counted| *counted > 2_000), "{counted:?}");
    let lost = lost_without.as_flattened();
    assert!(
        lost.iter().all(|count| *count > 100),
        "{lost_without:?} of {counted:?} need their margins"
    );
}
