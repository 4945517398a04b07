//! Support functions: how far a set of points reaches along each direction, as a table over directions.
//!
//! The support function `h(d) = max p.d` of a set of points is sublinear: `h(a + b) <= h(a) + h(b)` and
//! `h(s d) = s h(d)` for `s >= 0`. So where a direction is a sum of tabulated ones with factors that are not
//! negative, the same sum of their entries is an upper bound: a table that is interpolated linearly never
//! says too little. The tabulated directions are a grid on the faces of the octahedron |x| + |y| + |z| = 1,
//! where such sums are found by a floor. The six axes are among them, so boxes are read off exactly.

use glam::{Vec3, Vec3A};

/// Steps along an edge of the octahedron; directions are 4 n^2 + 2. Neighbours are at most 14 degrees
/// apart, which makes a sphere at most 1.5 % too large, and a single point nothing.
const STEPS: i32 = 10;
const SIDE: usize = 2 * STEPS as usize + 1;

/// The directions of a table.
#[derive(Clone, Debug)]
pub(crate) struct Directions {
    directions: Vec<Vec3A>,
    /// From a place of the octahedron unfolded to a square to a direction.
    unfolded: Vec<u16>,
}

/// How far a set of points reaches along each of the directions; nothing reaches negative infinity.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Support(pub Vec<f32>);

/// Where a point of the grid is on the octahedron unfolded to a square: the lower four faces lie in its
/// corners.
fn square_index(i: i32, j: i32, is_below: bool) -> usize {
    let with_sign = |size: i32, of: i32| if of < 0 { -size } else { size };
    let (x, y) = if is_below {
        (with_sign(STEPS - j.abs(), i), with_sign(STEPS - i.abs(), j))
    } else {
        (i, j)
    };
    (y + STEPS) as usize * SIDE + (x + STEPS) as usize
}

impl Directions {
    pub fn new() -> Self {
        let mut directions = Vec::new();
        let mut unfolded = vec![0; SIDE * SIDE];
        for i in -STEPS..=STEPS {
            let rest = STEPS - i.abs();
            for j in -rest..=rest {
                let k = rest - j.abs();
                for k in if k == 0 { vec![0] } else { vec![k, -k] } {
                    if let Some(entry) = unfolded.get_mut(square_index(i, j, k < 0)) {
                        *entry = directions.len() as u16;
                    }
                    directions.push(Vec3A::new(i as f32, j as f32, k as f32) / STEPS as f32);
                }
            }
        }
        Self { directions, unfolded }
    }

    pub fn all(&self) -> &[Vec3A] {
        &self.directions
    }

    /// The support of nothing.
    pub fn nothing(&self) -> Support {
        Support(vec![f32::NEG_INFINITY; self.directions.len()])
    }

    /// An upper bound of how far the set reaches along `direction` (of any length).
    pub fn along(&self, support: &Support, direction: Vec3) -> f32 {
        let size = direction.abs();
        let sum = size.x + size.y + size.z;
        if sum <= 0.0 {
            return 0.0;
        }
        let (u, v) = (size.x / sum * STEPS as f32, size.y / sum * STEPS as f32);
        let (i, j) = (u.floor(), v.floor());
        let (across, up) = (u - i, v - j);
        let (i, j) = (i as i32, j as i32);
        let corners = if across + up <= 1.0 {
            [(i, j, 1.0 - across - up), (i + 1, j, across), (i, j + 1, up)]
        } else {
            [(i + 1, j + 1, across + up - 1.0), (i + 1, j, 1.0 - up), (i, j + 1, 1.0 - across)]
        };
        let mut reach = 0.0;
        for (i, j, factor) in corners {
            // Rounding can ask for a point beyond the edge, with next to no weight.
            let k = STEPS - i - j;
            if factor > 0.0 && k >= 0 {
                let i = if direction.x < 0.0 { -i } else { i };
                let j = if direction.y < 0.0 { -j } else { j };
                let square = square_index(i, j, k > 0 && direction.z < 0.0);
                let entry = self.unfolded.get(square).map(|entry| usize::from(*entry));
                reach +=
                    factor * entry.and_then(|entry| support.0.get(entry)).copied().unwrap_or(0.0);
            }
        }
        reach * sum
    }
}

impl Support {
    /// Adds a point.
    pub fn add(&mut self, directions: &Directions, point: Vec3A) {
        for (reach, direction) in self.0.iter_mut().zip(directions.all()) {
            *reach = reach.max(point.dot(*direction));
        }
    }

    /// Adds all that another set reaches.
    pub fn unite(&mut self, other: &Self) {
        for (reach, other) in self.0.iter_mut().zip(&other.0) {
            *reach = reach.max(*other);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn axes_are_tabulated_and_all_directions_are_found() {
        let directions = Directions::new();
        assert_eq!(directions.all().len(), 402);
        let numbered = Support((0..402).map(|index| index as f32).collect());
        for (index, direction) in directions.all().iter().enumerate() {
            let found = directions.along(&numbered, Vec3::from(*direction) * 7.0) / 7.0;
            assert!((found - index as f32).abs() < 0.05, "{direction}: {found} for {index}");
        }
    }

    fn vector() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-1.0_f32..1.0).prop_map(Vec3::from)
    }

    proptest! {
        #[test]
        fn a_table_never_says_too_little_and_not_much_too_much(
            points in prop::collection::vec(vector(), 1..6), direction in vector()
        ) {
            let directions = Directions::new();
            let mut support = directions.nothing();
            for point in &points {
                support.add(&directions, Vec3A::from(*point));
            }
            let exact = points.iter().map(|p| p.dot(direction)).fold(f32::NEG_INFINITY, f32::max);
            let found = directions.along(&support, direction);
            let size = points.iter().map(|p| p.length()).fold(0.0, f32::max) * direction.length();
            prop_assert!(found >= exact - 1e-5 * size, "{found} for {exact}");
            prop_assert!(found <= exact + 0.2 * size + 1e-6, "{found} for {exact}");
        }
    }
}
