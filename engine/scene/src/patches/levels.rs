//! Levels of detail of edges: the number of pieces that each edge is divided into.

use cull::CullView;
use glam::{Affine3A, Mat4, Vec3, Vec3A, vec2};

use super::surface::PatchSurface;

/// The highest level: the most pieces of an edge that every device with tessellation supports.
pub const MAX_LEVEL: u32 = 64;

/// The share of a level by which a length must pass its limits before the level changes.
const HYSTERESIS: f32 = 0.125;

/// The view that determines levels, together with the edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TessellationView {
    /// The transform from the surface's space to clip space.
    pub to_clip: Mat4,
    /// The size of the image, in pixels.
    pub size_px: [u32; 2],
    /// The wanted length of the pieces of an edge, in pixels.
    pub piece_px: f32,
}

impl TessellationView {
    /// Returns the view of an object with this transform.
    pub fn new(view: &CullView, transform: &Affine3A, piece_px: f32) -> Self {
        // Relative to the anchor, where large coordinates have cancelled out.
        let mut relative = *transform;
        relative.translation -= Vec3A::from(view.anchor);
        Self { to_clip: view.from_anchor * Mat4::from(relative), size_px: view.size, piece_px }
    }

    /// Returns the length of a polyline in the image, in pixels: infinite if it crosses the plane
    /// of the eye, 0 if it lies behind this plane.
    fn length_px(&self, points: [Vec3; 4]) -> f32 {
        let clip = points.map(|point| self.to_clip * point.extend(1.0));
        if clip.iter().all(|point| point.w <= 0.0) {
            return 0.0;
        }
        if clip.iter().any(|point| point.w <= 0.0) {
            return f32::INFINITY;
        }
        let half = vec2(self.size_px[0] as f32, self.size_px[1] as f32) * 0.5;
        let [a, b, c, d] = clip.map(|point| vec2(point.x / point.w, point.y / point.w) * half);
        a.distance(b) + b.distance(c) + c.distance(d)
    }
}

/// The level of each edge of a surface: a power of two of pieces, from 1 to [`MAX_LEVEL`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TessellationLevels {
    of_edges: Vec<u32>,
}

impl TessellationLevels {
    /// Returns the levels for a view. The level of an edge depends only on its own four control
    /// points and the view, so the patches on both sides agree. With levels `before`, an edge keeps
    /// its level until its length is an eighth beyond the limits of the level, so that levels do
    /// not flicker.
    pub fn new(surface: &PatchSurface, view: &TessellationView, before: Option<&Self>) -> Self {
        let level = |edge: usize| {
            let length_px = view.length_px(surface.places_of(surface.edges()[edge]));
            let before = before.and_then(|before| before.of_edges.get(edge)).copied();
            level_of(length_px / view.piece_px.max(f32::MIN_POSITIVE), before)
        };
        Self { of_edges: (0..surface.edges().len()).map(level).collect() }
    }

    /// Returns the same level for each edge, rounded up to a power of two and clamped to the
    /// limits.
    pub fn uniform(surface: &PatchSurface, level: u32) -> Self {
        Self::from_edges(surface, &vec![level; surface.edges().len()])
    }

    /// Returns these levels of the edges, rounded up to powers of two and clamped to the limits.
    /// Missing levels count as 1.
    pub fn from_edges(surface: &PatchSurface, levels: &[u32]) -> Self {
        let wanted = levels.iter().copied().chain(std::iter::repeat(1));
        let level = |wanted: u32| wanted.clamp(1, MAX_LEVEL).next_power_of_two();
        Self { of_edges: wanted.take(surface.edges().len()).map(level).collect() }
    }

    /// Returns the level of each edge, in the order of [`PatchSurface::edges`].
    pub fn of_edges(&self) -> &[u32] {
        &self.of_edges
    }

    /// Returns the level of an edge; 1 for an invalid index.
    pub fn of_edge(&self, edge: u32) -> u32 {
        self.of_edges.get(edge as usize).copied().unwrap_or(1)
    }

    /// Returns the level of the inside of a patch: the highest level of its edges.
    pub fn of_patch(&self, surface: &PatchSurface, patch: usize) -> u32 {
        let sides = surface.sides().get(patch).into_iter().flatten();
        sides.map(|edge| self.of_edge(*edge)).max().unwrap_or(1)
    }
}

/// Returns the least level of at least `pieces`, or `before` if that is still near enough.
fn level_of(pieces: f32, before: Option<u32>) -> u32 {
    if let Some(before) = before {
        let most = before as f32 * (1.0 + HYSTERESIS);
        let least = before as f32 * 0.5 * (1.0 - HYSTERESIS);
        if least < pieces && pieces <= most {
            return before;
        }
    }
    let mut level = 1;
    // NaN gets the highest level.
    while level < MAX_LEVEL && (pieces > level as f32 || pieces.is_nan()) {
        level *= 2;
    }
    level
}
