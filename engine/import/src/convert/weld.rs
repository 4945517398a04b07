//! Makes nearly equal positions equal to the bit.
//!
//! Exporters compute the first and the last corner of a circle separately, so `sin(0)` and `sin(2
//! pi)` differ by 1e-16. A seam of such corners would be a border, and the mesh would enclose
//! nothing.

use std::collections::HashMap;

use foldhash::fast::RandomState;
use glam::{DVec3, Vec3};

/// The distance along an axis within which two positions count as equal, relative to the largest
/// coordinate of either: two steps of single precision. Positions farther apart may be a feature,
/// such as a small part beside a hall in the same mesh.
const WELD_SHARE: f32 = 2.0 * f32::EPSILON;

/// The width of the cells in which positions are searched, in multiples of the largest welding
/// distance at their scale.
const CELL: f64 = 4.0;

/// A cell of positions whose largest coordinates have the same binary exponent. One number is
/// hashed faster than four.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Cell(u128);

impl Cell {
    fn new(exponent: i32, place: [i32; 3]) -> Self {
        let [x, y, z] = place;
        Self(bytemuck::cast([exponent, x, y, z]))
    }
}

/// Moves each position to the first one that lies within its rounding.
pub(super) fn weld(positions: &mut [Vec3]) {
    let mut cells = Cells {
        first_of_cell: HashMap::with_capacity_and_hasher(
            positions.len() / 4,
            RandomState::default(),
        ),
        next_of: vec![None; positions.len()],
    };
    for index in 0..positions.len() {
        let at = positions[index];
        let own = cell_of(at);
        // Most vertices repeat a position. No other kept position is near it, since it would have
        // been moved there.
        if cells.find_in(own, positions, |place| bits(place) == bits(at)).is_some() {
            continue;
        }
        match cells.find_near(at, positions) {
            Some(place) => positions[index] = place,
            None => cells.next_of[index] = cells.first_of_cell.insert(own, index as u32),
        }
    }
}

/// The positions that were kept, by cell.
struct Cells {
    /// The last position of each cell. The hash is seeded, so a file cannot aim for collisions.
    first_of_cell: HashMap<Cell, u32, RandomState>,
    /// For each position the previous one in its cell.
    next_of: Vec<Option<u32>>,
}

impl Cells {
    /// Returns a position in a cell for which `is_wanted` returns true.
    fn find_in(
        &self,
        cell: Cell,
        positions: &[Vec3],
        is_wanted: impl Fn(Vec3) -> bool,
    ) -> Option<Vec3> {
        let mut candidate = self.first_of_cell.get(&cell).copied();
        while let Some(number) = candidate {
            let place = positions[number as usize];
            if is_wanted(place) {
                return Some(place);
            }
            candidate = self.next_of[number as usize];
        }
        None
    }

    /// Returns a position that counts as equal. It is in one of at most two cells per axis, and of
    /// two exponents if the largest coordinate is near a power of two.
    fn find_near(&self, at: Vec3, positions: &[Vec3]) -> Option<Vec3> {
        let own = tolerance(at);
        let is_near = |place: Vec3| (place - at).abs().max_element() <= own.max(tolerance(place));
        let largest = at.abs().max_element();
        // The tolerances of near positions differ by less than a thousandth.
        let reach = 1.125 * own;
        for exponent in exponent_of(largest - reach)..=exponent_of(largest + reach) {
            let offset = DVec3::splat(f64::from(reach));
            let low = place_of(at.as_dvec3() - offset, exponent);
            let high = place_of(at.as_dvec3() + offset, exponent);
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    for z in low[2]..=high[2] {
                        let cell = Cell::new(exponent, [x, y, z]);
                        let found = self.find_in(cell, positions, is_near);
                        if found.is_some() {
                            return found;
                        }
                    }
                }
            }
        }
        None
    }
}

fn bits(at: Vec3) -> [u32; 3] {
    at.to_array().map(f32::to_bits)
}

/// Returns the distance within which another position counts as equal.
fn tolerance(at: Vec3) -> f32 {
    at.abs().max_element() * WELD_SHARE
}

fn exponent_of(largest: f32) -> i32 {
    // All subnormal numbers have the same exponent.
    ((largest.to_bits() >> 23) & 0xff) as i32
}

/// Returns the indices of the cell that holds a position, for an exponent. A position of this
/// exponent is within 2^20 cells of the origin, and one of the next exponent within 2^21.
fn place_of(at: DVec3, exponent: i32) -> [i32; 3] {
    // The largest number of this exponent is below 2^(exponent - 126). All factors are powers of
    // two, so the product is exact.
    let cells_per_unit = power_of_two(126 - exponent) / (f64::from(WELD_SHARE) * CELL);
    (at * cells_per_unit).to_array().map(floor)
}

/// Returns 2 to the power of an exponent from -1022 to 1023.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((1023 + i64::from(exponent)) as u64) << 52)
}

