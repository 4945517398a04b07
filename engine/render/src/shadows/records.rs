//! The shaders' data of shadows: of maps as declared in `shadows.glsl`, and of masks as declared in
//! `volume_shadows.glsl`.

use ::shadows::{Face, PlannedFace, ShadowLight, ShadowPlan};
use bytemuck::{Pod, Zeroable};
use cull::{CullView, ProjectionKind};
use gpu::{BufferSlice, SampledTexture};

/// The inputs of passes that draw with shadows.
#[derive(Clone, Copy)]
pub enum ShadowIo<'a> {
    /// The inputs for shadow maps.
    Maps(ShadowMapIo<'a>),
    /// The inputs for shadow volumes.
    Mask(ShadowMaskIo),
}

/// The inputs of passes that draw with shadow maps: the maps and their data are read.
#[derive(Clone, Copy)]
pub struct ShadowMapIo<'a> {
    /// A record per place in the table of lights, up to the last light with shadows.
    pub(crate) lights: BufferSlice,
    /// A record per map.
    pub(crate) faces: BufferSlice,
    /// The maps, for comparisons.
    pub(crate) maps: SampledTexture<'a>,
    /// The maps, for reads of single depths.
    pub(crate) depths: SampledTexture<'a>,
    /// The samples of filters.
    pub(crate) disks: SampledTexture<'a>,
    /// The index of the view in the frame.
    pub(crate) view: u32,
}

/// The inputs of passes that draw with shadow volumes: the mask of a view and the lights in it are
/// read.
#[derive(Clone, Copy)]
pub struct ShadowMaskIo {
    /// The position of the view, and the bit of each place in the table of lights.
    pub(crate) lights: BufferSlice,
    /// The mask: 32 bits per pixel of the view, in layers.
    pub(crate) mask: BufferSlice,
}

/// The number of values about a mask, which precede the values of lights.
pub(super) const MASK_HEAD_VALUES: usize = 4;

/// Writes the values of the mask of a view: its position, and the bit of each place in the table of
/// lights, up to the last light with a bit.
pub(super) fn write_mask_lights(
    view: &CullView,
    places: impl IntoIterator<Item = u32>,
    values: &mut Vec<u32>,
) {
    values.clear();
    values.extend(view.origin.into_iter().chain(view.size));
    for (bit, place) in (0..).zip(places) {
        let value = MASK_HEAD_VALUES + place as usize;
        if values.len() <= value {
            values.resize(value + 1, 0);
        }
        if let Some(there) = values.get_mut(value) {
            *there = bit + 1;
        }
    }
}

/// The record of one light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct LightRecord {
    first_face: u32,
    /// The number of its maps; for a directional light, per view.
    faces: u32,
    penumbra_m: f32,
    /// For a directional light, [`ShadowOptions::cascade_blend`](::shadows::ShadowOptions).
    cascade_blend: f32,
}

/// The record of one map.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct FaceRecord {
    /// The matrix for positions relative to its anchor.
    from_anchor: [f32; 16],
    /// Three columns of the inverse, which map planes relative to the anchor to planes in clip
    /// space.
    planes: [[f32; 4]; 3],
    /// The origin and the side in texels, and the layer.
    tile: [f32; 4],
    depth: [f32; 4],
    anchor: [f32; 4],
}

const _: () = assert!(size_of::<LightRecord>() == 16);
const _: () = assert!(size_of::<FaceRecord>() == 160);

impl FaceRecord {
    pub(super) fn of(planned: &PlannedFace) -> Self {
        let PlannedFace { face: Face { view, .. }, tile, .. } = planned;
        let inverse = view.from_anchor.as_dmat4().inverse().as_mat4();
        let [x, y] = tile.origin.map(|texel| texel as f32);
        Self {
            from_anchor: view.from_anchor.to_cols_array(),
            planes: [0, 1, 2].map(|column| inverse.col(column).to_array()),
            tile: [x, y, tile.side as f32, tile.layer as f32],
            depth: depth_of(view),
            anchor: view.anchor.extend(0.0).to_array(),
        }
    }
}

/// Returns the depth as a function of the distance, the change of depth over a tile on a slope of
/// 1, and the number of tiles per metre.
fn depth_of(view: &CullView) -> [f32; 4] {
    let [constant, scaled] = view.rays.depth;
    // The image is a square.
    let side_m = 2.0 * view.rays.right.length();
    let steepness = match view.rays.kind {
        ProjectionKind::Orthographic => -scaled * side_m,
        ProjectionKind::Perspective => side_m,
    };
    [constant, scaled, steepness, side_m.recip()]
}

/// Writes the records of all lights up to the last with maps, by their places in the table, for
/// this number of views and this [`ShadowOptions::cascade_blend`](::shadows::ShadowOptions).
pub(super) fn light_records(
    plan: &ShadowPlan,
    lights: &[ShadowLight],
    places: &[u32],
    views: u32,
    cascade_blend: f32,
    records: &mut Vec<LightRecord>,
) {
    records.clear();
    let mut planned = plan.lights.iter();
    for (light, place) in lights.iter().zip(places).filter(|(light, _)| light.shape.is_usable()) {
        let Some(planned) = planned.next() else { return };
        debug_assert_eq!(planned.light, light.id);
        let place = *place as usize;
        if records.len() <= place && !planned.faces.is_empty() {
            records.resize(place + 1, LightRecord::default());
        }
        let of_sun = if light.shape.reach().is_none() { views.max(1) } else { 1 };
        if let Some(record) = records.get_mut(place) {
            *record = LightRecord {
                first_face: planned.faces.start as u32,
                faces: planned.faces.len() as u32 / of_sun,
                penumbra_m: light.penumbra_m,
                cascade_blend,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use cull::{Camera, Projection};
    use glam::Vec3;

    use super::*;

    #[test]
    fn a_mask_names_the_bit_of_each_light_at_its_place() {
        let projection = Projection::perspective(1.0);
        let forward = Vec3::NEG_Z;
        let up = Vec3::Y;
        let camera = Camera { eye: Vec3::ZERO, forward, up, projection, near: 0.1 };
        let view = CullView { origin: [7, 3], ..CullView::new(&camera, [64, 48], 8) };
        let mut values = vec![9; 2];
        write_mask_lights(&view, [4, 1], &mut values);
        assert_eq!(values, [7, 3, 64, 48, 0, 2, 0, 0, 1]);
        write_mask_lights(&view, [], &mut values);
        assert_eq!(values.len(), MASK_HEAD_VALUES);
    }
}
