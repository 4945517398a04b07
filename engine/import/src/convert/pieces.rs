//! Cuts large meshes into pieces that lie side by side, so that each can be culled individually.

use glam::Vec3;
use scene::spatial_pieces;

use super::geometry::Geometry;

/// Cuts geometry into pieces of at most `most` triangles. A set of triangles is halved along the
/// longest side of the box around their middles until all pieces are small enough. Triangles keep
/// their order within a piece, and backs are in the piece of their fronts. Small geometry is
/// returned whole.
pub(super) fn cut(geometry: Geometry, most: usize) -> Vec<Geometry> {
    let most = most.max(1);
    if geometry.triangles.len() <= most {
        return vec![geometry];
    }
    let sides: usize = if geometry.has_backs { 2 } else { 1 };
    let count = geometry.triangles.len() / sides;
    let most = (most / sides).max(1);
    let first_sides = geometry.triangles.iter().take(count);
    let middles: Vec<Vec3> = first_sides.map(|first_side| middle(&geometry, first_side)).collect();
    // The index of a vertex in the current piece; each piece resets it.
    let mut names = vec![u32::MAX; geometry.positions.len()];
    let with_backs = |part: Vec<u32>| {
        let of_side = |side| part.iter().map(move |triangle| triangle + (side * count) as u32);
        let part: Vec<u32> = (0..sides).flat_map(of_side).collect();
        piece(&geometry, &part, &mut names)
    };
    spatial_pieces(&middles, most).into_iter().map(with_backs).collect()
}

fn middle(geometry: &Geometry, triangle: &[u32; 3]) -> Vec3 {
    let at = |vertex: u32| geometry.positions.get(vertex as usize).copied().unwrap_or_default();
    // Thirds first: the sum of three large numbers may overflow.
    triangle.iter().map(|&vertex| at(vertex) / 3.0).sum()
}

pub(super) fn longest_side(points: impl Iterator<Item = Vec3>) -> usize {
    let (low, high) = points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), point| {
        (low.min(point), high.max(point))
    });
    (high * 0.5 - low * 0.5).max_position()
}

/// Returns the triangles with these indices, and their vertices. `names` has an element per vertex,
/// all `u32::MAX` before and after.
pub(super) fn piece(geometry: &Geometry, part: &[u32], names: &mut [u32]) -> Geometry {
    let mut picks = Vec::new();
    let mut name = |vertex: u32| match names.get_mut(vertex as usize) {
        Some(name) => {
            if *name == u32::MAX {
                *name = picks.len() as u32;
                picks.push(vertex);
            }
            *name
        }
        None => 0,
    };
    let own = part.iter().filter_map(|&triangle| geometry.triangles.get(triangle as usize));
    let triangles = own.map(|triangle| triangle.map(&mut name)).collect();
    for &vertex in &picks {
        if let Some(name) = names.get_mut(vertex as usize) {
            *name = u32::MAX;
        }
    }
    Geometry { triangles, ..geometry.gather(&picks) }
}

#[cfg(test)]
mod tests {
    use super::super::sidedness::{Backs, with_backs};
    use super::*;

    /// Returns a strip of squares along x, each of two triangles.
    fn strip(squares: u32) -> Geometry {
        let corner = |place: u32| Vec3::new((place / 2) as f32, (place % 2) as f32, 0.0);
        let square = |place: u32| {
            let start = place * 2;
            [[start, start + 2, start + 1], [start + 1, start + 2, start + 3]]
        };
        Geometry {
            positions: (0..squares * 2 + 2).map(corner).collect(),
            triangles: (0..squares).flat_map(square).collect(),
            ..Geometry::default()
        }
    }

    fn corners(geometry: &Geometry) -> Vec<[[u32; 3]; 3]> {
        let at = |vertex: u32| geometry.positions[vertex as usize].to_array().map(f32::to_bits);
        geometry.triangles.iter().map(|triangle| triangle.map(at)).collect()
    }

    #[test]
    fn pieces_have_every_triangle_once_and_lie_side_by_side() {
        let whole = strip(1000);
        let pieces = cut(whole.clone(), 128);
        assert_eq!(pieces.len(), 16);
        let mut all: Vec<_> = pieces.iter().flat_map(corners).collect();
        let mut expected = corners(&whole);
        all.sort_unstable();
        expected.sort_unstable();
        assert_eq!(all, expected);
        let mut end = 0.0;
        for piece in &pieces {
            assert!(piece.triangles.len() <= 128);
            let xs = piece.positions.iter().map(|at| at.x);
            let (low, high) =
                xs.fold((f32::MAX, f32::MIN), |(low, high), x| (low.min(x), high.max(x)));
            assert!((low - end).abs() <= 1.0, "{low} after {end}");
            end = high;
        }
    }

    #[test]
    fn backs_are_in_the_piece_of_their_fronts() {
        // The sum of three numbers depends on their order, so the middles of both sides may differ.
        let mut both = strip(333);
        for (number, at) in (0..).zip(&mut both.positions) {
            *at = Vec3::new(at.x * 0.37, (number * 7 % 13) as f32 / 13.0, 1e-3 / (at.x + 0.1));
        }
        with_backs(&mut both, Backs::Last);
        let pieces = cut(both, 60);
        assert_eq!(pieces.iter().map(|piece| piece.triangles.len()).sum::<usize>(), 4 * 333);
        for piece in &pieces {
            let found = corners(piece);
            let (fronts, backs) = found.split_at(found.len() / 2);
            assert!(piece.has_backs && found.len() <= 60);
            assert!(fronts.iter().map(|[a, b, c]| [*a, *c, *b]).eq(backs.iter().copied()));
        }
    }

    #[test]
    fn what_is_all_in_one_place_is_cut_too_and_what_is_small_is_not() {
        let heap = Geometry { triangles: [[0, 1, 2]].repeat(100), ..strip(1) };
        let pieces = cut(heap, 30);
        assert_eq!(pieces.iter().map(|piece| piece.triangles.len()).sum::<usize>(), 100);
        assert!(
            pieces.iter().all(|piece| piece.triangles.len() <= 30 && piece.positions.len() == 3)
        );
        assert_eq!(cut(strip(3), 6), [strip(3)]);
    }
}
