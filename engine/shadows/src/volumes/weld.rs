//! Welds vertices that are at the same position and always move together.

use std::collections::HashMap;

use glam::Vec3;

/// Returns for each vertex the first vertex with the same position and motion. Positions are
/// compared by their bits, except that -0.0 equals 0.0. Without `motions` all vertices move
/// together.
pub(super) fn weld(positions: &[Vec3], motions: &[u32]) -> Vec<u32> {
    let mut firsts: HashMap<([u32; 3], u32), u32> = HashMap::with_capacity(positions.len());
    let motions = motions.iter().copied().chain(std::iter::repeat(0));
    let places = positions.iter().zip(motions);
    let first_of = |(vertex, (position, motion)): (u32, (&Vec3, u32))| {
        // Adding 0.0 turns -0.0 into 0.0 and changes no other number.
        let bits = position.to_array().map(|number| (number + 0.0).to_bits());
        *firsts.entry((bits, motion)).or_insert(vertex)
    };
    (0..).zip(places).map(first_of).collect()
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;

    #[test]
    fn places_are_compared_by_their_bits_and_zero_has_no_sign() {
        let positions = [
            vec3(0.0, 1.0, 2.0),
            vec3(-0.0, 1.0, 2.0),
            vec3(0.0, 1.0_f32.next_up(), 2.0),
            vec3(0.0, 1.0, 2.0),
        ];
        assert_eq!(weld(&positions, &[]), [0, 0, 2, 0]);
    }

    #[test]
    fn vertices_that_move_apart_stay_apart() {
        let positions = [Vec3::ONE; 4];
        assert_eq!(weld(&positions, &[7, 8, 7, 8]), [0, 1, 0, 1]);
    }
}
