//! The reach of shadows for culling: the distances at which the filters of maps sample.

use cull::LightReach;

use crate::face::Face;
use crate::light::ShadowLight;
use crate::options::ShadowFilter;

/// The steepest slope that filters follow; equals `SLOPE_MAX` in `shadows.glsl`.
const SLOPE_MAX: f32 = 32.0;

/// The distance, in texels, of the texels with which a sample is compared, plus the distance by
/// which vertices may be snapped.
const AROUND_TEXELS: f32 = 2.5;

/// The receiver's shift towards the light, in slopes of a texel; equals the one in `receiver_of` in
/// `shadows.glsl`.
const BIAS_TEXELS: f32 = 1.25;

/// The share of the distance to a local light by which a caster may be farther than the receiver.
/// It follows from the lower limit in `receiver_of` in `shadows.glsl`: nothing at twice the
/// distance blocks.
const LOCAL_LEAD: f32 = 0.5;

/// The value of [`LOCAL_LEAD`] for filters of a few texels, whose bias covers slopes.
const LEAST_LOCAL_LEAD: f32 = 1.0 / 16.0;

/// Returns the radius of the disk that a filter samples, in metres; 0 for filters of a few texels.
fn radius_m(filter: ShadowFilter, penumbra_m: f32) -> f32 {
    match filter {
        ShadowFilter::Single | ShadowFilter::Pcf3 => 0.0,
        ShadowFilter::Fixed64
        | ShadowFilter::Adaptive
        | ShadowFilter::Pcss12
        | ShadowFilter::Pcss64 => 0.5 * penumbra_m,
    }
}

/// Returns the reach of a light whose shadows are sampled in these faces.
#[must_use]
pub fn light_reach<'a>(
    light: &ShadowLight,
    faces: impl Iterator<Item = &'a Face>,
    filter: ShadowFilter,
) -> LightReach {
    let reach = light.shape.reach();
    let far_m = reach.map_or(1.0, |(_, reach_m)| reach_m);
    let mut least_m = f32::INFINITY;
    let mut most_m = 0.0_f32;
    for face in faces {
        let texel_m = 2.0 * face.view.rays.right.length() / face.view.size[0].max(1) as f32;
        // Texels of local lights grow with the distance, from 0.
        least_m = least_m.min(if reach.is_some() { 0.0 } else { texel_m });
        most_m = most_m.max(texel_m * far_m);
    }
    let radius_m = radius_m(filter, light.penumbra_m);
    let lead = match (reach, radius_m > 0.0) {
        (None, _) => SLOPE_MAX * (radius_m - BIAS_TEXELS * least_m).max(0.0) + most_m,
        (Some(_), true) => LOCAL_LEAD,
        (Some(_), false) => LEAST_LOCAL_LEAD,
    };
    LightReach {
        light: light.shape.homogeneous(),
        reach_m: reach.map_or(f32::INFINITY, |(_, reach_m)| reach_m),
        spread_m: radius_m.max(most_m) + AROUND_TEXELS * most_m,
        lead,
    }
}
