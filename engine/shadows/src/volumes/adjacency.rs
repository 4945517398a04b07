//! The neighbours of triangles: pairs of edges that run in opposite directions.

/// An edge of a triangle, listed by its ends.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    /// The ends, the smaller number first.
    ends: [u32; 2],
    /// The triangle.
    triangle: u32,
    /// The index of the edge in its triangle, 0 to 2.
    place: u8,
    /// True if the triangle runs from the smaller to the greater end.
    runs_up: bool,
}

/// The neighbours of triangles.
pub(super) struct Neighbours {
    /// The neighbour at each edge of each triangle: its triangle, and its index of the edge.
    pub(super) of: Vec<[Option<(u32, u8)>; 3]>,
    /// True if each edge has exactly two triangles, which run along it in opposite directions.
    pub(super) is_manifold: bool,
}

/// Finds the neighbours of triangles.
///
/// Where more than two triangles meet at an edge, they are paired as far as their directions are
/// opposite. Any such pairing closes the volumes, since the sides of two triangles with the same
/// direction cancel. An edge that is left over has no neighbour.
pub(super) fn neighbours(triangles: &[[u32; 3]]) -> Neighbours {
    let edges_of = |(triangle, &[a, b, c]): (u32, &[u32; 3])| {
        [(0, a, b), (1, b, c), (2, c, a)].map(|(place, from, to)| Edge {
            ends: [from.min(to), from.max(to)],
            triangle,
            place,
            runs_up: from < to,
        })
    };
    let mut edges: Vec<Edge> = (0..).zip(triangles).flat_map(edges_of).collect();
    edges.sort_unstable();
    let mut found = Neighbours { of: vec![[None; 3]; triangles.len()], is_manifold: true };
    for group in edges.chunk_by(|a, b| a.ends == b.ends) {
        let up = group.iter().filter(|edge| edge.runs_up);
        let down = group.iter().filter(|edge| !edge.runs_up);
        found.is_manifold &= group.len() == 2 && up.clone().count() == 1;
        for (up, down) in up.zip(down) {
            found.join(up, down);
            found.join(down, up);
        }
    }
    found
}

impl Neighbours {
    fn join(&mut self, from: &Edge, to: &Edge) {
        let edges = self.of.get_mut(from.triangle as usize);
        if let Some(edge) = edges.and_then(|edges| edges.get_mut(usize::from(from.place))) {
            *edge = Some((to.triangle, to.place));
        }
    }

    /// Returns the number of each triangle's connected part.
    pub(super) fn parts(&self) -> Vec<u32> {
        let mut parts = vec![u32::MAX; self.of.len()];
        let mut open = Vec::new();
        let mut next = 0;
        for start in 0..self.of.len() {
            if parts.get(start) != Some(&u32::MAX) {
                continue;
            }
            open.push(start);
            while let Some(triangle) = open.pop() {
                match parts.get_mut(triangle) {
                    Some(part) if *part == u32::MAX => *part = next,
                    _ => continue,
                }
                let beside = self.of.get(triangle).into_iter().flatten().flatten();
                open.extend(beside.map(|&(beside, _)| beside as usize));
            }
            next += 1;
        }
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_of_one_winding_are_neighbours() {
        let found = neighbours(&[[0, 1, 2], [2, 1, 3]]);
        assert_eq!(found.of, [[None, Some((1, 0)), None], [Some((0, 1)), None, None]]);
        assert!(!found.is_manifold, "its edges are open");
        assert_eq!(found.parts(), [0, 0]);
    }

    #[test]
    fn triangles_of_different_winding_are_none() {
        let found = neighbours(&[[0, 1, 2], [1, 2, 3]]);
        assert_eq!(found.of, [[None; 3]; 2]);
        assert_eq!(found.parts(), [0, 1]);
    }

    #[test]
    fn of_three_triangles_at_an_edge_two_are_paired() {
        let found = neighbours(&[[0, 1, 2], [0, 1, 3], [1, 0, 4]]);
        assert_eq!(found.of[0][0], Some((2, 0)));
        assert_eq!(found.of[1][0], None);
        assert_eq!(found.of[2][0], Some((0, 0)));
    }

    #[test]
    fn a_tetrahedron_is_closed() {
        let closed = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        assert!(neighbours(&closed).is_manifold);
        let mut turned = closed;
        turned[2] = [2, 1, 3];
        assert!(!neighbours(&turned).is_manifold);
    }
}
