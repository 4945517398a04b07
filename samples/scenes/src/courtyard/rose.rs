//! The rose window: the picture that a spot projects on the ground of the courtyard.

use std::f32::consts::TAU;

use scene::{Encoding, Filter, Image, ImageId, Sampler, Surfaces, Texture, TextureId, Wrap};

/// The side of the image, in pixels.
const SIDE: u32 = 512;

/// The number of samples per pixel along each side.
const POINTS: u32 = 4;

/// The number of petals of a ring.
const PETALS: f32 = 12.0;

/// The width of the lead between panes, relative to half of the image's side.
const LEAD: f32 = 0.022;

/// The rings of panes: their outer radius relative to half of the image's side, and the linear
/// colours that alternate in them.
const RINGS: [(f32, [[f32; 3]; 2]); 4] = [
    (0.16, [[1.0, 0.78, 0.30], [1.0, 0.78, 0.30]]),
    (0.42, [[0.85, 0.08, 0.07], [0.95, 0.55, 0.08]]),
    (0.72, [[0.06, 0.16, 0.85], [0.08, 0.62, 0.55]]),
    (0.95, [[0.95, 0.62, 0.14], [0.55, 0.08, 0.50]]),
];

/// Adds the picture to the surfaces of a scene. Returns its texture.
pub(super) fn add(surfaces: &mut Surfaces) -> TextureId {
    let image = ImageId(surfaces.images.len() as u32);
    let rgba8 = (0..SIDE * SIDE).flat_map(|pixel| texel(pixel % SIDE, pixel / SIDE)).collect();
    surfaces.images.push(Image::of_rgba8("rose window", [SIDE; 2], rgba8));
    let sampler = Sampler {
        wrap: [Wrap::Clamp; 2],
        magnified: Filter::Linear,
        minified: Filter::Linear,
        between_levels: Some(Filter::Linear),
    };
    surfaces.textures.push(Texture { image, encoding: Encoding::Linear, sampler });
    TextureId(surfaces.textures.len() as u32 - 1)
}

/// Returns a pixel: the mean of its samples.
fn texel(column: u32, row: u32) -> [u8; 4] {
    let points = POINTS * POINTS;
    let mut sum = [0.0; 3];
    for point in 0..points {
        let [x, y] = [(column, point % POINTS), (row, point / POINTS)].map(|(pixel, part)| {
            // Samples include the neighbouring pixels, so that edges of panes are soft.
            let place = pixel as f32 - 0.5 + (part as f32 + 0.5) / POINTS as f32 * 2.0;
            place * 2.0 / SIDE as f32 - 1.0
        });
        let colour = pane(x.hypot(y), y.atan2(x).rem_euclid(TAU));
        sum = [0, 1, 2].map(|channel| sum[channel] + colour[channel]);
    }
    let [red, green, blue] = sum.map(|part| (part / points as f32 * 255.0).round() as u8);
    [red, green, blue, 255]
}

/// Returns the linear colour of the window at a distance from its middle and an angle: the colour
/// of a pane, or black in lead and outside of the window.
fn pane(radius: f32, turn: f32) -> [f32; 3] {
    let inner = |ring: usize| ring.checked_sub(1).map_or(0.0, |ring| RINGS[ring].0);
    let Some(ring) = RINGS.iter().position(|(outer, _)| radius < *outer) else { return [0.0; 3] };
    let (outer, colours) = RINGS[ring];
    let is_on_rim = radius > outer - LEAD || (ring > 0 && radius < inner(ring) + LEAD);
    // Panes of one ring are above the lead of the next ring.
    let petal = turn / TAU * PETALS + if ring % 2 == 0 { 0.0 } else { 0.5 };
    let from_lead = (petal - petal.round()).abs() / PETALS * TAU * radius;
    let is_on_spoke = ring > 0 && from_lead < LEAD;
    if is_on_rim || is_on_spoke { [0.0; 3] } else { colours[petal as usize % colours.len()] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_has_panes_and_lead_and_a_dark_edge() {
        let mut surfaces = Surfaces::default();
        assert_eq!(add(&mut surfaces), TextureId(0));
        let [red, green, blue, _] = texel(SIDE / 2, SIDE / 2);
        assert!(red > green && green > blue, "its middle is golden");
        for side in 0..SIDE {
            for [column, row] in [[side, 0], [side, SIDE - 1], [0, side], [SIDE - 1, side]] {
                assert_eq!(texel(column, row), [0, 0, 0, 255]);
            }
        }
        let lit = |number: &u32| texel(number % SIDE, number / SIDE) != [0, 0, 0, 255];
        let share = (0..SIDE * SIDE).filter(lit).count() as f32 / (SIDE * SIDE) as f32;
        assert!((0.4..0.7).contains(&share), "{share}");
        for (outer, colours) in RINGS {
            let found = |turn: f32| pane(outer - 2.0 * LEAD, turn / PETALS * TAU);
            assert!(found(0.25) != [0.0; 3] && colours.contains(&found(0.25)));
        }
    }
}
