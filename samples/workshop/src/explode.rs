//! Exploded views: displacements that separate boxes by a guaranteed gap.
//!
//! Boxes are placed one at a time, from the middle outwards. Each box moves away from the middle
//! along its own direction until it is clear of all boxes placed before. Along this ray, a box
//! overlaps another box in a single interval, so each placed box is passed only once, and the
//! search ends. Touching, coincident and central parts are separated, too: if the places do not
//! determine a direction, it is taken from a spiral over the sphere.

use std::f64::consts::PI;

use antumbra::cull::Aabb;
use antumbra::glam::{DVec3, Vec3};
use parry3d::partitioning::{Bvh, BvhNode};

/// The angle between consecutive directions of the spiral, in radians: the golden angle.
const GOLDEN_ANGLE_RAD: f64 = 2.399_963_229_728_653;

/// The combined rounding error of two coordinates in single precision, relative to the coordinate.
const PLACE_SHARE: f64 = 2.0 * f32::EPSILON as f64;

/// The share of the assembly's size below which a box counts as central.
const CENTRAL_SHARE: f64 = 1e-6;

/// The share of sizes and displacements by which gaps are enlarged, against the rounding of
/// displacements and of their sums with coordinates in single precision.
const ROUNDING_SHARE: f64 = 1e-6;

/// Returns a displacement for each box, in metres. The displaced boxes are at least `gap_m` apart
/// along one of the axes. The box nearest to the middle does not move.
pub fn explode(boxes: &[Aabb], gap_m: f32) -> Vec<Vec3> {
    let all = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(bounds));
    let middle = centre(&all);
    let size = (all.max - all.min).as_dvec3().length();
    let farthest = all.min.abs().max(all.max.abs()).max_element();
    let place_rounding = if farthest.is_finite() { f64::from(farthest) * PLACE_SHARE } else { 0.0 };
    let gap = f64::from(gap_m.max(0.0));
    let mut reach = size;
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    let distance = |index: &usize| centre(&boxes[*index]).distance_squared(middle);
    order.sort_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)));

    let mut displacements = vec![Vec3::ZERO; boxes.len()];
    let mut placed = BoxTree::default();
    for (rank, index) in order.into_iter().enumerate() {
        let bounds = DBox::of(&boxes[index]);
        let outward = centre(&boxes[index]) - middle;
        let direction = if outward.length() > size * CENTRAL_SHARE {
            outward.normalize()
        } else {
            spiral_direction(rank, boxes.len())
        };
        let least = placed.free_distance(&bounds, direction, gap, 0.0);
        reach = reach.max(size + least * (1.0 + ROUNDING_SHARE));
        let roomy = gap + reach * ROUNDING_SHARE + place_rounding;
        let distance = placed.free_distance(&bounds, direction, roomy, least);
        let displacement = (direction * distance).as_vec3();
        placed.insert(bounds.moved(displacement.as_dvec3()));
        displacements[index] = displacement;
    }
    displacements
}

/// Returns the least gap between two boxes, in metres. The gap of a pair is measured along the axis
/// with the largest gap, and is negative if the boxes overlap. `None` for fewer than two boxes.
pub fn least_gap(boxes: &[Aabb]) -> Option<f64> {
    let mut placed = BoxTree::default();
    let mut least: Option<f64> = None;
    for bounds in boxes.iter().map(DBox::of) {
        // The first pairs may be far apart: the gap to any box is a valid bound.
        let bound = least.or_else(|| placed.boxes.last().map(|other| bounds.gap(other)));
        if let Some(bound) = bound {
            let gaps = placed.within(&bounds, bound.max(0.0)).map(|other| bounds.gap(other));
            least = gaps.chain([bound]).min_by(f64::total_cmp);
        }
        placed.insert(bounds);
    }
    least
}

/// Boxes in a spatial index.
#[derive(Default)]
struct BoxTree {
    boxes: Vec<DBox>,
    tree: Bvh,
}

impl BoxTree {
    fn insert(&mut self, bounds: DBox) {
        self.tree.insert(bounds.outer(), self.boxes.len() as u32);
        self.boxes.push(bounds);
    }

    /// Returns the boxes at most a gap away from a box, and possibly some others.
    fn within(&self, bounds: &DBox, gap: f64) -> impl Iterator<Item = &DBox> {
        let looser = DBox { min: bounds.min - gap, max: bounds.max + gap }.outer();
        let node = BvhNode::leaf(looser, 0);
        let found = self.tree.leaves(move |other| other.intersects(&node));
        found.filter_map(|index| self.boxes.get(index as usize))
    }

    /// Returns the least distance along `direction`, not less than `below`, at which a box is clear
    /// of all boxes.
    fn free_distance(&self, bounds: &DBox, direction: DVec3, gap: f64, below: f64) -> f64 {
        let mut distance = below;
        loop {
            let there = bounds.moved(direction * distance);
            let exits = self.within(&there, gap).filter(|other| there.gap(other) < gap);
            let exits = exits.map(|other| bounds.exit_distance(other, direction, gap));
            // A direction has unit length, so some axis moves and every exit is finite.
            let next = exits.fold(distance, f64::max);
            if next <= distance {
                return distance;
            }
            distance = next;
        }
    }
}

