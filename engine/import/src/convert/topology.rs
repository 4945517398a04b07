//! Topologies: the triangles, lines and points of a list of vertices (glTF 2.0, 3.7.2.1).
//! Incomplete elements at the end are left out, and so are triangles with a repeated vertex.

use gltf::mesh::Mode;

/// The cost of sorting a vertex relative to marking it: a primitive that uses a smaller part of its
/// vertices sorts them.
const FEW: usize = 16;

/// The elements of a list of vertices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Elements {
    Triangles(Vec<[u32; 3]>),
    Lines(Vec<[u32; 2]>),
    Points(Vec<u32>),
}

impl Elements {
    /// Returns the elements of a list. The value `restart`, if there is one, begins a new strip,
    /// loop or fan.
    pub(super) fn of(mode: Mode, list: &[u32], restart: Option<u32>) -> Self {
        let strips = strips(list, restart);
        match mode {
            Mode::Points => Self::Points(strips.flatten().copied().collect()),
            Mode::Lines => {
                Self::Lines(strips.flat_map(|list| list.as_chunks().0).copied().collect())
            }
            Mode::LineStrip => Self::Lines(strips.flat_map(strip).collect()),
            Mode::LineLoop => {
                Self::Lines(strips.flat_map(|list| strip(list).chain(closing(list))).collect())
            }
            Mode::Triangles => {
                Self::Triangles(proper(strips.flat_map(|list| list.as_chunks().0).copied()))
            }
            Mode::TriangleStrip => Self::Triangles(proper(strips.flat_map(|list| {
                let windows = list.array_windows().enumerate();
                windows.map(
                    |(place, &[a, b, c])| {
                        if place % 2 == 0 { [a, b, c] } else { [a, c, b] }
                    },
                )
            }))),
            Mode::TriangleFan => Self::Triangles(proper(strips.flat_map(|list| {
                let hub = list.first().copied().unwrap_or_default();
                let rim = list.get(1..).unwrap_or_default().array_windows();
                rim.map(move |&[a, b]| [a, b, hub])
            }))),
        }
    }

    /// Returns true if the last vertices of a list, or the last ones before a `restart`, are an
    /// incomplete element.
    pub(super) fn leave_rest(mode: Mode, list: &[u32], restart: Option<u32>) -> bool {
        let mut strips = strips(list, restart).filter(|list| !list.is_empty());
        strips.any(|list| Self::leaves_rest(mode, list.len()))
    }

    /// Returns true if the last vertices of a list of `count` are an incomplete element.
    fn leaves_rest(mode: Mode, count: usize) -> bool {
        match mode {
            Mode::Points => false,
            Mode::Lines => !count.is_multiple_of(2),
            Mode::LineStrip | Mode::LineLoop => count < 2,
            Mode::Triangles => !count.is_multiple_of(3),
            Mode::TriangleStrip | Mode::TriangleFan => count < 3,
        }
    }

    pub(super) fn vertices(&self) -> &[u32] {
        match self {
            Self::Triangles(triangles) => triangles.as_flattened(),
            Self::Lines(lines) => lines.as_flattened(),
            Self::Points(points) => points,
        }
    }

    /// Renumbers the vertices so that only used ones remain, in order. Returns the used vertices,
    /// or `None` if all of `count` are used.
    ///
    /// # Errors
    /// A vertex that does not exist.
    pub(super) fn compact(&mut self, count: usize) -> Result<Option<Vec<u32>>, u32> {
        if let Some(&beyond) = self.vertices().iter().find(|&&vertex| vertex as usize >= count) {
            return Err(beyond);
        }
        // A few used vertices are sorted, so that the unused ones cost nothing.
        let is_few = self.vertices().len() < count / FEW;
        let picks = if is_few { sorted(self.vertices()) } else { marked(self.vertices(), count) };
        if picks.len() == count {
            return Ok(None);
        }
        if is_few {
            self.rename(|vertex| picks.binary_search(&vertex).map_or(0, |name| name as u32));
        } else {
            let mut names = vec![0; count];
            for (name, &vertex) in (0..).zip(&picks) {
                names[vertex as usize] = name;
            }
            self.rename(|vertex| names[vertex as usize]);
        }
        Ok(Some(picks))
    }

    /// Renumbers all vertices.
    fn rename(&mut self, new: impl Fn(u32) -> u32) {
        let all = match self {
            Self::Triangles(triangles) => triangles.as_flattened_mut(),
            Self::Lines(lines) => lines.as_flattened_mut(),
            Self::Points(points) => points,
        };
        for vertex in all {
            *vertex = new(*vertex);
        }
    }
}

/// Returns the vertices of a list in order without repetitions, by sorting.
fn sorted(list: &[u32]) -> Vec<u32> {
    let mut picks = list.to_vec();
    picks.sort_unstable();
    picks.dedup();
    picks
}

/// Returns the vertices of a list in order without repetitions, by marking those below `count`.
fn marked(list: &[u32], count: usize) -> Vec<u32> {
    let mut is_used = vec![false; count];
    for &vertex in list {
        is_used[vertex as usize] = true;
    }
    (0..).zip(is_used).filter_map(|(vertex, is_used)| is_used.then_some(vertex)).collect()
}

