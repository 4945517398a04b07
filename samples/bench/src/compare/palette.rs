//! The colours of the plots: one per strategy, fixed by its name, so that it is the same in every
//! plot of every report.
//!
//! The hues are from Okabe and Ito, whose palette people with any colour vision can distinguish,
//! with lightnesses that keep contrast on the background; variants of one method share its hue and
//! differ by dashes and hollow dots. A picture is drawn in the light colours, and its style sheet
//! exchanges them where the reader's system is dark.

use plotters::style::RGBColor;

/// A colour on a light and on a dark background, as 0xRRGGBB; the light ones are unique.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour {
    light: u32,
    dark: u32,
}

const fn colour(light: u32, dark: u32) -> Colour {
    Colour { light, dark }
}

/// The background.
pub const BACKGROUND: Colour = colour(0xFF_FF_FF, 0x14_18_1D);
/// Text, and marks that must be seen first.
pub const INK: Colour = colour(0x1F_23_28, 0xE8_EC_F0);
/// Less prominent text: units, ticks.
pub const FAINT: Colour = colour(0x5B_64_6E, 0x9A_A4_AF);
/// Lines of the grid.
pub const GRID: Colour = colour(0xE4_E7_EB, 0x2B_32_3A);
/// Goals.
pub const GOAL: Colour = colour(0x1F_23_29, 0xE8_EC_F1);

/// The name, colour and dashes (empty: a solid line) of the known strategies.
const STRATEGIES: [(&str, Colour, &str); 12] = [
    ("frustum", colour(0x7A_7A_7A, 0xA0_A0_A0), ""),
    ("naive", colour(0x8A_5A_2B, 0xC4_96_66), ""),
    ("batched", colour(0x8A_5A_2C, 0xC4_96_67), "9 7"),
    ("next_frame", colour(0x2E_93_CC, 0x6F_C3_F2), ""),
    ("stop_and_wait", colour(0xB8_5C_93, 0xE0_92_BF), ""),
    ("chc", colour(0x00_8A_65, 0x2F_C4_9B), ""),
    ("hzb", colour(0x00_5C_9E, 0x4D_9D_E0), ""),
    ("antumbra", colour(0xD5_4A_00, 0xFF_7A_33), ""),
    ("antumbra_queries", colour(0xC8_86_00, 0xF0_B3_36), "14 6"),
    ("antumbra_flags", colour(0xC8_86_01, 0xF0_B3_37), "5 6"),
    ("antumbra_compute", colour(0xC8_86_02, 0xF0_B3_38), "14 5 3 5"),
    ("ideal", colour(0x1F_23_2A, 0xE8_EC_F2), "4 7"),
];
/// The colour of a strategy that is not in this list.
const OTHER: Colour = colour(0x6A_51_A3, 0xA9_95_DB);

impl Colour {
    /// Returns the colour to draw with.
    pub fn rgb(self) -> RGBColor {
        let [_, red, green, blue] = self.light.to_be_bytes();
        RGBColor(red, green, blue)
    }

    /// Returns the colour as SVG writes it: "#RRGGBB".
    pub fn light_hex(self) -> String {
        format!("#{:06X}", self.light)
    }

    /// Returns the same on a dark background.
    pub fn dark_hex(self) -> String {
        format!("#{:06X}", self.dark)
    }
}

/// Returns the colour of a strategy.
pub fn of_strategy(name: &str) -> Colour {
    let known = STRATEGIES.iter().find(|(known, ..)| *known == name);
    known.map_or(OTHER, |(_, colour, _)| *colour)
}

/// Returns true for a strategy whose line is dashed; its dots are hollow.
pub fn is_dashed(name: &str) -> bool {
    STRATEGIES.iter().any(|(known, _, dashes)| *known == name && !dashes.is_empty())
}

/// Returns the names of the strategies that have a colour of their own.
pub fn names() -> impl Iterator<Item = &'static str> {
    STRATEGIES.iter().map(|(name, ..)| *name)
}

/// Returns the place of a strategy in legends and bars: in the order of the list above, others
/// last.
pub fn place_of(name: &str) -> usize {
    STRATEGIES.iter().position(|(known, ..)| *known == name).unwrap_or(STRATEGIES.len())
}

fn all() -> impl Iterator<Item = Colour> {
    let inks = [BACKGROUND, INK, FAINT, GRID, GOAL, OTHER];
    STRATEGIES.iter().map(|(_, colour, _)| *colour).chain(inks)
}

/// Returns the style sheet of a picture: dashes, fonts, and the dark colours instead of the light
/// ones.
pub fn style_sheet() -> String {
    let mut css = "text{font-family:system-ui,-apple-system,'Segoe UI',Roboto,'Liberation Sans',\
                   'DejaVu Sans',sans-serif}polyline{stroke-linejoin:round;stroke-linecap:round}"
        .to_owned();
    for (_, colour, dashes) in STRATEGIES.iter().filter(|(.., dashes)| !dashes.is_empty()) {
        let light = colour.light_hex();
        css.push_str(&format!("polyline[stroke=\"{light}\"]{{stroke-dasharray:{dashes}}}"));
    }
    // Text keeps clear of lines that pass below it.
    let light = BACKGROUND.light_hex();
    let dark = BACKGROUND.dark_hex();
    css.push_str(&format!(
        "text{{paint-order:stroke;stroke:{light};stroke-width:4px;stroke-linejoin:round}}"
    ));
    css.push_str(&format!("@media(prefers-color-scheme:dark){{text{{stroke:{dark}}}"));
    for colour in all() {
        let light = colour.light_hex();
        let dark = colour.dark_hex();
        css.push_str(&format!(
            "[fill=\"{light}\"]{{fill:{dark}}}[stroke=\"{light}\"]{{stroke:{dark}}}"
        ));
    }
    css + "}"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategy::strategies;

    #[test]
    fn every_strategy_of_the_engine_has_its_colour() {
        for strategy in strategies() {
            assert_ne!(of_strategy(strategy.name()), OTHER, "{strategy}");
        }
        assert_eq!(of_strategy("brand_new"), OTHER);
    }

    #[test]
    fn light_colours_tell_everything_apart() {
        let mut light: Vec<u32> = all().map(|colour| colour.light).collect();
        let count = light.len();
        light.sort_unstable();
        light.dedup();
        assert_eq!(light.len(), count, "the dark ones are found by them");
    }

    /// Returns the relative luminance as WCAG 2 defines it.
    fn luminance(colour: u32) -> f64 {
        let [_, channels @ ..] = colour.to_be_bytes();
        let linear = |channel: u8| {
            let value = f64::from(channel) / 255.0;
            if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        let [red, green, blue] = channels.map(linear);
        0.2126 * red + 0.7152 * green + 0.0722 * blue
    }

    fn contrast(a: u32, b: u32) -> f64 {
        let a = luminance(a);
        let b = luminance(b);
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn lines_and_text_stand_out_on_both_backgrounds() {
        for (name, colour, _) in STRATEGIES {
            assert!(contrast(colour.light, BACKGROUND.light) >= 3.0, "{name}, light");
            assert!(contrast(colour.dark, BACKGROUND.dark) >= 3.0, "{name}, dark");
        }
        for text in [INK, FAINT] {
            assert!(contrast(text.light, BACKGROUND.light) >= 4.5);
            assert!(contrast(text.dark, BACKGROUND.dark) >= 4.5);
        }
    }
}
