//! Lights of surfaces: suns, bulbs and spots, and the pictures that spots project.

use glam::Vec3;

use super::TextureId;

/// The kind of a light, by its origin and directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light along its direction; intensity in lux.
    Directional,
    /// Light from its position in all directions; intensity in candela.
    Point,
    /// Light from its position into a cone around its direction; intensity in candela.
    Spot {
        /// Half the angle within which it is at its full strength, in radians.
        inner_rad: f32,
        /// Half the angle beyond which it is dark, in radians.
        outer_rad: f32,
    },
}

/// The picture that a spot projects, like a slide: its colours are multiplied with the light's.
///
/// The picture is a square perpendicular to the direction of the light. The edge of the cone
/// touches its four sides. Seen along the light, the picture is upright and not mirrored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightCookie {
    /// The texture, one of the scene's; its alpha is ignored.
    pub texture: TextureId,
    /// The direction in the world towards the upper edge. The component along the light is ignored;
    /// if no other component is left, the direction is arbitrary.
    pub up: Vec3,
}

/// A light of `KHR_lights_punctual`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PunctualLight {
    /// The kind of light, with the angles of a spot's cone.
    pub kind: LightKind,
    /// Linear red, green, blue.
    pub colour: [f32; 3],
    /// The intensity in lux or candela, by its kind.
    pub intensity: f32,
    /// The distance to which it shines, in metres. With `None`, or a value that is not above 0, it
    /// shines as far as its light differs visibly from darkness.
    pub range_m: Option<f32>,
    /// The position in the world.
    pub position: Vec3,
    /// Unit vector along which it shines, in the world.
    pub direction: Vec3,
    /// The picture that a spot projects.
    pub cookie: Option<LightCookie>,
}

impl PunctualLight {
    /// Checks that the picture fits the light and a scene with `texture_count` textures.
    ///
    /// # Errors
    /// The reason, for a picture of a light that is not a spot, a texture that the scene does not
    /// have, or a direction that is not finite.
    pub fn check_cookie(&self, texture_count: usize) -> Result<(), &'static str> {
        let Some(LightCookie { texture, up }) = self.cookie else { return Ok(()) };
        if !matches!(self.kind, LightKind::Spot { .. }) {
            return Err("only spots project a picture");
        }
        if texture.0 as usize >= texture_count {
            return Err("the scene does not have the texture of its picture");
        }
        if up.is_finite() {
            Ok(())
        } else {
            Err("the upward direction of its picture is not finite")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_of_spots_and_of_textures_that_are_there() {
        let picture = LightCookie { texture: TextureId(2), up: Vec3::Y };
        let light = |kind, picture| PunctualLight {
            kind,
            colour: [1.0; 3],
            intensity: 1.0,
            range_m: None,
            position: Vec3::ZERO,
            direction: Vec3::NEG_Z,
            cookie: Some(picture),
        };
        let spot = LightKind::Spot { inner_rad: 0.1, outer_rad: 0.2 };
        assert_eq!(light(spot, picture).check_cookie(3), Ok(()));
        let refused = |light: PunctualLight| light.check_cookie(2).unwrap_err();
        assert!(refused(light(spot, picture)).contains("does not have the texture"));
        for kind in [LightKind::Point, LightKind::Directional] {
            assert!(refused(light(kind, picture)).contains("only spots"));
            assert_eq!(
                PunctualLight { cookie: None, ..light(kind, picture) }.check_cookie(0),
                Ok(())
            );
        }
        let lost = LightCookie { texture: TextureId(0), up: Vec3::NAN };
        assert!(refused(light(spot, lost)).contains("not finite"));
    }
}
