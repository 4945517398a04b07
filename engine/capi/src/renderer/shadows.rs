//! The shadows of a renderer as a host describes them, and their counts.

use render::LightShadow;
use shadows::{
    CasterCulling, ShadowBias, ShadowCaching, ShadowFilter, ShadowMethod, ShadowOptions,
    ShadowStats,
};

use crate::error::Failure;
use crate::layout::{Versioned, layout, versioned};

/// No shadows.
pub const ANTUMBRA_SHADOWS_OFF: u32 = 0;
/// Shadow maps, which are kept until something in them changes.
pub const ANTUMBRA_SHADOWS_MAPS: u32 = 1;
/// Stencil shadow volumes: hard edges, exact to the pixel. They need one sample per pixel, and the
/// features `depthClamp` and `fragmentStoresAndAtomics` of the device.
pub const ANTUMBRA_SHADOWS_VOLUMES: u32 = 2;

/// A disk of samples as wide as the penumbra: 8 on its edge, and 56 more where these disagree.
pub const ANTUMBRA_SHADOW_FILTER_ADAPTIVE: u32 = 0;
/// One sample: edges as wide as a texel.
pub const ANTUMBRA_SHADOW_FILTER_SINGLE: u32 = 1;
/// Three by three samples.
pub const ANTUMBRA_SHADOW_FILTER_PCF3: u32 = 2;
/// PCSS, whose width depends on the distance to the blocker: 8 samples find it, 12 filter.
pub const ANTUMBRA_SHADOW_FILTER_PCSS12: u32 = 3;
/// All 64 samples of the disk, at every pixel.
pub const ANTUMBRA_SHADOW_FILTER_FIXED64: u32 = 4;
/// As `ANTUMBRA_SHADOW_FILTER_PCSS12`, with 32 and 64 samples.
pub const ANTUMBRA_SHADOW_FILTER_PCSS64: u32 = 5;

/// Samples are compared with the depth of the receiver's plane.
pub const ANTUMBRA_SHADOW_BIAS_PLANE: u32 = 0;
/// The maps hold the surfaces that face away from the light, for closed meshes.
pub const ANTUMBRA_SHADOW_BIAS_BACK_FACES: u32 = 1;
/// The maps hold depths halfway between fronts and backs, and all casters are drawn.
pub const ANTUMBRA_SHADOW_BIAS_MIDPOINT: u32 = 2;

/// A map is drawn again only if something in it changed.
pub const ANTUMBRA_SHADOW_CACHING_CACHED: u32 = 0;
/// Every map is drawn in every frame.
pub const ANTUMBRA_SHADOW_CACHING_UNCACHED: u32 = 1;

/// Casters whose shadow cannot fall on something visible are left out. Needs one sample per pixel;
/// otherwise all casters are drawn.
pub const ANTUMBRA_CASTER_CULLING_CULLED: u32 = 0;
/// All casters are drawn.
pub const ANTUMBRA_CASTER_CULLING_UNCULLED: u32 = 1;

/// The options of shadows.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AntumbraShadowDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// An `ANTUMBRA_SHADOWS_..`. Default: `ANTUMBRA_SHADOWS_OFF`.
    pub method: u32,
    /// An `ANTUMBRA_SHADOW_FILTER_..`, for maps. Default: `ANTUMBRA_SHADOW_FILTER_ADAPTIVE`.
    pub filter: u32,
    /// An `ANTUMBRA_SHADOW_BIAS_..`, for maps. Default: `ANTUMBRA_SHADOW_BIAS_PLANE`.
    pub bias: u32,
    /// An `ANTUMBRA_SHADOW_CACHING_..`, for maps. Default: `ANTUMBRA_SHADOW_CACHING_CACHED`.
    pub caching: u32,
    /// An `ANTUMBRA_CASTER_CULLING_..`. Default: `ANTUMBRA_CASTER_CULLING_CULLED`.
    pub culling: u32,
    /// The number of maps of the sun, 1 to 8. Each map reaches three times as far as the previous
    /// one. Default: 4.
    pub cascades: u32,
    /// The side of a map of the sun in texels, a power of two of at least 16. Default: 2048.
    pub map_side: u32,
    /// The most layers of maps, each with a side of `map_side`, but at least 512 texels. With
    /// volumes, the most layers of the mask of lights, each as large as the image. Default: 8.
    pub layers_max: u32,
    /// The distance from the eye to which the sun has shadows (metres), below 1e6. Default: 0, for
    /// a distance that suits the scene: 200, and more if its objects are larger than houses.
    pub distance: f32,
    /// The width of penumbras (metres), below 1e3. Default: 0, a hard edge.
    pub penumbra: f32,
    /// The width of the band in which a cascade blends into the next one, as a share of half its
    /// side, up to 0.5. Default: 0, none.
    pub cascade_blend: f32,
}
layout!(AntumbraShadowDesc: struct_size, method, filter, bias, caching, culling, cascades,
    map_side, layers_max, distance, penumbra, cascade_blend);

