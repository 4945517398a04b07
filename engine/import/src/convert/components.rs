//! Connected components of transparent meshes, which can be sorted individually.

use std::collections::HashMap;

use cull::Aabb;
use glam::Vec3;
use scene::{ENCLOSING, signed_volume};

use super::geometry::Geometry;
use super::pieces;

/// Splits geometry into at most `most` parts: its connected components (by the positions of
/// vertices), or groups of neighbouring components if there are more. Triangles keep their order
/// within a part. Backs stay with their fronts.
pub(super) fn apart(geometry: Geometry, most: usize) -> Vec<Geometry> {
    let parts = components(&geometry);
    if parts.len() < 2 || most < 2 {
        return vec![geometry];
    }
    let mut parts: Vec<(Vec3, Vec<u32>)> =
        parts.into_iter().map(|part| (middle(&geometry, &part), part)).collect();
    let mut names = vec![u32::MAX; geometry.positions.len()];
    let mut pieces = Vec::new();
    let mut pending = vec![(parts.as_mut_slice(), most)];
    while let Some((group, most)) = pending.pop() {
        if group.len() > 1 && most > 1 {
            let axis = pieces::longest_side(group.iter().map(|(middle, _)| *middle));
            let half = group.len() / 2;
            group.select_nth_unstable_by(half, |(a, first), (b, second)| {
                a[axis].total_cmp(&b[axis]).then(first.cmp(second))
            });
            let (low, high) = group.split_at_mut(half);
            // So that a large group is split further even if a small one cannot use its share.
            let for_low = (most / 2).min(low.len());
            pending.push((high, most - for_low));
            pending.push((low, for_low));
            continue;
        }
        let mut triangles: Vec<u32> =
            group.iter().flat_map(|(_, part)| part.iter().copied()).collect();
        triangles.sort_unstable();
        pieces.push(pieces::piece(&geometry, &triangles, &mut names));
    }
    pieces
}

/// Splits a closed part whose first half of triangles are the backs of the second half into both
/// halves: its inside is seen before the backs and behind the fronts. Other parts stay whole.
pub(super) fn sides(part: Geometry) -> Vec<Geometry> {
    let (backs, fronts) = part.triangles.split_at(part.triangles.len() / 2);
    let places = |corners: &[u32; 3]| {
        corners.map(|corner| part.positions.get(corner as usize).copied().unwrap_or_default())
    };
    let is_back = |(back, front): (&[u32; 3], &[u32; 3])| {
        let [a, b, c] = places(back);
        let [d, e, f] = places(front);
        [a, c, b] == [d, e, f]
    };
    let are_backs = backs.len() == fronts.len() && backs.iter().zip(fronts).all(is_back);
    let bounds = part.positions.iter().fold(Aabb::EMPTY, |all, at| all.union(&Aabb::new(*at, *at)));
    if !are_backs || signed_volume(&bounds, fronts.iter().map(places)).abs() < ENCLOSING {
        return vec![part];
    }
    let mut names = vec![u32::MAX; part.positions.len()];
    let half = backs.len() as u32;
    let all = part.triangles.len() as u32;
    let numbers = |range: std::ops::Range<u32>| range.collect::<Vec<u32>>();
    [numbers(0..half), numbers(half..all)]
        .map(|side| Geometry { has_backs: false, ..pieces::piece(&part, &side, &mut names) })
        .into()
}

/// Returns the connected components as lists of triangles, ordered by their first triangle.
fn components(geometry: &Geometry) -> Vec<Vec<u32>> {
    // Vertices at one place count as one, whatever their other attributes.
    let mut places: HashMap<[u32; 3], u32> = HashMap::new();
    let count = geometry.positions.len() as u32;
    let mut above: Vec<u32> = (0..count).collect();
    for (vertex, position) in (0..count).zip(&geometry.positions) {
        // Adding 0 merges both zeros.
        let bits = position.to_array().map(|number| (number + 0.0).to_bits());
        let first = *places.entry(bits).or_insert(vertex);
        if let Some(above) = above.get_mut(vertex as usize) {
            *above = first;
        }
    }
    for &[a, b, c] in &geometry.triangles {
        join(&mut above, a, b);
        join(&mut above, b, c);
    }
    let mut numbers: HashMap<u32, usize> = HashMap::new();
    let mut parts: Vec<Vec<u32>> = Vec::new();
    for (number, [corner, ..]) in (0..).zip(&geometry.triangles) {
        let part = *numbers.entry(root(&mut above, *corner)).or_insert(parts.len());
        if part == parts.len() {
            parts.push(Vec::new());
        }
        if let Some(part) = parts.get_mut(part) {
            part.push(number);
        }
    }
    parts
}

