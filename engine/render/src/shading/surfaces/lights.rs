//! The light table: the shaders' data of each light.

use bytemuck::{Pod, Zeroable};
use cull::trigonometry;
use glam::Vec3;
use scene::limits::MAX_DIRECTIONAL_LIGHTS;
use scene::{LightCookie, LightId, LightKind, PunctualLight, Surfaces, TextureId};

use crate::resources::spare_capacity::SpareCapacity;
use crate::shading::surfaces::materials::{NO_TEXTURE, packed};
use crate::shading::surfaces::texture_slots::TexturePlace;

/// The share of white, at an exposure of 1, below which a light counts as dark.
const DARK: f32 = 1.0 / 256.0;

/// One light in the form that `lights.glsl` declares.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct LightEntry {
    /// The position, and 1 / range in 1/m; 0 without a range.
    position: [f32; 4],
    /// Red, green and blue in lux or candela, and the scale of the cone.
    intensity: [f32; 4],
    /// The direction of the light, and the offset of the cone.
    direction: [f32; 4],
    /// The direction to the right in a spot light's picture, divided by the tangent of half the
    /// cone angle.
    right: [f32; 3],
    /// The picture, packed like the textures of materials.
    picture: u32,
}

const _: () = assert!(size_of::<LightEntry>() == 64);

/// The widest cone (half of its angle) that a picture fills. Wider cones repeat the picture as its
/// sampler says.
const WIDEST_PICTURE_RAD: f32 = 1.4;

impl Default for LightEntry {
    /// Returns the entry of a dark light.
    fn default() -> Self {
        Self { picture: NO_TEXTURE, ..Self::zeroed() }
    }
}

impl LightEntry {
    /// Creates the entry of a light, with the place of its picture, if it has one. The entry is
    /// dark for an invalid light (numbers that are not finite, no intensity).
    pub(crate) fn of(light: &PunctualLight, place: Option<TexturePlace>) -> Self {
        if !is_bright(light) {
            return Self::default();
        }
        // A light without a range ends where it gets dark, as its shadows do. The sign marks this
        // case.
        let range_m = light.range_m.filter(|range| *range > 0.0);
        let inverse_range = range_m.map_or(-reach_m(light).recip(), f32::recip);
        // The cone of KHR_lights_punctual: 1 within the inner angle, 0 beyond the outer one.
        let (scale, offset) = match light.kind {
            LightKind::Spot { inner_rad, outer_rad } => {
                let inner = trigonometry::cos(inner_rad);
                let outer = trigonometry::cos(outer_rad);
                let scale = (inner - outer).max(0.001).recip();
                (scale, -outer * scale)
            }
            LightKind::Directional | LightKind::Point => (0.0, 1.0),
        };
        let [red, green, blue] = light.colour.map(|part| part.max(0.0) * light.intensity);
        let direction = light.direction.normalize_or_zero();
        let picture = light.cookie.zip(place);
        Self {
            position: light.position.extend(inverse_range).to_array(),
            intensity: [red, green, blue, scale],
            direction: direction.extend(offset).to_array(),
            right: picture.map_or([0.0; 3], |(picture, _)| picture_right(light, &picture)),
            picture: picture.map_or(NO_TEXTURE, |(_, place)| packed(place)),
        }
    }
}

/// Returns the direction to the right edge of a spot light's picture, divided by the distance from
/// the middle to that edge when the picture is a metre away.
fn picture_right(light: &PunctualLight, picture: &LightCookie) -> [f32; 3] {
    let LightKind::Spot { outer_rad, .. } = light.kind else { return [0.0; 3] };
    let direction = light.direction.normalize_or_zero();
    let right = direction.cross(picture.up.normalize_or_zero());
    let right = right.try_normalize().unwrap_or_else(|| {
        if direction == Vec3::ZERO { Vec3::ZERO } else { direction.any_orthonormal_vector() }
    });
    (right / trigonometry::tan(outer_rad.clamp(0.001, WIDEST_PICTURE_RAD))).to_array()
}

/// Returns true if a light gives any light, and all its numbers are finite.
pub(crate) fn is_bright(light: &PunctualLight) -> bool {
    has_numbers(light) && strongest_part(light) > 0.0
}

/// Returns true if a light has a number that is not finite, lacks a direction that it needs, or has
/// a range that is not above 0.
pub(crate) fn is_broken(light: &PunctualLight) -> bool {
    let needs_direction = light.kind != LightKind::Point;
    let has_direction = light.direction != Vec3::ZERO || !needs_direction;
    let has_range = light.range_m.is_none_or(|range| range > 0.0);
    !(has_numbers(light) && has_direction && has_range)
}

/// Returns true if all numbers of a light are finite.
fn has_numbers(light: &PunctualLight) -> bool {
    let angles = match light.kind {
        LightKind::Spot { inner_rad, outer_rad } => inner_rad + outer_rad,
        LightKind::Directional | LightKind::Point => 0.0,
    };
    let reach = light.range_m.unwrap_or_default();
    let [red, green, blue] = light.colour;
    let numbers = [angles, reach, red + green + blue, light.intensity, strongest_part(light)];
    numbers.iter().all(|number| number.is_finite())
        && light.position.is_finite()
        && light.direction.is_finite()
}

/// Returns the intensity of the strongest colour channel, in lux or candela.
pub(crate) fn strongest_part(light: &PunctualLight) -> f32 {
    light.colour.into_iter().fold(0.0, f32::max) * light.intensity
}

