//! The shadow volumes of a view: the casters of each light, as ranges of leaves, and their way of
//! counting.

use std::f32::consts::FRAC_PI_2;
use std::ops::Range;

use cull::{Aabb, CullView, Hierarchy, LeafIndex, LeafRange, trigonometry};
use glam::{Vec3, Vec4};

use super::counting::{NearSpan, VolumeCounting};
use super::end::VolumeEnd;
use super::lit_area::LitArea;
use crate::light::{CONE_MARGIN, LightShape, ShadowLight};

/// The number of lights per layer of the mask: the bits of a texel.
pub const MASK_LIGHTS: u32 = 32;

/// A range of casters with the same way of counting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VolumeRange {
    /// The leaves of the casters.
    pub leaves: LeafRange,
    /// The way of counting that is right for each of the casters.
    pub counting: VolumeCounting,
}

/// The volumes of a light in a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedVolumes {
    /// The index of the light in the given list.
    pub light: usize,
    /// The part of the view that the light reaches: volumes need to be counted only in it.
    pub area: LitArea,
    /// The far ends that its volumes may have.
    pub ends: Vec<VolumeEnd>,
    /// The light's casters among [`VolumePlan::ranges`], ascending and disjoint.
    pub ranges: Range<usize>,
}

/// The shadow volumes of a view in a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VolumePlan {
    /// The lights with casters, in the given order, which is the order of the mask's bits.
    pub lights: Vec<PlannedVolumes>,
    /// The casters of all lights.
    pub ranges: Vec<VolumeRange>,
    /// The number of lights without volumes, since the mask had no bits left.
    pub unshadowed_lights: u32,
}

impl VolumePlan {
    /// Plans the volumes of all casters within reach, for at most `lights_max` lights that reach
    /// into a view. Lights that are not usable have none.
    pub fn plan(
        &mut self,
        lights: &[ShadowLight],
        hierarchy: &Hierarchy,
        view: &CullView,
        lights_max: usize,
    ) {
        self.lights.clear();
        self.ranges.clear();
        self.unshadowed_lights = 0;
        let span = NearSpan::points_of(&view.rays);
        let receivers = hierarchy.root().map_or(Aabb::EMPTY, |root| hierarchy.bounds(root));
        for (number, light) in lights.iter().enumerate() {
            if !light.shape.is_usable() {
                continue;
            }
            let Some(area) = LitArea::of(view, &light.shape, &receivers) else { continue };
            if self.lights.len() >= lights_max {
                self.unshadowed_lights += 1;
                continue;
            }
            let first = self.ranges.len();
            let lit = light.shape.reached(&receivers);
            let casters = Casting::of(&light.shape, &lit, NearSpan(&span));
            casters.list(hierarchy, &mut self.ranges);
            if self.ranges.len() > first {
                let ranges = first..self.ranges.len();
                let ends = VolumeEnd::of(view, light.shape.homogeneous(), &lit);
                self.lights.push(PlannedVolumes { light: number, area, ends, ranges });
            }
        }
    }

    /// Returns the casters of a light of the plan.
    pub fn ranges_of(&self, light: &PlannedVolumes) -> &[VolumeRange] {
        self.ranges.get(light.ranges.clone()).unwrap_or_default()
    }

    /// Returns true if the leaf is a caster of some light's volumes.
    #[must_use]
    pub fn has_caster(&self, leaf: LeafIndex) -> bool {
        self.lights.iter().any(|light| {
            let ranges = self.ranges_of(light);
            let behind = ranges.partition_point(|range| range.leaves.first <= leaf);
            let range = behind.checked_sub(1).and_then(|place| ranges.get(place));
            range.is_some_and(|range| leaf.0 - range.leaves.first.0 < range.leaves.count)
        })
    }
}

/// A light and an eye: the values that decide about casters.
struct Casting<'a> {
    light: Vec4,
    reach: Option<(Vec3, f32)>,
    /// The box around a local light and everything that it lights.
    rays: Option<Aabb>,
    /// The axis of a spot's cone, and the sine and cosine of its half angle.
    cone: Option<(Vec3, [f32; 2])>,
    span: NearSpan<'a>,
}

impl<'a> Casting<'a> {
    fn of(shape: &LightShape, lit: &Aabb, span: NearSpan<'a>) -> Self {
        let cone = match *shape {
            // The tests need a convex cone.
            LightShape::Spot { direction, outer_rad, .. } if outer_rad < FRAC_PI_2 => {
                Some((direction, [trigonometry::sin(outer_rad), trigonometry::cos(outer_rad)]))
            }
            LightShape::Spot { .. } | LightShape::Point { .. } | LightShape::Sun { .. } => None,
        };
        let reach = shape.reach();
        let rays = reach.map(|(position, _)| lit.union(&Aabb::new(position, position)));
        Self { light: shape.homogeneous(), reach, rays, cone, span }
    }