versioned!(AntumbraShadowDesc: 12,
    required: [],
    defaults: { cascades: 4, map_side: 2048, layers_max: 8 }
);

/// Returns the value of a constant, which is its index in `values`.
fn chosen<T: Copy>(kind: &str, values: &[T], number: u32) -> Result<T, Failure> {
    let unknown = || Failure::argument(format_args!("there is no {kind} {number}"));
    values.get(number as usize).copied().ok_or_else(unknown)
}

impl AntumbraShadowDesc {
    /// Returns the options, without a check that a device supports them.
    pub(crate) fn options(&self) -> Result<ShadowOptions, Failure> {
        use ShadowFilter as F;
        let filters = [F::Adaptive, F::Single, F::Pcf3, F::Pcss12, F::Fixed64, F::Pcss64];
        let biases = [ShadowBias::Plane, ShadowBias::BackFaces, ShadowBias::Midpoint];
        let ways = [ShadowCaching::Cached, ShadowCaching::Uncached];
        let choices = [CasterCulling::Culled, CasterCulling::Unculled];
        let default = ShadowOptions::default();
        let distance_m = (self.distance != 0.0).then_some(self.distance);
        let options = ShadowOptions {
            method: chosen("ANTUMBRA_SHADOWS_..", &ShadowMethod::ALL, self.method)?,
            filter: chosen("ANTUMBRA_SHADOW_FILTER_..", &filters, self.filter)?,
            bias: chosen("ANTUMBRA_SHADOW_BIAS_..", &biases, self.bias)?,
            caching: chosen("ANTUMBRA_SHADOW_CACHING_..", &ways, self.caching)?,
            culling: chosen("ANTUMBRA_CASTER_CULLING_..", &choices, self.culling)?,
            penumbra_m: self.penumbra,
            cascades: self.cascades,
            cascade_blend: self.cascade_blend,
            distance_m,
            sun_side: self.map_side,
            layers_max: self.layers_max,
            ..default
        };
        options.check().map_err(Failure::argument)?;
        Ok(options)
    }
}

/// The shadow of one light, in place of what the options of all lights say.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AntumbraLightShadowDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// 1 for a light without shadows. Default: 0, for a light that casts them.
    pub is_off: u32,
    /// The width of its penumbras (metres), below 1e3. Default: 0, a hard edge.
    pub penumbra: f32,
}
layout!(AntumbraLightShadowDesc: struct_size, is_off, penumbra);

versioned!(AntumbraLightShadowDesc: 3, required: [], defaults: {});

impl AntumbraLightShadowDesc {
    /// Returns the shadow.
    pub(crate) fn shadow(&self) -> Result<LightShadow, Failure> {
        let is_cast = match self.is_off {
            0 => true,
            1 => false,
            other => {
                return Err(Failure::argument(format_args!("desc.is_off is {other}, not 0 or 1")));
            }
        };
        Ok(LightShadow { is_cast, penumbra_m: self.penumbra })
    }
}

/// The counts of the shadows of the newest frame.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AntumbraShadowStats {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The lights with shadows.
    pub lights: u32,
    /// The maps.
    pub maps: u32,
    /// The maps that the frame drew, wholly or in part.
    pub drawn_maps: u32,
    /// The maps among these whose casters are culled.
    pub culled_maps: u32,
    /// The casters in drawn maps, culled or not, or the casters of volumes.
    pub casters: u32,
    /// The tests that decide about culled casters.
    pub tests: u32,
    /// The volumes that are counted by z-fail, since the eye may be inside them.
    pub z_fail_volumes: u32,
    /// The lights that have no shadows for lack of room.
    pub unshadowed_lights: u32,
    /// Is 0.
    pub reserved: u32,
    /// The triangles of casters that are drawn, as far as is known when the frame is submitted.
    pub triangles: u64,
    /// The triangles of culled casters that tests revealed, in the newest frame with results.
    pub revealed_triangles: u64,
}
layout!(AntumbraShadowStats: struct_size, lights, maps, drawn_maps, culled_maps, casters, tests,
    z_fail_volumes, unshadowed_lights, reserved, triangles, revealed_triangles);

versioned!(AntumbraShadowStats: 12, required: [], defaults: {});

impl From<ShadowStats> for AntumbraShadowStats {
    fn from(stats: ShadowStats) -> Self {
        Self {
            lights: stats.lights,
            maps: stats.faces,
            drawn_maps: stats.drawn_faces,
            culled_maps: stats.culled_faces,
            casters: stats.casters,
            tests: stats.tests,
            z_fail_volumes: stats.z_fail_volumes,
            unshadowed_lights: stats.unshadowed_lights,
            triangles: stats.triangles,
            revealed_triangles: stats.revealed_triangles,
            ..Self::INIT
        }
    }
}
