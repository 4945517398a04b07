//! Legends: the meanings of the colours in an image.

use bench::legend::LegendEntry;
use epaint::{Color32, Pos2, Rect, pos2, vec2};

use super::canvas::{HudCanvas, TextAlign};
use super::page::Legend;
use super::style::{MARGIN, NAME, Style, VALUE};

const TITLE: Style = Style::text(11.5, VALUE);
const MEANING: Style = Style::text(11.0, NAME);
/// The width of one colour, and of each colour of a scale.
const SWATCH: f32 = 14.0;
const STEP: f32 = 5.0;
const HEIGHT: f32 = 8.0;
const GAP: f32 = 5.0;

/// Draws one legend: in the upper left of its area, or in the upper right of the image below
/// `top`. Returns its area, or `None` where it has no room.
pub fn draw(
    canvas: &mut HudCanvas<'_>,
    legend: &Legend,
    top: f32,
    left_bound: f32,
) -> Option<Rect> {
    let rows = legend.entries.iter();
    let widths = rows.map(|entry| swatch(entry) + GAP + canvas.width(&entry.meaning, MEANING));
    let widths: Vec<f32> = widths.collect();
    let title = canvas.width(legend.title, TITLE);
    let width = widths.into_iter().fold(title, f32::max) + 2.0 * MARGIN;
    let row = canvas.row(MEANING);
    let height = canvas.row(TITLE) + row * legend.entries.len() as f32 + MARGIN;
    let size = vec2(width, height);
    let scale = canvas.scale;
    let within = match legend.area {
        Some(area) => {
            let [origin, size] = [area.origin, area.size].map(|it| it.map(|it| it as f32 / scale));
            Rect::from_min_size(Pos2::from(origin), size.into())
        }
        None => Rect::from_min_max(pos2(left_bound, top), canvas.screen.max),
    };
    if size.x > within.width() || size.y > within.height() {
        return None;
    }
    let corner = match legend.area {
        Some(_) => within.min,
        None => pos2(within.max.x - size.x, top),
    };
    let area = Rect::from_min_size(corner, size);
    let panel = canvas.open_panel();
    canvas.close_panel(panel, area);
    let left = corner.x + MARGIN;
    let at = pos2(left, corner.y + MARGIN * 0.5);
    let mut y = canvas.text(at, TextAlign::Left, legend.title, TITLE).max.y;
    for entry in &legend.entries {
        colours(canvas, entry, pos2(left, y + (row - HEIGHT) * 0.5));
        let at = pos2(left + swatch(entry) + GAP, y);
        canvas.text(at, TextAlign::Left, &entry.meaning, MEANING);
        y += row;
    }
    Some(area)
}

fn colours(canvas: &mut HudCanvas<'_>, entry: &LegendEntry, corner: Pos2) {
    let step = swatch(entry) / entry.colours.len().max(1) as f32;
    for (place, [red, green, blue]) in entry.colours.iter().copied().enumerate() {
        let at = corner + vec2(place as f32 * step, 0.0);
        let colour = Color32::from_rgb(red, green, blue);
        canvas.fill(Rect::from_min_size(at, vec2(step, HEIGHT)), colour);
    }
}

/// Returns the width of an entry's colours.
fn swatch(entry: &LegendEntry) -> f32 {
    SWATCH.max(entry.colours.len() as f32 * STEP)
}
