//! Topologies: the triangles, lines and points that a list of vertices means (glTF 2.0, 3.7.2.1).
//! Incomplete ones at the end are left out, and so are triangles that name a vertex twice.

use gltf::mesh::Mode;

/// What a list of vertices means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Elements {
    Triangles(Vec<[u32; 3]>),
    Lines(Vec<[u32; 2]>),
    Points(Vec<u32>),
}

impl Elements {
    pub(super) fn of(mode: Mode, list: &[u32]) -> Self {
        match mode {
            Mode::Points => Self::Points(list.to_vec()),
            Mode::Lines => Self::Lines(list.as_chunks().0.to_vec()),
            Mode::LineStrip => Self::Lines(strip(list).collect()),
            Mode::LineLoop => Self::Lines(strip(list).chain(closing(list)).collect()),
            Mode::Triangles => Self::Triangles(proper(list.as_chunks().0.iter().copied())),
            Mode::TriangleStrip => {
                let windows = list.array_windows().enumerate();
                Self::Triangles(proper(
                    windows.map(
                        |(place, &[a, b, c])| {
                            if place % 2 == 0 { [a, b, c] } else { [a, c, b] }
                        },
                    ),
                ))
            }
            Mode::TriangleFan => {
                let hub = list.first().copied().unwrap_or_default();
                let rim = list.get(1..).unwrap_or_default().array_windows();
                Self::Triangles(proper(rim.map(|&[a, b]| [a, b, hub])))
            }
        }
    }

    /// Returns whether vertices at the end of a list of so many make no whole element.
    pub(super) fn leaves_rest(mode: Mode, count: usize) -> bool {
        match mode {
            Mode::Points => false,
            Mode::Lines => !count.is_multiple_of(2),
            Mode::LineStrip | Mode::LineLoop => count < 2,
            Mode::Triangles => !count.is_multiple_of(3),
            Mode::TriangleStrip | Mode::TriangleFan => count < 3,
        }
    }

    /// All vertices that are named.
    pub(super) fn vertices(&self) -> &[u32] {
        match self {
            Self::Triangles(triangles) => triangles.as_flattened(),
            Self::Lines(lines) => lines.as_flattened(),
            Self::Points(points) => points,
        }
    }

    /// Names all vertices anew.
    pub(super) fn rename(&mut self, new: impl Fn(u32) -> u32) {
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
        let of = |mode| Elements::of(mode, &list);
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
        let stitched = Elements::of(Mode::TriangleStrip, &[0, 1, 2, 3, 3, 4, 4, 5, 6]);
        assert_eq!(stitched, Elements::Triangles(vec![[0, 1, 2], [1, 3, 2], [4, 5, 6]]));
    }

    #[test]
    fn lists_that_are_too_short_mean_nothing() {
        for mode in [Mode::Lines, Mode::LineStrip, Mode::LineLoop] {
            assert_eq!(Elements::of(mode, &[7]), Elements::Lines(vec![]));
        }
        for mode in [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan] {
            for list in [&[][..], &[7], &[7, 8]] {
                assert_eq!(Elements::of(mode, list), Elements::Triangles(vec![]));
            }
        }
    }
}