    /// Lists the casters in the light's reach. If a node's box does not need z-fail, nothing below
    /// it does.
    fn list(&self, hierarchy: &Hierarchy, ranges: &mut Vec<VolumeRange>) {
        let first = ranges.len();
        let mut open: Vec<_> = hierarchy.root().into_iter().collect();
        while let Some(node) = open.pop() {
            let bounds = hierarchy.bounds(node);
            if bounds.is_empty() || !self.meets(&bounds) {
                continue;
            }
            let counting = self.span.counting(&bounds, self.light);
            let is_one = counting == VolumeCounting::ZPass && self.holds(&bounds);
            match hierarchy.children(node) {
                Some([low, high]) if !is_one => open.extend([high, low]),
                _ => add(ranges, first, VolumeRange { leaves: hierarchy.leaves(node), counting }),
            }
        }
    }

    /// Returns true if the light may reach a part of a box.
    fn meets(&self, bounds: &Aabb) -> bool {
        let is_near =
            |(centre, reach_m): (Vec3, f32)| bounds.distance_squared(centre) <= reach_m * reach_m;
        let is_among = |rays: Aabb| bounds.meets(&rays);
        self.reach.is_none_or(is_near)
            && self.rays.is_none_or(is_among)
            && self.beside_cone(bounds).is_none_or(|[way_m, radius_m]| way_m <= radius_m)
    }

    /// Returns the distance of a box's centre from the nearest side of a spot's cone, negative
    /// inside, and the radius of the sphere around the box.
    fn beside_cone(&self, bounds: &Aabb) -> Option<[f32; 2]> {
        self.cone.map(|(direction, [sine, cosine])| {
            let away = bounds.centre() - self.light.truncate();
            let along_m = away.dot(direction);
            let aside_m = (away - along_m * direction).length();
            let radius_m = bounds.half_extent().length() + CONE_MARGIN * away.length();
            [aside_m * cosine - along_m * sine, radius_m]
        })
    }

    /// Returns true if the light reaches all of a box.
    fn holds(&self, bounds: &Aabb) -> bool {
        let is_within = |(centre, reach_m): (Vec3, f32)| {
            let farthest = (bounds.centre() - centre).abs() + bounds.half_extent();
            farthest.length_squared() <= reach_m * reach_m
        };
        self.reach.is_none_or(is_within)
            && self.rays.is_none_or(|rays| rays.contains(bounds))
            && self.beside_cone(bounds).is_none_or(|[way_m, radius_m]| way_m <= -radius_m)
    }
}

/// Adds a range to the ranges from `first` on, or extends the last of them if it continues there.
fn add(ranges: &mut Vec<VolumeRange>, first: usize, range: VolumeRange) {
    let has_before = ranges.len() > first;
    match ranges.last_mut().filter(|_| has_before) {
        Some(last)
            if last.counting == range.counting
                && last.leaves.first.0 + last.leaves.count == range.leaves.first.0 =>
        {
            last.leaves.count += range.leaves.count;
        }
        _ => ranges.push(range),
    }
}

#[cfg(test)]
mod tests {
    use cull::{Camera, ObjectId, Projection};
    use glam::vec3;

    use super::*;
    use crate::light::ShadowLightId;

    /// Returns a row of crates along x, one every two metres.
    fn crates() -> (Hierarchy, Vec<Aabb>) {
        let corner = |number: u32| vec3(2.0 * number as f32, 0.0, 0.0);
        let boxes = (0..64).map(|number| Aabb::new(corner(number), corner(number) + Vec3::ONE));
        let boxes: Vec<Aabb> = boxes.collect();
        (Hierarchy::build(&boxes).unwrap(), boxes)
    }

    fn view(eye: Vec3, at: Vec3) -> CullView {
        let projection = Projection::perspective(1.0);
        let camera = Camera { eye, forward: at - eye, up: Vec3::Y, projection, near: 0.1 };
        CullView::new(&camera, [64, 48], 8)
    }

    fn light(shape: LightShape) -> ShadowLight {
        ShadowLight { id: ShadowLightId(0), shape, penumbra_m: 0.0 }
    }

    fn lamp(x: f32, reach_m: f32) -> ShadowLight {
        light(LightShape::Point { position: vec3(x, 3.0, 0.5), reach_m })
    }

    const SUN: LightShape = LightShape::Sun { towards: Vec3::Y };

    fn planned(lights: &[ShadowLight], view: &CullView, lights_max: usize) -> VolumePlan {
        let mut plan = VolumePlan::default();
        plan.plan(lights, &crates().0, view, lights_max);
        plan
    }