/// Returns the reach of a point or spot light (metres): its range, or the distance beyond which a
/// white surface that faces it is darker than 1/256 of white at an exposure of 1. A matt surface of
/// irradiance E has radiance E / pi.
#[must_use]
pub fn reach_m(light: &PunctualLight) -> f32 {
    let dark = (strongest_part(light).max(0.0) / (DARK * std::f32::consts::PI)).sqrt();
    light.range_m.filter(|range| *range > 0.0).unwrap_or(dark)
}

/// Returns a light of this kind that does not shine.
pub(crate) fn dark_light(kind: LightKind) -> PunctualLight {
    PunctualLight {
        kind,
        colour: [0.0; 3],
        intensity: 0.0,
        range_m: None,
        position: Vec3::ZERO,
        direction: Vec3::NEG_Z,
        cookie: None,
    }
}

/// The lights of a scene in the order of the table, and room for more.
#[derive(Debug, Default)]
pub(crate) struct LightTable {
    /// All present lights in the scene's order, followed by the room for more, which are dark
    /// lights.
    pub(crate) lights: Vec<PunctualLight>,
    /// The place of each light in the table; `None` for surplus directional lights.
    pub(crate) places: Vec<Option<u32>>,
    /// The number of places for directional lights, which come first.
    pub(crate) directional: u32,
    /// The number of surplus directional lights, which do not shine.
    pub(crate) dark_suns: usize,
    /// True for each light that does not exist: it was removed, or is room for another.
    is_free: Vec<bool>,
    /// Free lights with a place: point and spot lights, directional lights.
    free: [Vec<LightId>; 2],
}

impl LightTable {
    /// Creates the table: the strongest directional lights first, then all others in their order.
    pub(crate) fn new(surfaces: &Surfaces, spare: &SpareCapacity) -> Self {
        let count = surfaces.lights.len();
        let dark = |kind, count| std::iter::repeat_n(dark_light(kind), count as usize);
        let room = dark(LightKind::Directional, spare.directional_lights)
            .chain(dark(LightKind::Point, spare.lights));
        let lights: Vec<PunctualLight> = surfaces.lights.iter().copied().chain(room).collect();
        let is_directional = |place: &usize| {
            lights.get(*place).is_some_and(|light| light.kind == LightKind::Directional)
        };
        let (mut suns, others): (Vec<usize>, Vec<usize>) =
            (0..lights.len()).partition(is_directional);
        let strength = |place: &usize| {
            lights.get(*place).filter(|light| is_bright(light)).map_or(0.0, strongest_part)
        };
        suns.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
        let dark_suns = suns.len().saturating_sub(MAX_DIRECTIONAL_LIGHTS);
        suns.truncate(MAX_DIRECTIONAL_LIGHTS);
        let mut places = vec![None; lights.len()];
        for (entry, place) in (0..).zip(suns.iter().chain(&others)) {
            if let Some(found) = places.get_mut(*place) {
                *found = Some(entry);
            }
        }
        let is_free = (0..lights.len()).map(|light| light >= count).collect();
        let directional = suns.len() as u32;
        let mut table =
            Self { lights, places, directional, dark_suns, is_free, free: Default::default() };
        // The room is taken in ascending order.
        (count..table.lights.len()).rev().for_each(|light| table.offer(LightId(light as u32)));
        table
    }

    /// Returns a light; `None` if it does not exist.
    pub(crate) fn get(&self, light: LightId) -> Option<&PunctualLight> {
        let is_free = *self.is_free.get(light.0 as usize)?;
        self.lights.get(light.0 as usize).filter(|_| !is_free)
    }

    /// Returns the number of lights of a kind that can be [taken](LightTable::take).
    pub(crate) fn room(&self, kind: LightKind) -> usize {
        self.free[usize::from(kind == LightKind::Directional)].len()
    }

    /// Allocates a free light of this kind.
    pub(crate) fn take(&mut self, kind: LightKind) -> Option<LightId> {
        let light = self.free[usize::from(kind == LightKind::Directional)].pop()?;
        if let Some(is_free) = self.is_free.get_mut(light.0 as usize) {
            *is_free = false;
        }
        Some(light)
    }

    /// Frees a light, which must be [dark](dark_light).
    pub(crate) fn free(&mut self, light: LightId) {
        if let Some(is_free) = self.is_free.get_mut(light.0 as usize) {
            *is_free = true;
            self.offer(light);
        }
    }

    /// Takes over from `lost`, a table of the same scene, which lights do not exist.
    pub(crate) fn restore_free(&mut self, lost: &Self) {
        self.is_free.clone_from(&lost.is_free);
        self.free.clone_from(&lost.free);
    }

    /// Offers a light for reuse, unless it is surplus, since it would not shine.
    fn offer(&mut self, light: LightId) {
        if let Some(Some(place)) = self.places.get(light.0 as usize) {
            self.free[usize::from(*place < self.directional)].push(light);
        }
    }

    /// Returns the entries for the GPU, at least one. `place_of` returns the places of pictures.
    pub(crate) fn entries(
        &self,
        place_of: impl Fn(TextureId) -> Option<TexturePlace>,
    ) -> Vec<LightEntry> {
        let count = self.places.iter().flatten().count().max(1);
        let mut entries = vec![LightEntry::default(); count];
        for (light, place) in self.lights.iter().zip(&self.places) {
            if let Some(entry) = place.and_then(|place| entries.get_mut(place as usize)) {
                *entry = LightEntry::of(
                    light,
                    light.cookie.and_then(|picture| place_of(picture.texture)),
                );
            }
        }
        entries
    }
}