/// Returns the parts of a list between the values that begin a new strip.
fn strips(list: &[u32], restart: Option<u32>) -> impl Iterator<Item = &[u32]> {
    list.split(move |vertex| Some(*vertex) == restart)
}

fn strip(list: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    list.array_windows().copied()
}

fn closing(list: &[u32]) -> Option<[u32; 2]> {
    match list {
        [first, .., last] => Some([*last, *first]),
        _ => None,
    }
}

fn proper(triangles: impl Iterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mode_means_what_the_specification_says() {
        let list = [10, 11, 12, 13, 14];
        let of = |mode| Elements::of(mode, &list, None);
        assert_eq!(of(Mode::Points), Elements::Points(list.to_vec()));
        assert_eq!(of(Mode::Lines), Elements::Lines(vec![[10, 11], [12, 13]]));
        let strip = vec![[10, 11], [11, 12], [12, 13], [13, 14]];
        assert_eq!(of(Mode::LineStrip), Elements::Lines(strip.clone()));
        let mut closed = strip;
        closed.push([14, 10]);
        assert_eq!(of(Mode::LineLoop), Elements::Lines(closed));
        assert_eq!(of(Mode::Triangles), Elements::Triangles(vec![[10, 11, 12]]));
        let strip = vec![[10, 11, 12], [11, 13, 12], [12, 13, 14]];
        assert_eq!(of(Mode::TriangleStrip), Elements::Triangles(strip));
        let fan = vec![[11, 12, 10], [12, 13, 10], [13, 14, 10]];
        assert_eq!(of(Mode::TriangleFan), Elements::Triangles(fan));
    }

    #[test]
    fn strips_stitched_by_repeated_vertices_keep_their_winding() {
        let stitched = Elements::of(Mode::TriangleStrip, &[0, 1, 2, 3, 3, 4, 4, 5, 6], None);
        assert_eq!(stitched, Elements::Triangles(vec![[0, 1, 2], [1, 3, 2], [4, 5, 6]]));
    }

    #[test]
    fn a_restart_begins_anew_in_every_mode() {
        let list = [0, 1, 2, 3, 9, 4, 5, 6, 9, 9, 7];
        let of = |mode| Elements::of(mode, &list, Some(9));
        assert_eq!(of(Mode::Points), Elements::Points((0..8).collect()));
        assert_eq!(of(Mode::Lines), Elements::Lines(vec![[0, 1], [2, 3], [4, 5]]));
        let mut lines = vec![[0, 1], [1, 2], [2, 3], [4, 5], [5, 6]];
        assert_eq!(of(Mode::LineStrip), Elements::Lines(lines.clone()));
        lines.insert(3, [3, 0]);
        lines.push([6, 4]);
        assert_eq!(of(Mode::LineLoop), Elements::Lines(lines));
        assert_eq!(of(Mode::Triangles), Elements::Triangles(vec![[0, 1, 2], [4, 5, 6]]));
        let strip = vec![[0, 1, 2], [1, 3, 2], [4, 5, 6]];
        assert_eq!(of(Mode::TriangleStrip), Elements::Triangles(strip));
        let fan = vec![[1, 2, 0], [2, 3, 0], [5, 6, 4]];
        assert_eq!(of(Mode::TriangleFan), Elements::Triangles(fan));
        assert!(Elements::leave_rest(Mode::LineStrip, &list, Some(9)), "a strip of one");
        assert!(!Elements::leave_rest(Mode::LineStrip, &[0, 1, 9, 2, 3, 9], Some(9)));
    }

    #[test]
    fn lists_that_are_too_short_mean_nothing() {
        for mode in [Mode::Lines, Mode::LineStrip, Mode::LineLoop] {
            assert_eq!(Elements::of(mode, &[7], None), Elements::Lines(vec![]));
        }
        for mode in [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan] {
            for list in [&[][..], &[7], &[7, 8]] {
                assert_eq!(Elements::of(mode, list, None), Elements::Triangles(vec![]));
            }
        }
    }

    #[test]
    fn sorting_and_marking_find_the_same_vertices() {
        let mut random = 1_u32;
        for round in 1..200_u32 {
            let mut next = || {
                random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                random >> 8
            };
            let list: Vec<u32> = (0..next() % 90).map(|_| next() % (9 * round)).collect();
            let count = 9 * round as usize;
            let picks = sorted(&list);
            assert_eq!(picks, marked(&list, count), "{list:?}");
            let mut elements = Elements::Points(list.clone());
            match elements.compact(count) {
                Ok(Some(kept)) => assert_eq!(kept, picks),
                Ok(None) => assert_eq!(picks.len(), count),
                Err(vertex) => panic!("vertex {vertex} is there"),
            }
            let named = elements.vertices().iter().map(|&name| picks[name as usize]);
            assert_eq!(named.collect::<Vec<_>>(), list);
        }
        assert_eq!(Elements::Points(vec![3, 9, 8]).compact(8), Err(9));
    }
}