/// Returns the vertex that represents the component of a vertex.
fn root(above: &mut [u32], mut vertex: u32) -> u32 {
    while let Some(&next) = above.get(vertex as usize)
        && next != vertex
    {
        let far = above.get(next as usize).copied().unwrap_or(next);
        if let Some(above) = above.get_mut(vertex as usize) {
            *above = far;
        }
        vertex = next;
    }
    vertex
}

fn join(above: &mut [u32], a: u32, b: u32) {
    let a = root(above, a);
    let b = root(above, b);
    if let Some(above) = above.get_mut(a.max(b) as usize) {
        *above = a.min(b);
    }
}

fn middle(geometry: &Geometry, part: &[u32]) -> Vec3 {
    let own = part.iter().filter_map(|&triangle| geometry.triangles.get(triangle as usize));
    let places = own.flatten().filter_map(|&vertex| geometry.positions.get(vertex as usize));
    let (low, high) = places.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &place| {
        (low.min(place), high.max(place))
    });
    low * 0.5 + high * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns squares along x with gaps between them. Their two triangles share no vertex.
    fn cards(count: u32) -> Geometry {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
        let card = |number: u32| {
            corners.map(|[x, y]| Vec3::new(x + 2.0 * number as f32, y, -0.0 * number as f32))
        };
        Geometry {
            positions: (0..count).flat_map(card).collect(),
            // All first halves precede all second halves.
            triangles: [0, 3]
                .into_iter()
                .flat_map(|half| {
                    (0..count).map(move |card| [0, 1, 2].map(|at| card * 6 + half + at))
                })
                .collect(),
            ..Geometry::default()
        }
    }

    #[test]
    fn what_hangs_together_stays_so_and_what_does_not_comes_apart() {
        let parts = apart(cards(5), 64);
        assert_eq!(parts.len(), 5);
        for (number, part) in (0..).zip(&parts) {
            assert_eq!((part.triangles.len(), part.positions.len()), (2, 6));
            assert_eq!(part.positions[0].x, 2.0 * number as f32, "they lie side by side");
        }
        let whole = cards(1);
        assert_eq!(apart(whole.clone(), 64), [whole]);
    }

    #[test]
    fn of_too_many_those_that_are_near_stay_together() {
        for (cards_there, most) in [(1000, 7), (9, 8), (3, 2)] {
            let parts = apart(cards(cards_there), most);
            assert_eq!(parts.len(), most);
            let triangles: usize = parts.iter().map(|part| part.triangles.len()).sum();
            assert_eq!(triangles, 2 * cards_there as usize);
            let mut end = -1.0;
            for part in &parts {
                let xs = || part.positions.iter().map(|at| at.x);
                assert!(xs().all(|x| x > end), "they overlap");
                end = xs().fold(end, f32::max);
            }
        }
        let whole = cards(3);
        assert_eq!(apart(whole.clone(), 1), [whole]);
    }

    #[test]
    fn backs_stay_before_their_fronts() {
        let mut both = cards(2);
        super::super::sidedness::with_backs(&mut both, super::super::sidedness::Backs::First);
        let parts = apart(both, 64);
        assert_eq!(parts.len(), 2);
        for part in parts {
            let normals: Vec<f32> = part
                .triangles
                .iter()
                .map(|corners| {
                    let [a, b, c] = corners.map(|at| part.positions[at as usize]);
                    (b - a).cross(c - a).z
                })
                .collect();
            assert_eq!(normals, [-1.0, -1.0, 1.0, 1.0]);
        }
    }

    #[test]
    fn a_glass_is_taken_apart_into_its_sides_and_a_card_is_not() {
        let with_backs = |mut geometry: Geometry| {
            super::super::sidedness::with_backs(
                &mut geometry,
                super::super::sidedness::Backs::First,
            );
            geometry
        };
        assert_eq!(sides(with_backs(cards(1))).len(), 1);
        let mut glass = Geometry::default();
        for [x, y, z] in [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0], [1.0, -1.0, -1.0]]
        {
            glass.positions.push(Vec3::new(x, y, z));
        }
        glass.triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
        assert_eq!(sides(glass.clone()).len(), 1, "seen from one side");
        let found = sides(with_backs(glass.clone()));
        assert_eq!(found.iter().map(|side| side.triangles.len()).collect::<Vec<_>>(), [4, 4]);
        assert_eq!(found[1].triangles, glass.triangles, "the fronts come last");
        assert_eq!(found[0].positions.len(), 4);
    }
}
