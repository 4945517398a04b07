//! The lens flares of the sun and the lamps of a scene whose lights change with the hour.

use antumbra::glam::Vec3;
use antumbra::scene::{FlarePlace, LensFlare, LightId, LightKind, LightMove, PunctualLight};
use scenes::Daylight;

/// The radius of the glass of a lamp, in metres: objects within it do not hide the light.
const GLASS_M: f32 = 0.35;

/// The glow of a lamp, and of a spot that shines into the lens, in multiples of half the image's
/// height.
const LAMP_GLOW: f32 = 0.13;
const SPOT_GLOW: f32 = 0.3;

/// The strength of lamp flares by day, when the aperture is smaller.
const BY_DAY: f32 = 0.35;

/// The strength of the ghosts of lamps, which are numerous.
const LAMP_GHOSTS: f32 = 0.35;

/// The intensity of a sun whose flare has full strength, in lux.
const FULL_SUN_LX: f32 = 3.2;

/// Returns the flares of all lights at an hour, in their order, seen from `eye`; `moved` is the
/// current state of the light that moves. Lights that do not flare get a black flare, so that every
/// light keeps its index.
pub fn flares_of(daylight: &Daylight, moved: Option<LightMove>, eye: Vec3) -> Vec<LensFlare> {
    let strength = if daylight.hour.is_night() { 1.0 } else { BY_DAY };
    let present = |light: LightMove| match moved {
        Some(moved) if moved.light == light.light => moved,
        _ => light,
    };
    let flare_of = |LightMove { to, .. }: LightMove| match to.kind {
        LightKind::Directional => of_sun(&to),
        LightKind::Point => of_lamp(&to, daylight.glass, strength),
        LightKind::Spot { inner_rad, outer_rad } => {
            of_spot(&to, inner_rad, outer_rad, eye, strength)
        }
    };
    let nothing = LensFlare {
        place: FlarePlace::Towards(Vec3::Y),
        radius: 0.0,
        colour: [0.0; 3],
        glow: 0.0,
        ghosts: 0.0,
    };
    let lights = daylight.lights().into_iter().map(present);
    lights.map(|light| flare_of(light).unwrap_or(nothing)).collect()
}

fn of_sun(sun: &PunctualLight) -> Option<LensFlare> {
    let flare = LensFlare::of_light(sun)?;
    let strength = (sun.intensity / FULL_SUN_LX).clamp(0.0, 1.0).sqrt();
    Some(LensFlare { colour: flare.colour.map(|part| part * strength), ..flare })
}

fn of_lamp(lamp: &PunctualLight, glass: Vec3, strength: f32) -> Option<LensFlare> {
    let flare = LensFlare::of_light(lamp)?;
    Some(LensFlare {
        place: FlarePlace::At(lamp.position + glass),
        radius: GLASS_M,
        colour: flare.colour.map(|part| part * strength),
        glow: LAMP_GLOW,
        ghosts: LAMP_GHOSTS,
    })
}

/// Returns the flare of a spot, whose strength follows its light at the eye.
fn of_spot(
    spot: &PunctualLight,
    inner_rad: f32,
    outer_rad: f32,
    eye: Vec3,
    strength: f32,
) -> Option<LensFlare> {
    let kind = LightKind::Point;
    let flare = LensFlare::of_light(&PunctualLight { kind, cookie: None, ..*spot })?;
    let turn = spot.direction.angle_between(eye - spot.position);
    let share = ((outer_rad - turn) / (outer_rad - inner_rad).max(1.0e-3)).clamp(0.0, 1.0);
    let strength = strength * share * share * (3.0 - 2.0 * share);
    (strength.is_finite() && strength > 0.0).then(|| LensFlare {
        radius: GLASS_M,
        colour: flare.colour.map(|part| part * strength),
        glow: SPOT_GLOW,
        ..flare
    })
}

/// Returns a light of the scene that projects a picture, if there is one.
pub fn projector_of(daylight: &Daylight) -> Option<LightId> {
    let mut lamps = daylight.lamps.iter();
    lamps.find(|(_, lamp)| lamp.cookie.is_some()).map(|(light, _)| *light)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenes::Hour;

    #[test]
    fn the_sun_the_lamps_and_spots_that_shine_at_the_eye_flare() {
        let yard = scenes::courtyard(Hour::NIGHT);
        let flares = |daylight: &Daylight, eye| flares_of(daylight, None, eye);
        let night = flares(&yard.daylight, yard.camera.eye);
        assert_eq!(night.len(), 9, "each light has its place");
        assert!(night.iter().all(|flare| flare.check().is_ok()));
        let is_lit = |flare: &LensFlare| flare.colour.iter().any(|part| *part > 0.0);
        let lit: Vec<bool> = night.iter().map(is_lit).collect();
        assert!(
            lit[0] && lit[3..8].iter().all(|is_lit| *is_lit),
            "{lit:?}: the moon and all lamps"
        );
        assert!(lit[1] && !lit[8], "{lit:?}: a spot shines here, and the projector from behind");
        let FlarePlace::At(place) = night[1].place else { panic!("a spot") };
        let behind = flares(&yard.daylight, place - yard.daylight.lamps[0].1.direction);
        assert!(!is_lit(&behind[1]), "it shines away");
        let day = Daylight { hour: Hour::AFTERNOON, ..yard.daylight.clone() };
        let day = flares(&day, yard.camera.eye);
        assert!(day[0].colour[0] > night[0].colour[0], "the sun is brighter than the moon");
        assert!(day[3].colour[0] < night[3].colour[0], "lamps are faint by day");
    }

    #[test]
    fn a_light_that_moves_flares_where_it_is() {
        let yard = scenes::courtyard(Hour::NIGHT);
        let moved = yard.motion.at(3.0).lights[0];
        let flares = flares_of(&yard.daylight, Some(moved), Vec3::ZERO);
        let glass = moved.to.position + yard.daylight.glass;
        assert_eq!(flares[3].place, FlarePlace::At(glass));
        assert_eq!(projector_of(&yard.daylight), Some(LightId(8)));
    }
}
