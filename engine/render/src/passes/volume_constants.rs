//! The push constants of shadow volumes: the view, the light, and where volumes begin and end.

use bytemuck::{Pod, Zeroable};
use cull::{ProjectionKind, View};
use glam::{Vec2, Vec4};
use shadows::{Caps, VolumeCounting, VolumeKind};

/// Casters that are drawn alike.
pub type VolumeGroup = (VolumeCounting, VolumeKind);

/// Mirrors `volume_constants.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct VolumeConstants {
    view_proj: [f32; 16],
    light: [f32; 4],
    steps: [f32; 2],
    cap_depth: [f32; 2],
    is_robust: u32,
    caps: u32,
    far_w: f32,
}

const _: () = assert!(size_of::<VolumeConstants>() == 108);

/// The part of a pixel's height, at its distance, by which a near cap is farther than the surface
/// that it is made of: drivers may round the corners of a surface that they clip to so much.
const CAP_SHIFT: f32 = 1.0 / 16.0;

/// The length of a sun's volumes in a parallel view, in sizes of what is in view.
const SUN_LENGTH: f32 = 10.0;

/// The nearest that casters come to a lamp where volumes end in a parallel view (metres).
const NEAREST_CASTER_M: f32 = 1e-3;

impl VolumeConstants {
    /// Returns the constants of the draws of a group of casters.
    pub(super) fn new(view: &View, light: Vec4, (counting, kind): VolumeGroup) -> Self {
        Self {
            view_proj: view.view_proj.to_cols_array(),
            light: light.to_array(),
            steps: view.snap_steps,
            is_robust: u32::from(kind == VolumeKind::Robust),
            caps: match counting.caps(kind) {
                Caps::None => 0,
                Caps::Near => 1,
                Caps::Both => 2,
            },
            far_w: far_w(view, light),
            cap_depth: cap_depth(view),
        }
    }
}

/// Returns the factor of a near cap's depth, and what is taken off it.
fn cap_depth(view: &View) -> [f32; 2] {
    let [_, height] = view.size;
    // In metres, in perspective at a distance of one.
    let shift_m = CAP_SHIFT * 2.0 * view.rays.down.length() / height.max(1) as f32;
    match view.rays.kind {
        ProjectionKind::Perspective => [1.0 - shift_m.min(0.5), 0.0],
        ProjectionKind::Orthographic => [1.0, shift_m * view.rays.depth[1].abs()],
    }
}

/// Returns w of the points at the far end of volumes: 0 for infinity.
///
/// In a parallel view no ray meets a far cap that is all at infinity, and the farther away it is,
/// the worse drivers round what they clip of the sides. So volumes end there, beyond all that is in
/// view: a sun's [`SUN_LENGTH`] times as far away as that is large, a lamp's where a caster that is
/// [`NEAREST_CASTER_M`] from it shades what is in view.
fn far_w(view: &View, light: Vec4) -> f32 {
    let rays = &view.rays;
    if rays.kind == ProjectionKind::Perspective {
        return 0.0;
    }
    let [near_depth, slope] = rays.depth;
    let length_m = if slope == 0.0 { 0.0 } else { (near_depth / slope).abs() };
    let middle = rays.point(Vec2::ZERO, 0.5 * length_m);
    let size_m = length_m + rays.right.length() + rays.down.length();
    match light.w > 0.0 {
        true => {
            let reach_m = size_m + middle.distance(light.truncate());
            NEAREST_CASTER_M / reach_m.max(NEAREST_CASTER_M)
        }
        false => (SUN_LENGTH * size_m).max(f32::MIN_POSITIVE).recip(),
    }
}