    #[test]
    fn each_caster_in_reach_is_there_once_and_counted_as_its_own_box_allows() {
        let (hierarchy, boxes) = crates();
        // Directly below a crate of the row, seen from the sun.
        let view = view(vec3(40.5, -3.0, 0.5), vec3(41.0, -2.5, 0.0));
        for light in [light(SUN), lamp(44.0, 12.0), lamp(60.0, 500.0)] {
            let mut plan = VolumePlan::default();
            plan.plan(&[light], &hierarchy, &view, 1);
            let [of_light] = &plan.lights[..] else { panic!("one light: {plan:?}") };
            let span = NearSpan::points_of(&view.rays);
            let mut found = vec![None; boxes.len()];
            for range in plan.ranges_of(of_light) {
                for leaf in range.leaves.iter() {
                    let object = hierarchy.leaf_objects()[leaf.0 as usize];
                    assert_eq!(found[object.0 as usize].replace(range.counting), None);
                    assert!(plan.has_caster(leaf));
                }
            }
            let homogeneous = light.shape.homogeneous();
            let mut fails = 0;
            for (object, (counting, bounds)) in (0..).zip(found.iter().zip(&boxes)) {
                let reach = light.shape.reach();
                let is_met = reach.is_none_or(|(centre, reach_m)| {
                    bounds.distance_squared(centre) <= reach_m * reach_m
                });
                let expected = is_met.then(|| NearSpan(&span).counting(bounds, homogeneous));
                assert_eq!(*counting, expected, "crate {object}");
                fails += u32::from(expected == Some(VolumeCounting::ZFail));
                let leaf = hierarchy.leaf_of(ObjectId(object)).unwrap();
                assert_eq!(plan.has_caster(leaf), is_met);
            }
            assert!((1..8).contains(&fails), "{fails} by z-fail");
            assert!(plan.ranges.len() < 8, "neighbours are one range: {:?}", plan.ranges);
        }
    }

    #[test]
    fn a_spots_casters_are_those_that_its_cone_may_meet() {
        let (hierarchy, boxes) = crates();
        let view = view(vec3(60.0, 3.0, 30.0), vec3(60.0, 0.0, 0.0));
        for (number, outer_rad) in [0.1_f32, 0.4, 0.8, 1.3, 1.6].into_iter().enumerate() {
            let position = vec3(50.0, 4.0, 0.5);
            let direction = vec3(0.3, -1.0, 0.1 * number as f32).normalize();
            let shape = LightShape::Spot { position, direction, outer_rad, reach_m: 40.0 };
            let mut plan = VolumePlan::default();
            plan.plan(&[light(shape)], &hierarchy, &view, 1);
            let mut listed = 0;
            for (object, bounds) in (0..).zip(&boxes) {
                let is_listed = plan.has_caster(hierarchy.leaf_of(ObjectId(object)).unwrap());
                listed += u32::from(is_listed);
                // Points all over the box, in the cone or not.
                let steps = || (0..=6).map(|step| step as f32 / 3.0 - 1.0);
                let points = steps().flat_map(|x| steps().map(move |y| (x, y)));
                let points = points.flat_map(|(x, y)| steps().map(move |z| vec3(x, y, z)));
                let is_met = points.into_iter().any(|at| {
                    let away = bounds.centre() + at * bounds.half_extent() - position;
                    away.length() < 40.0 && away.angle_between(direction) < outer_rad
                });
                assert!(is_listed || !is_met, "crate {object} of {outer_rad}");
            }
            let expected = [1..4, 1..6, 2..12, 8..42, 20..42][number].clone();
            assert!(expected.contains(&listed), "{listed} crates of {outer_rad}");
        }
    }

    #[test]
    fn lights_beyond_the_view_and_beyond_the_mask_have_no_volumes() {
        let view = view(vec3(20.0, 2.0, 6.0), vec3(20.0, 0.0, 0.0));
        let lights = [lamp(20.0, 4.0), lamp(100.0, 4.0), light(SUN), lamp(21.0, 4.0)];
        let numbers =
            |plan: &VolumePlan| plan.lights.iter().map(|light| light.light).collect::<Vec<_>>();
        let all = planned(&lights, &view, 32);
        assert_eq!((numbers(&all), all.unshadowed_lights), (vec![0, 2, 3], 0));
        let two = planned(&lights, &view, 2);
        assert_eq!((numbers(&two), two.unshadowed_lights), (vec![0, 2], 1));
        let bad = [lamp(20.0, f32::NAN), lamp(20.0, 0.0), lamp(20.0, 0.5)];
        assert_eq!(planned(&bad, &view, 32), VolumePlan::default(), "nothing to do");
    }

    #[test]
    fn removed_objects_and_empty_scenes_cast_nothing() {
        let (mut hierarchy, boxes) = crates();
        (1..boxes.len() as u32).for_each(|object| hierarchy.remove(ObjectId(object)).unwrap());
        let view = view(vec3(0.5, 2.0, 6.0), vec3(0.5, 0.0, 0.0));
        let mut plan = VolumePlan::default();
        plan.plan(&[light(SUN)], &hierarchy, &view, 1);
        let left = hierarchy.leaf_of(ObjectId(0)).unwrap();
        assert!(plan.has_caster(left));
        hierarchy.remove(ObjectId(0)).unwrap();
        plan.plan(&[light(SUN)], &hierarchy, &view, 1);
        assert_eq!(plan, VolumePlan::default());
    }
}
