//! The leaves along a ray.

use glam::Vec3;

use super::super::Hierarchy;
use crate::geom::bounds::Aabb;
use crate::geom::margin::rounding;
use crate::ids::{LeafIndex, NodeId};

/// The share of a box's distance by which a ray may miss it and still counts as meeting it, beside
/// the rounding of its coordinates, so that no box is lost.
const TOLERANCE: f32 = 1e-4;

impl Hierarchy {
    /// Returns the leaves whose boxes are met by the ray from `origin` along `direction`, in the
    /// order of entry, with the distances in lengths of `direction`. A box that holds the origin is
    /// met at distance 0.
    #[must_use]
    pub fn leaves_along(&self, origin: Vec3, direction: Vec3) -> Vec<(f32, LeafIndex)> {
        let mut met = Vec::new();
        let mut stack: Vec<NodeId> = self.root().into_iter().collect();
        while let Some(node) = stack.pop() {
            let bounds = self.bounds(node);
            let reach = TOLERANCE * bounds.distance_squared(origin).sqrt()
                + rounding(&bounds, origin.abs().max_element());
            let Some(distance) = entry(&bounds.enlarged(reach), origin, direction) else {
                continue;
            };
            match self.children(node) {
                Some(children) => stack.extend(children),
                None => met.push((distance, self.leaves(node).first)),
            }
        }
        met.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        met
    }
}

/// Returns the distance at which a ray enters a box (Kay and Kajiya 1986: slabs); `None` if it
/// misses it.
fn entry(bounds: &Aabb, origin: Vec3, direction: Vec3) -> Option<f32> {
    let mut nearest = 0.0_f32;
    let mut farthest = f32::INFINITY;
    for axis in 0..3 {
        let start = origin[axis];
        let step = direction[axis];
        let low = bounds.min[axis];
        let high = bounds.max[axis];
        if step == 0.0 {
            // Along the slab: inside of it for ever, or never.
            if !(low..=high).contains(&start) {
                return None;
            }
            continue;
        }
        let a = (low - start) / step;
        let b = (high - start) / step;
        nearest = nearest.max(a.min(b));
        farthest = farthest.min(a.max(b));
    }
    (nearest <= farthest).then_some(nearest)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn cube(x: f32, y: f32, z: f32) -> Aabb {
        Aabb::new(Vec3::new(x, y, z), Vec3::new(x + 1.0, y + 1.0, z + 1.0))
    }

    #[test]
    fn what_is_nearer_comes_first_and_what_is_beside_or_behind_does_not() {
        let boxes =
            [cube(5.0, 0.0, 0.0), cube(2.0, 0.0, 0.0), cube(2.0, 3.0, 0.0), cube(-4.0, 0.0, 0.0)];
        let hierarchy = Hierarchy::build(&boxes).unwrap();
        let met = hierarchy.leaves_along(Vec3::new(0.0, 0.5, 0.5), Vec3::X);
        let objects: Vec<u32> =
            met.iter().map(|(_, leaf)| hierarchy.leaf_objects()[leaf.0 as usize].0).collect();
        assert_eq!(objects, [1, 0]);
        assert!((met[0].0 - 2.0).abs() < 1e-2 && (met[1].0 - 5.0).abs() < 1e-2, "{met:?}");
        // From inside of a box, backwards.
        let met = hierarchy.leaves_along(Vec3::new(2.5, 0.5, 0.5), -Vec3::X);
        assert_eq!((met.len(), met[0].0), (2, 0.0));
        assert!(Hierarchy::build(&[]).unwrap().leaves_along(Vec3::ZERO, Vec3::X).is_empty());
    }

    proptest! {
        #[test]
        fn no_box_that_holds_a_point_of_the_ray_is_missed(
            corners in prop::collection::vec((-50.0_f32..50.0, -50.0_f32..50.0, -50.0_f32..50.0), 1..60),
            target in any::<prop::sample::Index>(),
            inside in (0.0_f32..1.0, 0.0_f32..1.0, 0.0_f32..1.0),
            origin in (-80.0_f32..80.0, -80.0_f32..80.0, -80.0_f32..80.0),
        ) {
            let boxes: Vec<Aabb> = corners.iter().map(|(x, y, z)| cube(*x, *y, *z)).collect();
            let hierarchy = Hierarchy::build(&boxes).unwrap();
            let object = target.index(boxes.len());
            let point = boxes[object].min + Vec3::from(inside);
            let origin = Vec3::from(origin);
            let met = hierarchy.leaves_along(origin, point - origin);
            let leaf = hierarchy.leaf_of(crate::ObjectId(object as u32)).unwrap();
            let found = met.iter().find(|(_, met)| *met == leaf);
            prop_assert!(found.is_some_and(|(distance, _)| *distance <= 1.0));
            prop_assert!(met.is_sorted_by(|a, b| a.0 <= b.0));
        }
    }
}
