//! The colours that explain images: a family of hues for each kind of meaning, so that kinds are
//! not confused. States have the hues of Okabe and Ito, which differ for any colour vision; levels
//! have one hue of rising lightness; the frustum is white.

use glam::Vec4;

/// A colour with one meaning in explained images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swatch {
    /// Its meaning, for a legend.
    pub meaning: &'static str,
    /// The colour, sRGB-encoded.
    pub rgb: [u8; 3],
    /// Its opacity, from 0 to 1.
    alpha: f32,
}

/// The colour of a box that was hidden when it was last tested.
pub const BOX_HIDDEN: Swatch = Swatch { meaning: "was hidden", rgb: [86, 180, 233], alpha: 0.9 };
/// The colour of a box that shares the test of a box in front of it.
pub const BOX_BEHIND: Swatch =
    Swatch { meaning: "behind another tested box", rgb: [204, 121, 167], alpha: 0.8 };
/// The colour of a box that was never tested.
pub const BOX_UNKNOWN: Swatch = Swatch { meaning: "never tested", rgb: [240, 228, 66], alpha: 0.9 };
/// The colour of a box that was visible when it was last tested.
pub const BOX_SHOWED: Swatch = Swatch { meaning: "was visible", rgb: [213, 94, 0], alpha: 0.9 };
/// The colour of the edges of a view's frustum.
pub const FRUSTUM: Swatch =
    Swatch { meaning: "the camera's frustum", rgb: [255, 255, 255], alpha: 1.0 };
/// The colour of the edges of triangles of visible leaves, as in `wireframe.frag`.
pub const WIREFRAME: Swatch =
    Swatch { meaning: "triangles taken as visible", rgb: [50, 240, 190], alpha: 1.0 };

/// The colour of the outline of the selected object.
pub const SELECTED: Swatch =
    Swatch { meaning: "the selected object", rgb: [150, 255, 30], alpha: 1.0 };

/// The colours of depth complexity, as `depth_complexity.frag` adds them up.
pub const LAYERS: [Swatch; 4] = [
    Swatch { meaning: "1 surface", rgb: layer_colour(1), alpha: 1.0 },
    Swatch { meaning: "8", rgb: layer_colour(8), alpha: 1.0 },
    Swatch { meaning: "32", rgb: layer_colour(32), alpha: 1.0 },
    Swatch { meaning: "128 or more", rgb: layer_colour(128), alpha: 1.0 },
];

/// Returns the colour of a pixel with this number of surfaces, sRGB-encoded. The blue channel rises
/// by two per surface, which identifies each number up to 127.
pub const fn layer_colour(surfaces: u32) -> [u8; 3] {
    const fn part(surfaces: u32, step: u32) -> u8 {
        let sum = surfaces.saturating_mul(step);
        if sum > 255 { 255 } else { sum as u8 }
    }
    [part(surfaces, 32), part(surfaces, 8), part(surfaces, 2)]
}

/// The deepest level with a colour of its own, which all levels below it share.
const DEEPEST_LEVEL: u32 = 15;
const COARSE: [f32; 3] = [98.0, 52.0, 196.0];
const FINE: [f32; 3] = [206.0, 184.0, 255.0];

/// Returns the colour of boxes of a level of the hierarchy. The root has level 0.
pub fn level_colour(level: u32) -> Swatch {
    let share = level.min(DEEPEST_LEVEL) as f32 / DEEPEST_LEVEL as f32;
    let part = |part: usize| (COARSE[part] + (FINE[part] - COARSE[part]) * share).round() as u8;
    let rgb = [part(0), part(1), part(2)];
    Swatch { meaning: "hidden, coarse to fine", rgb, alpha: 0.9 }
}

impl Swatch {
    /// Returns the colour as linear light, with the opacity.
    pub(crate) fn linear(&self) -> Vec4 {
        let light = |encoded: u8| {
            let encoded = f32::from(encoded) / 255.0;
            if encoded <= 0.040_45 {
                encoded / 12.92
            } else {
                ((encoded + 0.055) / 1.055).powf(2.4)
            }
        };
        let [red, green, blue] = self.rgb.map(light);
        Vec4::new(red, green, blue, self.alpha)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATES: [Swatch; 4] = [BOX_HIDDEN, BOX_BEHIND, BOX_UNKNOWN, BOX_SHOWED];

    /// Returns the hue in degrees; `None` for a grey.
    fn hue(Swatch { rgb, .. }: Swatch) -> Option<f32> {
        let [red, green, blue] = rgb.map(f32::from);
        let most = red.max(green).max(blue);
        let least = red.min(green).min(blue);
        let range = most - least;
        if range < 8.0 {
            return None;
        }
        let sixth = match most {
            _ if most == red => ((green - blue) / range).rem_euclid(6.0),
            _ if most == green => (blue - red) / range + 2.0,
            _ => (red - green) / range + 4.0,
        };
        Some(sixth * 60.0)
    }

    #[test]
    fn states_levels_and_wireframes_share_no_hue() {
        let levels: Vec<f32> = (0..20).filter_map(|level| hue(level_colour(level))).collect();
        assert_eq!(levels.len(), 20, "every level has a hue");
        for state in STATES.into_iter().chain([WIREFRAME, SELECTED]) {
            let of_state = hue(state).unwrap();
            let others = STATES.into_iter().filter(|_| !STATES.contains(&state)).filter_map(hue);
            for level in levels.iter().copied().chain(others) {
                let apart = (of_state - level).abs();
                let apart = apart.min(360.0 - apart);
                assert!(apart >= 30.0, "{}: {of_state} and {level}", state.meaning);
            }
        }
        assert_eq!(hue(FRUSTUM), None);
    }

    /// Checks the hues as seen without one kind of cones (Vienot, Brettel and Mollon, 1999).
    #[test]
    fn states_are_told_apart_with_any_colour_vision() {
        let deutan =
            [[0.292_75, 0.707_25, 0.0], [0.292_75, 0.707_25, 0.0], [-0.022_34, 0.022_34, 1.0]];
        let protan =
            [[0.112_38, 0.887_62, 0.0], [0.112_38, 0.887_62, 0.0], [0.004_01, -0.004_01, 1.0]];
        let plain = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (eyes, name) in [(plain, "all"), (deutan, "deutan"), (protan, "protan")] {
            let seen = |swatch: Swatch| {
                let light = swatch.linear().truncate().to_array();
                eyes.map(|row: [f32; 3]| {
                    let sum: f32 = row.iter().zip(light).map(|(weight, part)| weight * part).sum();
                    sum.max(0.0).powf(1.0 / 2.2) * 255.0
                })
            };
            for (place, one) in STATES.into_iter().enumerate() {
                for other in STATES.into_iter().skip(place + 1) {
                    let parts = seen(one).into_iter().zip(seen(other));
                    let apart = parts.map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt();
                    assert!(apart > 50.0, "{name}: {} {}: {apart}", one.meaning, other.meaning);
                }
            }
        }
    }

    #[test]
    fn finer_levels_are_lighter() {
        let light = |level: u32| level_colour(level).linear().truncate().element_sum();
        assert!((0..DEEPEST_LEVEL).all(|level| light(level) < light(level + 1)));
    }
}
