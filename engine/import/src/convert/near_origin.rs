//! Moves scenes that are far from the origin of their file near it, without rounding.

use animation::{Rest, RigNode};
use glam::{Affine3A, Vec3};

use super::nodes::local;

/// The distance along an axis, in metres, below which a scene is not moved along this axis.
const NEAR_M: f32 = 16.0;

/// The largest coordinate, in metres, up to which single precision holds all whole metres.
const FARTHEST_M: f32 = 16_777_216.0;

/// Returns the point that becomes the origin of a scene with objects at these places, in whole
/// metres. It is 0 along an axis if places are near the origin, on both sides of it, or too far
/// apart relative to their distance. Along other axes, each place is between half and twice the
/// point, so their difference is exact (Sterbenz).
pub(super) fn origin_of(places: impl Iterator<Item = Vec3>) -> Vec3 {
    let mut low = Vec3::INFINITY;
    let mut high = Vec3::NEG_INFINITY;
    for place in places {
        low = low.min(place);
        high = high.max(place);
    }
    let along = |low: f32, high: f32| {
        let nearest_m = low.abs().min(high.abs());
        let farthest_m = low.abs().max(high.abs());
        let is_far = low * high > 0.0 && nearest_m >= NEAR_M && farthest_m <= FARTHEST_M;
        if is_far && farthest_m <= 1.5 * nearest_m { (low * 0.5 + high * 0.5).round() } else { 0.0 }
    };
    Vec3::new(along(low.x, high.x), along(low.y, high.y), along(low.z, high.z))
}

/// Moves nodes, parents before children, and their world transforms by the opposite of a point.
pub(super) fn move_nodes(nodes: &mut [RigNode], worlds: &mut [Affine3A], origin: Vec3) {
    if origin == Vec3::ZERO {
        return;
    }
    for index in 0..nodes.len() {
        let node = &mut nodes[index];
        let above = node.parent.map(|parent| worlds[parent.0 as usize]);
        if above.is_none() {
            match &mut node.rest {
                Rest::Parts(parts) => parts.translation -= origin,
                Rest::Matrix(matrix) => matrix.translation -= glam::Vec3A::from(origin),
            }
        }
        worlds[index] = above.unwrap_or(Affine3A::IDENTITY) * local(&node.rest);
    }
}

#[cfg(test)]
mod tests {
    use animation::{RigNodeId, Trs};

    use super::*;

    #[test]
    fn axes_with_places_near_the_origin_stay() {
        let of = |places: &[Vec3]| origin_of(places.iter().copied());
        assert_eq!(of(&[]), Vec3::ZERO);
        assert_eq!(of(&[Vec3::new(1.0e6, 3.0, -20.4)]), Vec3::new(1.0e6, 0.0, -20.0));
        let places = [Vec3::new(1.0e6, -100.0, 100.0), Vec3::new(1.0e6 + 3.0, 100.0, 190.0)];
        assert_eq!(of(&places), Vec3::new(1.0e6 + 2.0, 0.0, 0.0));
        assert_eq!(of(&[Vec3::splat(1.0e9)]), Vec3::ZERO, "no whole metres there");
    }

    #[test]
    fn children_keep_what_single_precision_loses_far_away() {
        let node = |parent, translation| RigNode {
            name: String::new(),
            parent,
            rest: Rest::Parts(Trs { translation, ..Trs::IDENTITY }),
            weights: Vec::new(),
        };
        let far = Vec3::new(1.0e6, 0.0, -1.0e6);
        let mut nodes =
            [node(None, far), node(Some(RigNodeId(0)), Vec3::splat(0.01)), node(None, far)];
        let mut worlds = [Affine3A::IDENTITY; 3];
        move_nodes(&mut nodes, &mut worlds, far);
        let places = worlds.map(|world| Vec3::from(world.translation));
        assert_eq!(places, [Vec3::ZERO, Vec3::splat(0.01), Vec3::ZERO]);
    }
}
