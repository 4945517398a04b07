//! The view from above of a snapshot: the drawn objects, the hidden ones as boxes, and the frustum
//! (after the figure of a city walkthrough in GPU Gems 2, chapter 6).

use cull::{Aabb, Camera, CullView, Hierarchy, Projection, Rays};
use glam::{Vec2, Vec3};
use gpu::Frame;
use scene::pack_unorm;

use crate::debug::palette::{FRUSTUM, Swatch, level_colour};
use crate::debug::visibility_snapshot::VisibilitySnapshot;
use crate::error::Error;
use crate::passes::{OverlayIo, OverlayVertex};

/// The reach of the drawn frustum, as a share of the reach of the draws.
const FRUSTUM_REACH: f32 = 1.0;
pub(crate) const BACKGROUND: [f32; 3] = [0.02, 0.025, 0.035];

/// The label of the pass that draws a snapshot from another viewpoint.
pub(crate) const VIEW_FROM_ABOVE: &str = "view from above";

/// Returns the distance from the eye within which most of the snapshot's draws lie, without a few
/// far draws.
pub(crate) fn reach(hierarchy: &Hierarchy, snapshot: &VisibilitySnapshot) -> f32 {
    let distance = |range: &cull::LeafRange| {
        let object = hierarchy.leaf_objects().get(range.first.0 as usize)?;
        let bounds = hierarchy.bounds(hierarchy.node_of(*object)?);
        Some((bounds.centre() - snapshot.view.rays.origin).length())
    };
    let mut distances: Vec<f32> = snapshot.drawn.iter().filter_map(distance).collect();
    distances.sort_unstable_by(f32::total_cmp);
    let most = distances.len() * 9 / 10;
    distances.get(most).copied().unwrap_or(50.0).clamp(20.0, 2000.0)
}

/// Returns a camera behind and above the snapshot's camera, looking down at its scene.
pub(crate) fn above(snapshot: &VisibilitySnapshot, reach: f32) -> Camera {
    let reach = reach * FRUSTUM_REACH;
    let Rays { origin, forward, .. } = snapshot.view.rays;
    let flat = Vec3::new(forward.x, 0.0, forward.z);
    let along = flat.try_normalize().unwrap_or(Vec3::X);
    let eye = origin - along * reach * 0.55 + Vec3::Y * reach * 1.5;
    let target = origin + along * reach * 0.75;
    Camera {
        eye,
        forward: target - eye,
        up: Vec3::Y,
        projection: Projection::perspective(0.9),
        near: 0.5,
    }
}

/// The shapes drawn with the objects: the faces of boxes, and the edges of boxes and of the
/// frustum.
pub(crate) struct Sketch {
    pub(crate) triangles: Vec<OverlayVertex>,
    pub(crate) lines: Vec<OverlayVertex>,
    pub(crate) lines_through: Vec<OverlayVertex>,
}

/// A box of a sketch.
#[derive(Clone, Copy)]
pub(crate) struct SketchBox {
    pub(crate) bounds: Aabb,
    pub(crate) colour: Swatch,
}

impl Sketch {
    /// Creates the sketch of a snapshot seen from above.
    pub(crate) fn of(snapshot: &VisibilitySnapshot, reach: f32) -> Self {
        let mut triangles = Vec::new();
        let mut lines = Vec::new();
        for (bounds, level) in &snapshot.hidden {
            let colour = level_colour(*level).linear();
            let corners = corners_of(bounds);
            let face_colour = pack_unorm(colour.truncate().extend(0.10).to_array());
            for face in FACES {
                let quad = face.map(|corner| corners[corner]);
                for corner in [0, 1, 2, 0, 2, 3] {
                    triangles.push(vertex(quad[corner], face_colour));
                }
            }
            push_edges(&mut lines, &corners, pack_unorm(colour.to_array()));
        }
        let frustum = frustum_corners(&snapshot.view, reach);
        push_edges(&mut lines, &frustum, pack_unorm(FRUSTUM.linear().to_array()));
        Self { triangles, lines, lines_through: Vec::new() }
    }

    /// Creates a sketch of boxes seen from the eye, drawn over everything.
    pub(crate) fn through(boxes: impl Iterator<Item = SketchBox>) -> Self {
        let mut lines_through = Vec::new();
        for SketchBox { bounds, colour } in boxes {
            push_edges(
                &mut lines_through,
                &corners_of(&bounds),
                pack_unorm(colour.linear().to_array()),
            );
        }
        Self { triangles: Vec::new(), lines: Vec::new(), lines_through }
    }

    pub(crate) fn upload(&self, frame: &mut Frame<'_>) -> Result<OverlayIo, Error> {
        let mut push = |vertices: &[OverlayVertex]| -> Result<_, Error> {
            Ok((frame.uploads().push(vertices)?, vertices.len() as u32))
        };
        Ok(OverlayIo {
            triangles: push(&self.triangles)?,
            lines: push(&self.lines)?,
            lines_through: push(&self.lines_through)?,
        })
    }
}

/// The corners of the six faces. The bits of corner `i` select the low or high x, y and z.
const FACES: [[usize; 4]; 6] =
    [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];

fn corners_of(bounds: &Aabb) -> [Vec3; 8] {
    std::array::from_fn(|corner| {
        let pick =
            |bit: usize, low: f32, high: f32| if corner >> bit & 1 == 1 { high } else { low };
        Vec3::new(
            pick(0, bounds.min.x, bounds.max.x),
            pick(1, bounds.min.y, bounds.max.y),
            pick(2, bounds.min.z, bounds.max.z),
        )
    })
}

/// Returns the corners of the view's frustum from the near plane to `reach`, numbered like the
/// corners of a box.
fn frustum_corners(view: &CullView, reach: f32) -> [Vec3; 8] {
    std::array::from_fn(|corner| {
        let side = |bit: usize| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let depth_m = if corner >> 2 & 1 == 1 { reach } else { view.rays.near };
        view.rays.point(Vec2::new(side(0), side(1)), depth_m)
    })
}

fn push_edges(lines: &mut Vec<OverlayVertex>, corners: &[Vec3; 8], colour: u32) {
    for from in 0..8usize {
        for bit in 0..3 {
            let to = from | 1 << bit;
            if to != from {
                lines.push(vertex(corners[from], colour));
                lines.push(vertex(corners[to], colour));
            }
        }
    }
}

fn vertex(position: Vec3, colour: u32) -> OverlayVertex {
    OverlayVertex { position: position.to_array(), colour }
}
