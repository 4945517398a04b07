//! Lens flares: the lights that have one, and the values that a renderer draws it with.

use glam::Vec3;

use crate::punctual_light::{LightKind, PunctualLight};

/// The place of a light that flares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlarePlace {
    /// A point of the world, in metres.
    At(Vec3),
    /// Infinitely far away in this direction, of any length: a sun.
    Towards(Vec3),
}

/// A light that shines into the lens: a glow around it, and ghosts along the line from it through
/// the middle of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensFlare {
    /// The place of the light.
    pub place: FlarePlace,
    /// The radius of the light, at least 0: in metres, or in radians for an infinitely distant
    /// light. Objects within this radius, such as the glass of a lamp, do not hide the light.
    pub radius: f32,
    /// Linear red, green and blue that the middle of the glow adds to the image, as displayed.
    pub colour: [f32; 3],
    /// The radius of the glow, 0 to 4: in multiples of half the image's height.
    pub glow: f32,
    /// The strength of the ghosts, 0 to 4: 1 is the usual strength.
    pub ghosts: f32,
}

/// The radius of the sun as seen from the earth (radians).
const SUN_RADIUS_RAD: f32 = 0.00465;

/// The radius of a lamp (metres), for point lights, whose description has no size.
const LAMP_RADIUS_M: f32 = 0.1;

impl LensFlare {
    /// Returns the flare of a light: a sun's for a directional light, a lamp's for a point light.
    /// `None` for a dark light and for a spot, since only its owner knows whether the eye is in its
    /// cone.
    #[must_use]
    pub fn of_light(light: &PunctualLight) -> Option<Self> {
        let brightest = light.colour.into_iter().fold(0.0, f32::max);
        let light_out = brightest * light.intensity;
        let is_lit = light_out > 0.0 && light_out.is_finite();
        let (place, radius, glow) = match light.kind {
            LightKind::Directional => (FlarePlace::Towards(-light.direction), SUN_RADIUS_RAD, 0.5),
            LightKind::Point => (FlarePlace::At(light.position), LAMP_RADIUS_M, 0.15),
            LightKind::Spot { .. } => return None,
        };
        let colour = light.colour.map(|part| (part / brightest).max(0.0) * 0.8);
        let flare = Self { place, radius, colour, glow, ghosts: 1.0 };
        (is_lit && flare.check().is_ok()).then_some(flare)
    }

    /// Checks that a flare can be drawn.
    ///
    /// # Errors
    /// The reason, for a message: values that are not finite, a direction without length, a
    /// negative radius or colour, a glow or ghosts out of range.
    pub fn check(&self) -> Result<(), &'static str> {
        let is_placed = match self.place {
            FlarePlace::At(point) => point.is_finite(),
            FlarePlace::Towards(direction) => direction.is_finite() && direction.length() > 1.0e-6,
        };
        let is_amount = |value: f32| value.is_finite() && value >= 0.0;
        let is_strength = |value: f32| (0.0..=4.0).contains(&value);
        match () {
            () if !is_placed => Err("its place must be finite, and a direction have a length"),
            () if !is_amount(self.radius) => Err("its radius must be finite and not negative"),
            () if !self.colour.into_iter().all(is_amount) => {
                Err("its colour must be finite and not negative")
            }
            () if !is_strength(self.glow) => Err("its glow must be between 0 and 4"),
            () if !is_strength(self.ghosts) => Err("its ghosts must be between 0 and 4"),
            () => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(kind: LightKind) -> PunctualLight {
        PunctualLight {
            kind,
            colour: [0.5, 0.25, 0.0],
            intensity: 10.0,
            range_m: None,
            position: Vec3::new(1.0, 2.0, 3.0),
            direction: Vec3::NEG_Y,
            cookie: None,
        }
    }

    #[test]
    fn suns_and_lamps_flare_in_their_colour() {
        let sun = LensFlare::of_light(&light(LightKind::Directional)).unwrap();
        assert_eq!(sun.place, FlarePlace::Towards(Vec3::Y));
        assert_eq!(sun.colour, [0.8, 0.4, 0.0]);
        let lamp = LensFlare::of_light(&light(LightKind::Point)).unwrap();
        assert_eq!(lamp.place, FlarePlace::At(Vec3::new(1.0, 2.0, 3.0)));
        assert!(lamp.glow < sun.glow);
    }

    #[test]
    fn spots_and_dark_lights_do_not() {
        let spot = LightKind::Spot { inner_rad: 0.1, outer_rad: 0.2 };
        assert_eq!(LensFlare::of_light(&light(spot)), None);
        for (colour, intensity) in
            [([0.0; 3], 1.0), ([1.0; 3], 0.0), ([1.0; 3], f32::NAN), ([f32::INFINITY; 3], 1.0)]
        {
            let dark = PunctualLight { colour, intensity, ..light(LightKind::Point) };
            assert_eq!(LensFlare::of_light(&dark), None, "{colour:?} {intensity}");
        }
        let nowhere = PunctualLight { direction: Vec3::ZERO, ..light(LightKind::Directional) };
        assert_eq!(LensFlare::of_light(&nowhere), None);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused_with_a_reason() {
        let good = LensFlare::of_light(&light(LightKind::Point)).unwrap();
        assert_eq!(good.check(), Ok(()));
        let bad = [
            LensFlare { place: FlarePlace::At(Vec3::NAN), ..good },
            LensFlare { place: FlarePlace::Towards(Vec3::ZERO), ..good },
            LensFlare { radius: -1.0, ..good },
            LensFlare { radius: f32::INFINITY, ..good },
            LensFlare { colour: [0.0, -0.1, 0.0], ..good },
            LensFlare { glow: 4.1, ..good },
            LensFlare { glow: f32::NAN, ..good },
            LensFlare { ghosts: -0.1, ..good },
        ];
        for flare in bad {
            assert!(flare.check().is_err_and(|reason| reason.starts_with("its ")), "{flare:?}");
        }
    }
}