/// Returns direction `index` of `count` directions that are spread evenly over the sphere.
fn spiral_direction(index: usize, count: usize) -> DVec3 {
    let share = (index as f64 + 0.5) / count.max(1) as f64;
    let (sine, cosine) = (index as f64 * GOLDEN_ANGLE_RAD).rem_euclid(2.0 * PI).sin_cos();
    let height = 1.0 - 2.0 * share;
    let radius = (1.0 - height * height).max(0.0).sqrt();
    DVec3::new(radius * cosine, height, radius * sine).normalize_or(DVec3::Y)
}

fn centre(bounds: &Aabb) -> DVec3 {
    (bounds.min.as_dvec3() + bounds.max.as_dvec3()) * 0.5
}

/// A box in double precision.
#[derive(Clone, Copy)]
struct DBox {
    min: DVec3,
    max: DVec3,
}

impl DBox {
    fn of(bounds: &Aabb) -> Self {
        Self { min: bounds.min.as_dvec3(), max: bounds.max.as_dvec3() }
    }

    /// Returns a box of single precision that encloses it.
    fn outer(&self) -> parry3d::bounding_volume::Aabb {
        parry3d::bounding_volume::Aabb {
            mins: self.min.to_array().map(|place| (place as f32).next_down()).into(),
            maxs: self.max.to_array().map(|place| (place as f32).next_up()).into(),
        }
    }

    fn moved(&self, by: DVec3) -> Self {
        Self { min: self.min + by, max: self.max + by }
    }

    /// Returns the gap to another box along the axis with the largest gap.
    fn gap(&self, other: &Self) -> f64 {
        (other.min - self.max).max(self.min - other.max).max_element()
    }

    /// Returns the distance along `direction` from which on this box is clear of another one.
    fn exit_distance(&self, other: &Self, direction: DVec3, gap: f64) -> f64 {
        let exit = |axis: usize| {
            let speed = direction[axis];
            if speed > 0.0 {
                (other.max[axis] + gap - self.min[axis]) / speed
            } else if speed < 0.0 {
                (other.min[axis] - gap - self.max[axis]) / speed
            } else {
                f64::INFINITY
            }
        };
        exit(0).min(exit(1)).min(exit(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cube(middle: Vec3, half: f32) -> Aabb {
        Aabb { min: middle - half, max: middle + half }
    }

    fn assert_apart(boxes: &[Aabb], gap_m: f32) {
        let displacements = explode(boxes, gap_m);
        let moved: Vec<Aabb> = boxes
            .iter()
            .zip(&displacements)
            .map(|(bounds, by)| Aabb { min: bounds.min + *by, max: bounds.max + *by })
            .collect();
        let moved_boxes: Vec<DBox> = moved.iter().map(DBox::of).collect();
        let pairs = moved_boxes.iter().enumerate().flat_map(|(index, one)| {
            moved_boxes[index + 1..].iter().map(move |other| one.gap(other))
        });
        let gap = pairs.min_by(f64::total_cmp);
        assert_eq!(least_gap(&moved), gap);
        let gap = gap.unwrap_or(f64::INFINITY);
        assert!(gap >= f64::from(gap_m), "{gap}: {boxes:?}: {displacements:?}");
    }

    #[test]
    fn touching_coincident_and_central_parts_separate() {
        let touching = [cube(Vec3::ZERO, 1.0), cube(Vec3::X * 2.0, 1.0)];
        let coincident = [cube(Vec3::ONE, 0.5); 7];
        let central = [cube(Vec3::ZERO, 5.0), cube(Vec3::ZERO, 1.0), cube(Vec3::ZERO, 0.1)];
        for boxes in [&touching[..], &coincident, &central] {
            assert_apart(boxes, 0.25);
        }
    }

    #[test]
    fn parts_far_from_the_origin_separate() {
        for far_m in [1.0e4, 1.0e5, 1.0e6] {
            let at = |x: f32| cube(Vec3::new(far_m + x, 0.0, -far_m), 0.5);
            assert_apart(&[at(0.0), at(1.0), at(2.0)], 0.01);
        }
    }

    #[test]
    fn parts_that_are_clear_stay() {
        let boxes = [cube(Vec3::ZERO, 1.0), cube(Vec3::X * 3.0, 1.0), cube(Vec3::Y * -9.0, 1.0)];
        assert_eq!(explode(&boxes, 0.5), [Vec3::ZERO; 3]);
        assert_eq!(explode(&[], 0.5), []);
    }

    #[test]
    fn flat_and_empty_extents_separate() {
        let sheet = Aabb { min: Vec3::new(-1.0, 0.0, -1.0), max: Vec3::new(1.0, 0.0, 1.0) };
        assert_apart(&[sheet, sheet, cube(Vec3::ZERO, 0.0)], 0.1);
    }

    proptest! {
        #[test]
        fn no_two_boxes_are_nearer_than_the_gap(
            places in prop::collection::vec(
                (prop::array::uniform3(-3.0_f32..3.0), 0.0_f32..2.0), 1..24),
            gap_m in prop_oneof![0.01_f32..1.0, 1.0_f32..1.0e3],
        ) {
            let boxes: Vec<Aabb> =
                places.iter().map(|(middle, half)| cube((*middle).into(), *half)).collect();
            assert_apart(&boxes, gap_m);
        }
    }
}
