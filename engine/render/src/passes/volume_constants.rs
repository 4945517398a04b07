//! The push constants of shadow volumes: the view, the light, and the begin and end of volumes.

use bytemuck::{Pod, Zeroable};
use cull::{CullView, ProjectionKind};
use glam::Vec4;
use shadows::{Caps, VolumeCounting, VolumeEnd, VolumeKind};

use crate::passes::opaque::anchored;

/// Casters that are drawn in the same way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VolumeGroup {
    /// The counting that is correct for the eye.
    pub counting: VolumeCounting,
    /// The algorithm that is correct for the mesh and the light.
    pub kind: VolumeKind,
    /// The index of their far end among the ends of the light.
    pub end: usize,
}

impl VolumeGroup {
    /// The highest number of groups per light: six sides and infinity, four groups each.
    pub const MOST: usize = 4 * 7;

    /// Returns all groups of a light with `ends` far ends.
    pub fn all(ends: usize) -> impl Iterator<Item = Self> + Clone {
        let countings = [VolumeCounting::ZPass, VolumeCounting::ZFail];
        let kinds = [VolumeKind::Plain, VolumeKind::Robust];
        countings.into_iter().flat_map(move |counting| {
            let of = move |kind| (0..ends).map(move |end| Self { counting, kind, end });
            kinds.into_iter().flat_map(of)
        })
    }
}

/// Mirrors `volume_constants.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct VolumeConstants {
    /// See [`anchored`].
    anchored: [f32; 16],
    light: [f32; 4],
    end: [f32; 4],
    steps: [f32; 2],
    cap_depth: [f32; 2],
    is_robust: u32,
    caps: u32,
    far_w: f32,
    anchor_w: f32,
}

const _: () = assert!(size_of::<VolumeConstants>() == 128);

/// The distance by which a near cap is farther than the surface that it is made of, as a part of
/// the height of a pixel there: drivers may round the corners of a clipped surface by that much.
const CAP_SHIFT: f32 = 1.0 / 16.0;

impl VolumeConstants {
    /// Returns the constants of the draws of a group of casters.
    pub(super) fn new(
        view: &CullView,
        light: Vec4,
        ends: &[VolumeEnd],
        VolumeGroup { counting, kind, end }: VolumeGroup,
    ) -> Self {
        let end = ends.get(end).copied().unwrap_or(VolumeEnd::INFINITY);
        let light = light - light.w * view.anchor.extend(0.0);
        Self {
            anchored: anchored(view),
            light: light.to_array(),
            end: end.along_from(view.anchor).to_array(),
            steps: view.snap_steps,
            is_robust: u32::from(kind == VolumeKind::Robust),
            caps: match counting.caps(kind) {
                Caps::None => 0,
                Caps::Near => 1,
                Caps::Both => 2,
            },
            far_w: end.w,
            anchor_w: view.from_anchor.w_axis.w,
            cap_depth: cap_depth(view),
        }
    }
}

/// Returns the factor on a near cap's depth, and the value that is subtracted from it.
fn cap_depth(view: &CullView) -> [f32; 2] {
    let [_, height] = view.size;
    // In metres; in perspective at a distance of one metre.
    let shift_m = CAP_SHIFT * 2.0 * view.rays.down.length() / height.max(1) as f32;
    match view.rays.kind {
        ProjectionKind::Perspective => [1.0 - shift_m.min(0.5), 0.0],
        ProjectionKind::Orthographic => [1.0, shift_m * view.rays.depth[1].abs()],
    }
}
