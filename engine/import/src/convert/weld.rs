//! Makes nearly equal positions equal to the bit.
//!
//! Exporters compute the first and the last corner of a circle separately, so `sin(0)` and `sin(2
//! pi)` differ by 1e-16. A seam of such corners would be a border, and the mesh would enclose
//! nothing.

use std::collections::HashMap;

use glam::Vec3;

/// The distance along an axis within which two positions count as equal, relative to the largest
/// coordinate of either: two steps of single precision. Positions farther apart may be a feature,
/// such as a small part beside a hall in the same mesh.
const WELD_SHARE: f32 = 2.0 * f32::EPSILON;

/// The width of the cells in which positions are searched, in multiples of the largest welding
/// distance at their scale.
const CELL: f64 = 4.0;

/// A cell of positions whose largest coordinates have the same binary exponent.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Cell {
    exponent: i32,
    place: [i64; 3],
}

/// Moves each position to the first one that lies within its rounding.
pub(super) fn weld(positions: &mut [Vec3]) {
    // The first position of each cell, and for each position the next one in its cell.
    let mut first_of_cell: HashMap<Cell, u32> = HashMap::with_capacity(positions.len() / 4);
    let mut next_of: Vec<Option<u32>> = vec![None; positions.len()];
    for index in 0..positions.len() {
        let at = positions[index];
        let near = cells_near(at).find_map(|cell| {
            let mut candidate = first_of_cell.get(&cell).copied();
            while let Some(number) = candidate {
                let place = positions[number as usize];
                if (place - at).abs().max_element() <= tolerance(at).max(tolerance(place)) {
                    return Some(place);
                }
                candidate = next_of[number as usize];
            }
            None
        });
        match near {
            Some(place) => positions[index] = place,
            None => next_of[index] = first_of_cell.insert(cell_of(at), index as u32),
        }
    }
}

/// Returns the distance within which another position counts as equal.
fn tolerance(at: Vec3) -> f32 {
    at.abs().max_element() * WELD_SHARE
}

fn exponent_of(largest: f32) -> i32 {
    // All subnormal numbers have the same exponent.
    ((largest.to_bits() >> 23) & 0xff) as i32
}

/// Returns the index of the cell that holds a coordinate, for an exponent.
fn place_of(coordinate: f64, exponent: i32) -> i64 {
    // The largest number of this exponent is below 2^(exponent - 126).
    let width = f64::from(WELD_SHARE) * CELL * f64::from(exponent - 126).exp2();
    (coordinate / width).floor() as i64
}

fn cell_of(at: Vec3) -> Cell {
    let exponent = exponent_of(at.abs().max_element());
    let place = at.to_array().map(|coordinate| place_of(f64::from(coordinate), exponent));
    Cell { exponent, place }
}

/// Returns all cells that may hold a position equal to this one: at most two per axis, and cells of
/// two exponents if the largest coordinate is near a power of two.
fn cells_near(at: Vec3) -> impl Iterator<Item = Cell> {
    let largest = at.abs().max_element();
    let reach = 2.0 * tolerance(at);
    (exponent_of(largest - reach)..=exponent_of(largest + reach)).flat_map(move |exponent| {
        let along = at.to_array().map(|coordinate| {
            let low = place_of(f64::from(coordinate) - f64::from(reach), exponent);
            low..=place_of(f64::from(coordinate) + f64::from(reach), exponent)
        });
        let [across, up, deep] = along;
        across.flat_map(move |x| {
            let deep = deep.clone();
            up.clone()
                .flat_map(move |y| deep.clone().map(move |z| Cell { exponent, place: [x, y, z] }))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
