//! The distance up to which directional lights have shadows if the options do not set it.

use cull::Hierarchy;

use crate::face::CASCADE_RATIO;

/// The distance in a scene whose unit is the metre (metres).
const LEAST_M: f32 = 200.0;

/// The distance relative to the median size of objects: about right for a street of houses.
const SIZES: f32 = 20.0;

/// The largest distance relative to the size of the scene, for scenes of a few large objects.
const SCENE_SIZES: f32 = 2.0;

/// Returns the distance in the scene of a hierarchy (metres). It is 200, multiplied by powers of
/// the ratio of two cascades if half of the objects are larger than houses. So a scene in another
/// unit has shadows over the same part of it as a scene in metres.
pub(crate) fn sun_distance_m(hierarchy: &Hierarchy) -> f32 {
    let objects = hierarchy.leaf_objects().iter();
    let boxes =
        objects.filter_map(|object| hierarchy.node_of(*object)).map(|node| hierarchy.bounds(node));
    let sizes = boxes
        .filter(|bounds| !bounds.is_empty())
        .map(|bounds| 2.0 * bounds.half_extent().max_element());
    let mut sizes: Vec<f32> = sizes.collect();
    let middle = sizes.len() / 2;
    let (Some(root), true) = (hierarchy.root(), middle < sizes.len()) else { return LEAST_M };
    let (_, median_m, _) = sizes.select_nth_unstable_by(middle, f32::total_cmp);
    let scene_m = 2.0 * hierarchy.bounds(root).half_extent().length();
    let wanted_m = (SIZES * *median_m).min(SCENE_SIZES * scene_m);
    let steps = (wanted_m / LEAST_M).log(CASCADE_RATIO).round().max(0.0);
    LEAST_M * CASCADE_RATIO.powf(steps)
}

#[cfg(test)]
mod tests {
    use cull::Aabb;
    use glam::{Vec3, vec3};

    use super::*;

    /// Returns a row of things on a ground, in a unit of `unit_m` metres.
    fn town(things: u32, unit_m: f32) -> Hierarchy {
        let corner = |number: u32| vec3(15.0 * number as f32, 0.0, 0.0);
        let thing = |number| Aabb::new(corner(number), corner(number) + Vec3::splat(9.0));
        let ground = Aabb::new(vec3(-200.0, -1.0, -200.0), vec3(800.0, 0.0, 200.0));
        let boxes = (0..things).map(thing).chain([ground]);
        let boxes = boxes.map(|bounds| Aabb::new(bounds.min * unit_m, bounds.max * unit_m));
        Hierarchy::build(&boxes.collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn it_follows_the_unit_of_a_scene_in_steps_of_cascades() {
        let of = |unit_m| sun_distance_m(&town(40, unit_m));
        assert_eq!([of(0.01), of(1.0), of(1.5)], [200.0; 3]);
        assert_eq!([of(3.0), of(1000.0)], [600.0, 145_800.0]);
        assert_eq!(sun_distance_m(&Hierarchy::build(&[]).unwrap()), 200.0);
        // A terrain is a single object: the distance is limited by the scene's size.
        let terrain = [Aabb::new(Vec3::splat(-500.0), Vec3::splat(500.0))];
        assert_eq!(sun_distance_m(&Hierarchy::build(&terrain).unwrap()), 5400.0);
    }
}
