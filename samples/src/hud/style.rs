//! Colours and fonts of the HUD. The colours of text keep their contrast on a panel over white.

use egui::{Color32, FontFamily, FontId, RichText};

/// The space between texts and edges, in points.
pub const MARGIN: f32 = 8.0;
/// The background of all text. It is nearly opaque, since blending is linear and bright scenes
/// would shine through.
pub const PANEL: Color32 = Color32::from_rgba_premultiplied(9, 11, 15, 246);
/// Names and units.
pub const NAME: Color32 = Color32::from_rgb(176, 186, 200);
/// Values without a judgement.
pub const VALUE: Color32 = Color32::from_rgb(235, 240, 245);
/// Values that meet their target.
pub const GOOD: Color32 = Color32::from_rgb(86, 196, 150);
/// Values that exceed their budget, or may be wrong.
pub const BAD: Color32 = Color32::from_rgb(245, 130, 80);
/// Keys, toasts and marks.
pub const MARK: Color32 = Color32::from_rgb(250, 210, 90);
/// The background of the selected row and of the row below the pointer.
pub const SELECTED: Color32 = Color32::from_rgb(28, 46, 70);
/// Lines of a scale, and the remainder of a bar.
pub const DIM: Color32 = Color32::from_rgb(84, 94, 110);

/// The look of a text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// The height of the letters, in points.
    pub points: f32,
    /// The colour of the letters.
    pub colour: Color32,
    /// The widths of the letters.
    pub family: Family,
}

/// The widths of letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Each letter has its own width.
    Proportional,
    /// All letters have the same width, as in columns of numbers.
    Monospace,
}

impl Style {
    /// Returns a style of proportional letters.
    pub const fn text(points: f32, colour: Color32) -> Self {
        Self { points, colour, family: Family::Proportional }
    }

    /// Returns a style of monospaced letters.
    pub const fn number(points: f32, colour: Color32) -> Self {
        Self { points, colour, family: Family::Monospace }
    }

    /// Returns a text in this style.
    pub fn of(self, text: impl Into<String>) -> RichText {
        RichText::new(text).font(self.font()).color(self.colour)
    }

    /// Returns the font.
    pub fn font(self) -> FontId {
        let family = match self.family {
            Family::Proportional => FontFamily::Proportional,
            Family::Monospace => FontFamily::Monospace,
        };
        FontId::new(self.points, family)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the linear light of an encoded channel.
    fn light(encoded: f64) -> f64 {
        if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
    }

    /// Returns the relative luminance of a colour over white, blended in linear light as on the
    /// GPU.
    fn luminance(colour: Color32) -> f64 {
        let [red, green, blue, alpha] = colour.to_array().map(|part| f64::from(part) / 255.0);
        let part = |encoded: f64| light(encoded / alpha) * alpha + (1.0 - alpha);
        0.2126 * part(red) + 0.7152 * part(green) + 0.0722 * part(blue)
    }

    #[test]
    fn text_can_be_read_over_a_white_scene() {
        for ground in [PANEL, SELECTED] {
            for (colour, name) in
                [(NAME, "name"), (VALUE, "value"), (GOOD, "good"), (BAD, "bad"), (MARK, "mark")]
            {
                let contrast = (luminance(colour) + 0.05) / (luminance(ground) + 0.05);
                assert!(contrast >= 4.5, "{name}: {contrast:.1}, WCAG 2 asks for 4.5");
            }
        }
    }
}
