//! The sprites of a flare: the glow at its light, and ghosts on the line from the light through the
//! middle of the image.

use glam::Vec2;
use scene::LensFlare;

use crate::passes::{FlareShape, FlareSprite};

/// A ghost: an image of the light, reflected by the surfaces of a lens.
struct Ghost {
    /// The place on the line: 1 is the light, 0 the middle of the image.
    place: f32,
    /// The radius in units of half the height of the image.
    radius: f32,
    /// The factors on the light's red, green and blue.
    tint: [f32; 3],
}

const GHOSTS: [Ghost; 6] = [
    Ghost { place: 0.62, radius: 0.05, tint: [0.10, 0.07, 0.03] },
    Ghost { place: 0.34, radius: 0.11, tint: [0.03, 0.05, 0.07] },
    Ghost { place: -0.22, radius: 0.07, tint: [0.07, 0.09, 0.04] },
    Ghost { place: -0.48, radius: 0.16, tint: [0.05, 0.03, 0.06] },
    Ghost { place: -0.80, radius: 0.09, tint: [0.03, 0.07, 0.08] },
    Ghost { place: -1.25, radius: 0.30, tint: [0.05, 0.04, 0.03] },
];

/// Returns the sprites of a flare whose light is at `middle` in normalised device coordinates, in
/// an image of `size` pixels. Without brightness there are none.
pub(super) fn sprites(
    flare: &LensFlare,
    middle: Vec2,
    brightness: f32,
    size: [u32; 2],
) -> impl Iterator<Item = FlareSprite> + use<> {
    let [width, height] = size.map(|side| side.max(1) as f32);
    let sprite = move |shape, middle: Vec2, radius: f32, colour: [f32; 3]| FlareSprite {
        middle: middle.to_array(),
        radius: [radius * height / width, radius],
        colour,
        shape,
    };
    let LensFlare { colour, glow, ghosts, .. } = *flare;
    let scaled = move |by: f32| colour.map(|part| part * by);
    let glow = sprite(FlareShape::GLOW, middle, glow, scaled(brightness));
    let ghost = move |ghost: &Ghost| {
        let [red, green, blue] = scaled(brightness * ghosts);
        let [of_red, of_green, of_blue] = ghost.tint;
        let colour = [red * of_red, green * of_green, blue * of_blue];
        sprite(FlareShape::GHOST, middle * ghost.place, ghost.radius, colour)
    };
    let all = std::iter::once(glow).chain(GHOSTS.iter().map(ghost));
    all.filter(|sprite| sprite.radius[1] > 0.0 && sprite.colour.iter().any(|part| *part > 0.0))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use scene::FlarePlace;

    use super::*;

    const FLARE: LensFlare = LensFlare {
        place: FlarePlace::Towards(Vec3::NEG_Z),
        radius: 0.01,
        colour: [1.0, 0.5, 0.25],
        glow: 0.4,
        ghosts: 1.0,
    };

    #[test]
    fn sprites_lie_on_the_line_through_the_middle_and_are_round() {
        let middle = Vec2::new(0.6, -0.3);
        let found: Vec<FlareSprite> = sprites(&FLARE, middle, 0.5, [200, 100]).collect();
        assert_eq!(found.len(), 1 + GHOSTS.len());
        assert_eq!(found[0].middle, middle.to_array());
        assert_eq!(found[0].colour, [0.5, 0.25, 0.125]);
        for sprite in &found {
            assert!(Vec2::from(sprite.middle).perp_dot(middle).abs() < 1.0e-6, "{sprite:?}");
            let [across, up] = sprite.radius;
            assert!((across * 2.0 - up).abs() < 1.0e-6, "{sprite:?}");
        }
        assert!(found.iter().any(|sprite| Vec2::from(sprite.middle).dot(middle) < 0.0));
    }

    #[test]
    fn nothing_is_drawn_that_adds_nothing() {
        let count = |flare: LensFlare, brightness| {
            sprites(&flare, Vec2::ZERO, brightness, [64, 64]).count()
        };
        assert_eq!(count(FLARE, 0.0), 0);
        assert_eq!(count(LensFlare { ghosts: 0.0, ..FLARE }, 1.0), 1);
        assert_eq!(count(LensFlare { glow: 0.0, ..FLARE }, 1.0), GHOSTS.len());
    }
}
