//! Surfaces that tessellation shaders cut into triangles: the shader's input, and the mesh of its
//! output.

use std::collections::HashMap;

use super::grid::EvaluatedPoint;
use super::levels::TessellationLevels;
use super::surface::PatchSurface;
use super::welder::Welder;
use crate::Mesh;

/// The sides of a patch, as tessellation shaders read them, in the order of
/// [`PatchSurface::sides`]. Each is twice the level of the side, plus 1 if the side runs against
/// the canonical direction of its edge.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PatchSides {
    /// A word per side.
    pub words: [u32; 4],
}

impl PatchSides {
    /// Returns the sides of each patch of a surface at these levels.
    pub fn of_surface(
        surface: &PatchSurface,
        levels: &TessellationLevels,
    ) -> impl ExactSizeIterator<Item = Self> {
        surface.sides().iter().enumerate().map(|(patch, edges)| {
            let word = |side: usize| {
                2 * levels.of_edge(edges[side]) + u32::from(surface.is_reversed(patch, side))
            };
            Self { words: [word(0), word(1), word(2), word(3)] }
        })
    }
}

/// Returns the number of triangles that tessellation shaders generate for a surface at these
/// levels, including triangles without area at poles. It depends only on the levels: the strip
/// along a side has a triangle for each piece of the edge and for each piece of the inner row.
pub fn captured_triangle_count(surface: &PatchSurface, levels: &TessellationLevels) -> u64 {
    let of_patch = |(patch, sides): (usize, &[u32; 4])| {
        let inside = u64::from(levels.of_patch(surface, patch));
        if inside == 1 {
            return 2;
        }
        let inner_pieces = inside - 2;
        let on_sides: u64 = sides.iter().map(|edge| u64::from(levels.of_edge(*edge))).sum();
        2 * inner_pieces.pow(2) + 4 * inner_pieces + on_sides
    };
    surface.sides().iter().enumerate().map(of_patch).sum()
}

/// Returns the mesh of triangles, given as three points each. Points at equal places, to the bit,
/// become one vertex if their normals are nearly equal. Triangles with an edge of no length, as at
/// poles, are left out. Points that were not captured, which have a normal of 0, are left out, too.
pub fn captured_mesh(points: &[EvaluatedPoint], name: &str, colour: u32) -> Mesh {
    let mut welder = Welder::new(colour);
    let mut newest: HashMap<[u32; 3], Option<u32>> = HashMap::new();
    let mut indices = Vec::with_capacity(points.len());
    for corners in points.as_chunks::<3>().0 {
        let [a, b, c] = corners.map(|corner| corner.position.map(f32::to_bits));
        let has_normals = corners.iter().all(|corner| corner.normal != 0);
        if has_normals && a != b && b != c && c != a {
            for corner in corners {
                let newest = newest.entry(corner.position.map(f32::to_bits)).or_default();
                indices.push(welder.vertex_of(corner, newest));
            }
        }
    }
    welder.into_mesh(indices, name)
}
