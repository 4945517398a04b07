//! Positions that were meant to be one, made one to the bit.
//!
//! Exporters compute the first and the last corner of a circle separately, so that `sin(0)` and
//! `sin(2 pi)` leave a gap of 1e-16. A seam of such corners is a border of the mesh, which then
//! encloses nothing.

use std::collections::HashMap;

use glam::Vec3;

/// The distance along an axis within which positions are one, as a share of the largest
/// coordinate: two steps of single precision there.
const WELD_SHARE: f32 = 2.0 * f32::EPSILON;

/// The width of the cells in which positions are looked for, in distances of welding.
const CELL: f64 = 4.0;

/// Moves each position to the first one that lies within the rounding of the largest coordinate.
pub(super) fn weld(positions: &mut [Vec3]) {
    let largest = positions.iter().fold(0.0_f32, |most, at| most.max(at.abs().max_element()));
    let tolerance = largest * WELD_SHARE;
    if !tolerance.is_normal() {
        return;
    }
    // The first position of each cell, and the next one in its cell of each position.
    let mut first_of_cell: HashMap<[i64; 3], u32> = HashMap::with_capacity(positions.len() / 4);
    let mut next_of: Vec<Option<u32>> = vec![None; positions.len()];
    let width = f64::from(tolerance) * CELL;
    let cell_at = |coordinate: f32, offset: f32| {
        ((f64::from(coordinate) + f64::from(offset)) / width).floor() as i64
    };
    for index in 0..positions.len() {
        let at = positions[index];
        let low = at.to_array().map(|coordinate| cell_at(coordinate, -tolerance));
        let high = at.to_array().map(|coordinate| cell_at(coordinate, tolerance));
        let near = cells_between(low, high).find_map(|cell| {
            let mut candidate = first_of_cell.get(&cell).copied();
            while let Some(number) = candidate {
                let place = positions[number as usize];
                if (place - at).abs().max_element() <= tolerance {
                    return Some(place);
                }
                candidate = next_of[number as usize];
            }
            None
        });
        match near {
            Some(place) => positions[index] = place,
            None => {
                let cell = at.to_array().map(|coordinate| cell_at(coordinate, 0.0));
                next_of[index] = first_of_cell.insert(cell, index as u32);
            }
        }
    }
}

/// Returns the cells from one to another, both included: at most two along an axis.
fn cells_between(low: [i64; 3], high: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    (low[0]..=high[0]).flat_map(move |x| {
        (low[1]..=high[1]).flat_map(move |y| (low[2]..=high[2]).map(move |z| [x, y, z]))
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
