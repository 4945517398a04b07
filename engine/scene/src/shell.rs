//! Triangles that enclose a volume, by the even-odd rule: a ray from outside crosses an even number
//! of them.

use std::collections::{HashMap, HashSet};

/// The kind of surface that triangles make.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Shell {
    /// The surface has border edges, so nothing is enclosed.
    #[default]
    Open,
    /// Every edge has an even number of triangles, whatever their winding.
    Closed,
    /// Every edge has an even number of triangles if the back of each triangle, a triangle of its
    /// own, is left out.
    ClosedTwice,
}

impl Shell {
    /// Returns the kind of triangles, each three indices of positions. Vertices at equal positions
    /// count as one; triangles without an area or with an invalid index are ignored.
    #[must_use]
    pub fn of(positions: &[[f32; 3]], indices: &[u32]) -> Self {
        let places = welded(positions);
        let mut triangles: HashMap<[u32; 3], [u32; 2]> = HashMap::new();
        for corners in indices.as_chunks::<3>().0 {
            let place = |index: &u32| places.get(*index as usize).copied();
            let [Some(a), Some(b), Some(c)] = corners.each_ref().map(place) else { continue };
            if a == b || b == c || c == a {
                continue;
            }
            let mut sorted = [a, b, c];
            sorted.sort_unstable();
            // Cyclic permutations of a sorted triple wind the same way.
            let winds_up =
                [(a, b), (b, c), (c, a)].iter().filter(|(from, to)| from < to).count() == 2;
            triangles.entry(sorted).or_default()[usize::from(winds_up)] += 1;
        }
        let is_twice = !triangles.is_empty() && triangles.values().all(|[up, down]| up == down);
        let mut borders = HashSet::new();
        let mut encloses = false;
        for ([a, b, c], [up, down]) in &triangles {
            let count = if is_twice { *up } else { up + down };
            if count % 2 == 0 {
                continue;
            }
            encloses = true;
            for edge in [[*a, *b], [*b, *c], [*a, *c]] {
                if !borders.remove(&edge) {
                    borders.insert(edge);
                }
            }
        }
        match is_twice {
            _ if !encloses || !borders.is_empty() => Self::Open,
            true => Self::ClosedTwice,
            false => Self::Closed,
        }
    }
}

/// Returns a number for each position, equal for equal positions.
fn welded(positions: &[[f32; 3]]) -> Vec<u32> {
    let mut known = HashMap::new();
    let mut place = |position: &[f32; 3]| {
        // Zero has two signs and is one place.
        let bits = position.map(|coordinate| (coordinate + 0.0).to_bits());
        let next = known.len() as u32;
        *known.entry(bits).or_insert(next)
    };
    positions.iter().map(&mut place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a cube of 24 vertices, four for each face.
    fn cube() -> (Vec<[f32; 3]>, Vec<u32>) {
        let corner = |number: usize| [0, 1, 2].map(|axis| (number >> axis & 1) as f32);
        let faces =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let positions = faces.as_flattened().iter().map(|number| corner(*number)).collect();
        let indices = (0..6).flat_map(|face| [0, 1, 2, 0, 2, 3].map(|at| 4 * face + at)).collect();
        (positions, indices)
    }

    #[test]
    fn a_cube_is_closed_whichever_way_its_triangles_wind() {
        let (positions, mut indices) = cube();
        assert_eq!(Shell::of(&positions, &indices), Shell::Closed);
        indices.swap(3, 4);
        assert_eq!(Shell::of(&positions, &indices), Shell::Closed);
        indices.extend([5, 5, 6]);
        assert_eq!(Shell::of(&positions, &indices), Shell::Closed, "a triangle without an area");
        assert_eq!(Shell::of(&positions, &indices[3..]), Shell::Open);
        assert_eq!(Shell::of(&[], &[]), Shell::Open);
        assert_eq!(Shell::of(&positions, &[0, 1, 99]), Shell::Open);
        // Each triangle again: a ray meets all of them twice, and is nowhere inside.
        indices.truncate(36);
        assert_eq!(Shell::of(&positions, &indices.repeat(2)), Shell::Open);
        assert_eq!(Shell::of(&positions, &indices.repeat(3)), Shell::Closed);
    }

    #[test]
    fn backs_that_are_triangles_of_their_own_count_once() {
        let (positions, mut indices) = cube();
        let backs: Vec<u32> =
            indices.as_chunks::<3>().0.iter().flat_map(|[a, b, c]| [*a, *c, *b]).collect();
        indices.extend(backs);
        assert_eq!(Shell::of(&positions, &indices), Shell::ClosedTwice);
        let open = [&indices[3..36], &indices[39..]].concat();
        assert_eq!(Shell::of(&positions, &open), Shell::Open);
    }

    #[test]
    fn zero_is_one_place_whatever_its_sign() {
        let (mut positions, indices) = cube();
        let zero = positions.iter_mut().find(|position| position[0] == 0.0).unwrap();
        zero[0] = -0.0;
        assert_eq!(Shell::of(&positions, &indices), Shell::Closed);
    }
}
