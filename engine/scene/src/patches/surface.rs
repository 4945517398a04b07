//! Patches, and the edges that they share.

use std::collections::HashMap;

use cull::Aabb;
use glam::Vec3;

/// The most patches of a surface: at the highest level, their vertices still fit 32-bit indices.
pub const MAX_PATCHES: usize = 1 << 16;

/// The largest magnitude of coordinates, in metres: differences of them must stay finite.
const FARTHEST_M: f32 = 1e15;

/// The control points of each side of a patch, in this order: v = 0, u = 1, v = 1, u = 0.
const SIDES: [[usize; 4]; 4] = [[0, 1, 2, 3], [3, 7, 11, 15], [12, 13, 14, 15], [0, 4, 8, 12]];

/// A bicubic Bezier patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patch {
    /// The indices of its control points: four rows from v = 0 to v = 1, each from u = 0 to u = 1.
    /// Seen from outside, u points to the right and v upwards.
    pub control_points: [u32; 16],
}

/// A side of a patch: a cubic Bezier curve. Its direction is canonical, so that the patches on both
/// sides of it have the same edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PatchEdge {
    /// The indices of its control points.
    pub control_points: [u32; 4],
}

/// The reason why patches are not a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PatchError {
    /// A surface without patches.
    #[error("a surface needs at least one patch")]
    NoPatches,
    /// More than [`MAX_PATCHES`].
    #[error("{patches} patches are more than the {MAX_PATCHES} that a surface can have: divide it")]
    TooManyPatches {
        /// The number of patches.
        patches: usize,
    },
    /// A control point that is not finite, or farther away than 1e15 m.
    #[error("control point {point} is not finite, or farther away than 1e15 m")]
    NotFinite {
        /// The index of the control point.
        point: usize,
    },
    /// An index beyond the control points.
    #[error("patch {patch} names control point {point}, and there are {points}")]
    NoSuchPoint {
        /// The index of the patch.
        patch: usize,
        /// The index of the control point that is missing.
        point: u32,
        /// The number of control points.
        points: usize,
    },
}

/// A surface of bicubic Bezier patches over shared control points.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchSurface {
    control_points: Vec<Vec3>,
    patches: Vec<Patch>,
    edges: Vec<PatchEdge>,
    /// The index of the edge of each side, for each patch.
    sides: Vec<[u32; 4]>,
    bounds: Aabb,
}

impl PatchSurface {
    /// Returns the surface of these patches. The control points are in metres, in the space of the
    /// mesh that the surface becomes. Control points at equal places count as one, so patches that
    /// meet there share their edge.
    ///
    /// # Errors
    /// No patch, or more than [`MAX_PATCHES`]; a control point that is not finite or too far away;
    /// an index beyond the control points.
    pub fn new(mut control_points: Vec<Vec3>, mut patches: Vec<Patch>) -> Result<Self, PatchError> {
        if patches.is_empty() {
            return Err(PatchError::NoPatches);
        }
        if patches.len() > MAX_PATCHES {
            return Err(PatchError::TooManyPatches { patches: patches.len() });
        }
        let is_near = |point: &Vec3| point.abs().cmple(Vec3::splat(FARTHEST_M)).all();
        if let Some(point) = control_points.iter().position(|point| !is_near(point)) {
            return Err(PatchError::NotFinite { point });
        }
        let points = control_points.len();
        for (patch, of) in patches.iter().enumerate() {
            if let Some(&point) = of.control_points.iter().find(|&&point| point as usize >= points)
            {
                return Err(PatchError::NoSuchPoint { patch, point, points });
            }
        }
        // Negative zero becomes zero, so that equal places have equal bits.
        control_points.iter_mut().for_each(|point| *point += Vec3::ZERO);
        let first_at = first_of_equals(&control_points);
        for point in patches.iter_mut().flat_map(|patch| &mut patch.control_points) {
            *point = first_at[*point as usize];
        }
        let mut edges = Vec::new();
        let mut known = HashMap::new();
        let mut sides = Vec::with_capacity(patches.len());
        for patch in &patches {
            sides.push(SIDES.map(|side| {
                let edge = PatchEdge::canonical(side.map(|place| patch.control_points[place]));
                *known.entry(edge).or_insert_with(|| {
                    edges.push(edge);
                    edges.len() as u32 - 1
                })
            }));
        }
        let used = patches.iter().flat_map(|patch| patch.control_points);
        let bounds = used.fold(Aabb::EMPTY, |bounds, point| {
            let point = control_points[point as usize];
            bounds.union(&Aabb::new(point, point))
        });
        Ok(Self { control_points, patches, edges, sides, bounds })
    }

    /// Returns the control points, in metres.
    pub fn control_points(&self) -> &[Vec3] {
        &self.control_points
    }

    /// Returns the patches. If control points lie at equal places, patches name the first of them.
    pub fn patches(&self) -> &[Patch] {
        &self.patches
    }

    /// Returns the edges, each listed once, in the order of the patches.
    pub fn edges(&self) -> &[PatchEdge] {
        &self.edges
    }

    /// Returns the edges of the sides v = 0, u = 1, v = 1 and u = 0 of each patch, as indices into
    /// [`PatchSurface::edges`].
    pub fn sides(&self) -> &[[u32; 4]] {
        &self.sides
    }

    /// Returns the box around the control points of the patches, in metres. It holds each point of
    /// the surface, at each level, rounding included.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Returns the places of an edge's control points, in its canonical direction.
    pub(super) fn places_of(&self, edge: PatchEdge) -> [Vec3; 4] {
        edge.control_points.map(|point| self.control_points[point as usize])
    }

    /// Returns true if the side of a patch runs against the canonical direction of its edge. Sides
    /// run with u and v.
    pub(super) fn is_reversed(&self, patch: usize, side: usize) -> bool {
        let of_patch = SIDES[side].map(|place| self.patches[patch].control_points[place]);
        PatchEdge::canonical(of_patch).control_points != of_patch
    }
}

impl PatchEdge {
    /// Returns the edge through these control points, in its canonical direction.
    fn canonical(control_points: [u32; 4]) -> Self {
        let mut reversed = control_points;
        reversed.reverse();
        Self { control_points: control_points.min(reversed) }
    }

    /// Returns true if the edge is one point, as at the pole of a ball.
    pub fn is_collapsed(&self) -> bool {
        let [first, rest @ ..] = self.control_points;
        rest.iter().all(|point| *point == first)
    }
}

/// Returns the index of the first point at the place of each point.
fn first_of_equals(points: &[Vec3]) -> Vec<u32> {
    let mut firsts = HashMap::new();
    let numbered = (0..).zip(points);
    let first = numbered
        .map(|(index, point)| *firsts.entry(point.to_array().map(f32::to_bits)).or_insert(index));
    first.collect()
}