/// Returns the greatest integer up to a number. On most targets this is faster than a call of the
/// library's function.
fn floor(number: f64) -> i32 {
    let truncated = number as i32;
    truncated.saturating_sub(i32::from(f64::from(truncated) > number))
}

fn cell_of(at: Vec3) -> Cell {
    let exponent = exponent_of(at.abs().max_element());
    Cell::new(exponent, place_of(at.as_dvec3(), exponent))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Returns coordinates of which many are within a few roundings of each other.
    fn coordinate() -> impl Strategy<Value = f32> {
        let base = proptest::sample::select(vec![0.0, 1.0, -1.0, 0.75, 2.0, 1.0e-40, 3.0e38]);
        (base, -6..6_i32).prop_map(|(base, steps): (f32, i32)| {
            f32::from_bits(base.to_bits().saturating_add_signed(steps))
        })
    }

    proptest! {
        #[test]
        fn positions_that_stay_are_apart_and_the_others_move_to_one_of_them(
            given in prop::collection::vec(prop::array::uniform3(coordinate()), 0..60)
        ) {
            let given: Vec<Vec3> = given.into_iter().map(Vec3::from_array).collect();
            let given: Vec<Vec3> = given.into_iter().filter(|at| at.is_finite()).collect();
            let mut welded = given.clone();
            weld(&mut welded);
            let is_near = |a: Vec3, b: Vec3| {
                (a - b).abs().max_element() <= tolerance(a).max(tolerance(b))
            };
            let mut kept: Vec<Vec3> = Vec::new();
            for (from, to) in given.into_iter().zip(welded) {
                if kept.iter().any(|&place| is_near(place, from)) {
                    prop_assert!(kept.contains(&to) && is_near(from, to));
                } else {
                    prop_assert_eq!(bits(from), bits(to));
                    kept.push(to);
                }
            }
        }
    }

    #[test]
    fn positions_within_rounding_become_the_first_of_them() {
        let seam = (2.0 * std::f64::consts::PI).sin() as f32;
        let mut positions = [
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::new(1.0, seam, -seam),
            Vec3::new(0.5, 1.0e-6, 0.0),
            Vec3::new(0.5, 0.0, 0.0),
            Vec3::new(1.0_f32.next_down(), 0.0, 0.0),
        ];
        weld(&mut positions);
        assert_ne!(seam, 0.0);
        assert_eq!(positions[1], positions[0]);
        assert_eq!(positions[4], positions[0]);
        assert_eq!(positions[2].y, 1.0e-6, "a millionth of the size is a feature");
        assert_eq!(positions[3].y, 0.0);
    }

    #[test]
    fn a_small_part_beside_a_large_one_keeps_its_features() {
        let small = [Vec3::new(0.01, 0.0, 0.0), Vec3::new(0.01, 1.0e-6, 0.0), Vec3::ZERO];
        let mut positions = vec![Vec3::splat(1.0e4)];
        positions.extend(small);
        weld(&mut positions);
        assert_eq!(positions[1..], small);
    }

    #[test]
    fn positions_on_both_sides_of_a_power_of_two_are_one() {
        for power in [1.0_f32, 2.0, 0.25, 1024.0] {
            let mut positions = [Vec3::new(power, 0.0, 0.3 * power), Vec3::ZERO];
            positions[1] = Vec3::new(power.next_down(), -0.0, 0.3 * power);
            weld(&mut positions);
            assert_eq!(positions[1], positions[0]);
            positions[1] = Vec3::new(power.next_up(), 0.0, 0.3 * power);
            weld(&mut positions);
            assert_eq!(positions[1], positions[0]);
        }
    }

    #[test]
    fn a_ball_of_three_js_is_closed() {
        // SphereGeometry: rings by angles in double precision, stored in single.
        let columns = 12_u32;
        let rows = 6_u32;
        let mut positions = Vec::new();
        for row in 0..=rows {
            let down = f64::from(row) / f64::from(rows) * std::f64::consts::PI;
            for column in 0..=columns {
                let around = f64::from(column) / f64::from(columns) * 2.0 * std::f64::consts::PI;
                let x = -around.cos() * down.sin();
                let z = around.sin() * down.sin();
                positions.push(glam::DVec3::new(x, down.cos(), z).as_vec3());
            }
        }
        let at = |row: u32, column: u32| row * (columns + 1) + column;
        let mut indices = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let a = at(row, column);
                let b = at(row, column + 1);
                let c = at(row + 1, column);
                let d = at(row + 1, column + 1);
                indices.extend([a, c, b, b, c, d]);
            }
        }
        let shell = |positions: &[Vec3]| {
            let positions: Vec<[f32; 3]> = positions.iter().map(Vec3::to_array).collect();
            scene::Shell::of(&positions, &indices)
        };
        assert_eq!(shell(&positions), scene::Shell::Open);
        weld(&mut positions);
        assert_eq!(shell(&positions), scene::Shell::Closed);
    }
}
