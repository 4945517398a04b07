//! The lights with shadows among all lights.

use std::collections::HashMap;

use ::shadows::{LightShape, ShadowLight, ShadowLightId, ShadowOptions};
use scene::{LightId, LightKind, PunctualLight};

use crate::shading::surfaces::{LightTable, is_bright, reach_m};

/// The shadow of one light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightShadow {
    /// True if the light casts shadows.
    pub is_cast: bool,
    /// The width of its penumbras in metres, at least 0. With
    /// [`Pcss12`](::shadows::ShadowFilter::Pcss12) and `Pcss64` it is the width for a receiver that
    /// is twice as far from a lamp as the blocker, or ten metres behind the blocker under a sun.
    pub penumbra_m: f32,
}

impl LightShadow {
    /// Returns the shadow of a light without settings of its own.
    pub(crate) fn of(options: &ShadowOptions) -> Self {
        Self { is_cast: true, penumbra_m: options.penumbra_m }
    }
}

/// The farthest reach of a light, in metres. The brightest lights would reach beyond all
/// coordinates.
const FARTHEST_M: f32 = 9.0e6;

/// Lists the lights that shine and have shadows, each with its place in the table.
pub(super) fn list(
    table: &LightTable,
    options: &ShadowOptions,
    own: &HashMap<LightId, LightShadow>,
    lights: &mut Vec<ShadowLight>,
    places: &mut Vec<u32>,
) {
    lights.clear();
    places.clear();
    let all = (0..).map(LightId).zip(table.lights.iter().zip(&table.places));
    for (id, (light, place)) in all {
        let shadow = own.get(&id).copied().unwrap_or(LightShadow::of(options));
        if let Some(place) = place
            && shadow.is_cast
            && is_bright(light)
        {
            let penumbra_m = shadow.penumbra_m.max(0.0);
            lights.push(ShadowLight {
                id: ShadowLightId(id.0),
                shape: shape_of(light),
                penumbra_m,
            });
            places.push(*place);
        }
    }
}

fn shape_of(light: &PunctualLight) -> LightShape {
    let PunctualLight { position, direction, .. } = *light;
    let reach_m = reach_m(light).min(FARTHEST_M);
    let direction = direction.normalize_or_zero();
    match light.kind {
        LightKind::Directional => LightShape::Sun { towards: -direction },
        LightKind::Point => LightShape::Point { position, reach_m },
        LightKind::Spot { outer_rad, .. } => {
            LightShape::Spot { position, direction, outer_rad, reach_m }
        }
    }
}
