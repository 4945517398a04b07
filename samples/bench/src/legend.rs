//! A legend drawn into the pixels of an image: the programs that measure have no head-up display.

use antumbra::render::palette::{FRUSTUM, LAYERS, Swatch, level_colour};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// The title of the legend of the view from above.
pub const TITLE_FROM_ABOVE: &str = "Boxes and the camera";
/// The title of the legend of the depth complexity.
pub const TITLE_OF_LAYERS: &str = "Depth complexity";
/// The levels that stand for the whole colour scale.
const LEVELS: [u32; 6] = [0, 3, 6, 9, 12, 15];

const FONT: (FontWeight, RasterHeight) = (FontWeight::Regular, RasterHeight::Size16);
const ROW: usize = FONT.1.val();
const LETTER: usize = get_raster_width(FONT.0, FONT.1);
/// Space around the text, and between colours and their meaning.
const MARGIN: usize = 8;
/// The width of a single colour, and of each colour of a scale.
const SWATCH: usize = 16;
const STEP: usize = 6;
const PANEL: [u8; 3] = [9, 11, 15];
const TITLE: [u8; 3] = [235, 240, 245];
const MEANING: [u8; 3] = [176, 186, 200];

/// Colours with one meaning: several are a scale from the first to the last.
#[derive(Debug, Clone, PartialEq)]
pub struct LegendEntry {
    /// The colours, sRGB-encoded.
    pub colours: Vec<[u8; 3]>,
    /// The meaning of the colours, in a few words.
    pub meaning: String,
}

impl From<Swatch> for LegendEntry {
    fn from(swatch: Swatch) -> Self {
        Self { colours: vec![swatch.rgb], meaning: swatch.meaning.to_owned() }
    }
}

impl LegendEntry {
    fn swatch_width(&self) -> usize {
        SWATCH.max(self.colours.len() * STEP)
    }

    fn width(&self) -> usize {
        self.swatch_width() + MARGIN + self.meaning.chars().count() * LETTER
    }
}

/// Returns the entries of the view from above.
pub fn from_above() -> Vec<LegendEntry> {
    let levels = LEVELS.map(|level| level_colour(level).rgb).to_vec();
    let meaning = level_colour(0).meaning.to_owned();
    vec![LegendEntry { colours: levels, meaning }, FRUSTUM.into()]
}

/// Returns the entries of the depth complexity.
pub fn layers() -> Vec<LegendEntry> {
    LAYERS.map(Into::into).to_vec()
}

/// Draws a legend into the upper right of an image of RGBA pixels, `width` per row. Draws nothing
/// if it does not fit.
pub fn draw(rgba8: &mut [u8], width: usize, title: &str, entries: &[LegendEntry]) {
    let rows = rgba8.as_chunks_mut::<4>().0;
    let height = rows.len().checked_div(width).unwrap_or(0);
    let widths = entries.iter().map(LegendEntry::width);
    let inner = widths.fold(title.chars().count() * LETTER, usize::max);
    let across = inner + 2 * MARGIN;
    let down = ROW * (entries.len() + 1) + MARGIN;
    if across > width || down > height {
        return;
    }
    let mut canvas = Canvas { pixels: rows, width };
    let left = width - across;
    canvas.fill([left, 0], [across, down], PANEL);
    let left = left + MARGIN;
    canvas.text([left, MARGIN / 2], title, TITLE);
    for (entry, top) in entries.iter().zip((MARGIN / 2 + ROW..).step_by(ROW)) {
        let step = entry.swatch_width() / entry.colours.len().max(1);
        for (colour, x) in entry.colours.iter().zip((left..).step_by(step)) {
            canvas.fill([x, top + ROW / 4], [step, ROW / 2], *colour);
        }
        canvas.text([left + entry.swatch_width() + MARGIN, top], &entry.meaning, MEANING);
    }
}

/// Pixels to draw on.
struct Canvas<'a> {
    pixels: &'a mut [[u8; 4]],
    width: usize,
}

impl Canvas<'_> {
    fn fill(&mut self, corner: [usize; 2], size: [usize; 2], colour: [u8; 3]) {
        let [left, top] = corner;
        let [width, height] = size;
        for y in top..top + height {
            (left..left + width).for_each(|x| self.blend([x, y], colour, u8::MAX));
        }
    }

    fn text(&mut self, corner: [usize; 2], text: &str, colour: [u8; 3]) {
        let [left, top] = corner;
        for (letter, left) in text.chars().zip((left..).step_by(LETTER)) {
            let Some(raster) = get_raster(letter, FONT.0, FONT.1) else { continue };
            for (row, y) in raster.rows().zip(top..) {
                for (share, x) in row.iter().zip(left..) {
                    self.blend([x, y], colour, *share);
                }
            }
        }
    }

    fn blend(&mut self, place: [usize; 2], colour: [u8; 3], share: u8) {
        let [x, y] = place;
        let Some(pixel) = self.pixels.get_mut(y * self.width + x) else { return };
        let share = u32::from(share);
        for (part, new) in pixel.iter_mut().zip(colour) {
            let mixed = u32::from(*part) * (255 - share) + u32::from(new) * share;
            *part = (mixed / 255) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_legend_has_its_colours_in_the_upper_right_where_it_has_room() {
        let width = 1280;
        let height = 90;
        let entries = from_above();
        let mut image = vec![100; width * height * 4];
        draw(&mut image, width, TITLE_FROM_ABOVE, &entries);
        let pixels = image.as_chunks::<4>().0;
        for colour in entries.iter().flat_map(|entry| &entry.colours) {
            let place = pixels.iter().position(|[rgb @ .., _]| rgb == colour);
            assert!(place.is_some_and(|place| place % width > width / 2), "{colour:?}");
        }
        let is_bright = |[rgb @ .., _]: &&[u8; 4]| rgb.iter().all(|part| *part > 150);
        let letters = pixels[..width * ROW].iter().filter(is_bright).count();
        assert!(letters > 50, "{letters} pixels of a title");
        assert!(pixels.iter().all(|[.., alpha]| *alpha == 100));
        for (width, height) in [(100, 90), (1280, 20), (0, 0)] {
            let mut small = vec![255; width * height * 4];
            draw(&mut small, width, TITLE_FROM_ABOVE, &entries);
            assert!(small.iter().all(|part| *part == 255), "{width}x{height}");
        }
    }
}
