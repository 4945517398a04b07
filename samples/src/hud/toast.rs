//! The lower edge: the answer to a request, and below it the newest message, or the progress of a
//! scene.

use epaint::{Rect, Shape, pos2, vec2};

use super::canvas::{HudCanvas, TextAlign};
use super::page::HudPage;
use super::style::{DIM, GOOD, MARGIN, MARK, Style};

const TEXT: Style = Style::text(13.0, MARK);
/// The style of rows: numbers and marks stand below each other.
const ROWS: Style = Style::number(11.5, MARK);
const BAR: [f32; 2] = [320.0, 10.0];

/// Draws the lower edge from `left` on. Returns its upper end.
pub fn draw(canvas: &mut HudCanvas<'_>, page: &HudPage, left: f32) -> f32 {
    // There is always room for a row, so that a toast moves nothing.
    let reserved = canvas.screen.max.y - canvas.row(TEXT) - 4.0 * MARGIN;
    let bottom = canvas.screen.max.y;
    let lowest = match &page.progress {
        Some((what, fraction)) => Some(progress(canvas, what, *fraction, left)),
        None => page.toast.as_ref().map(|text| toast(canvas, text, TEXT, [left, bottom])),
    };
    let bottom = lowest.map_or(bottom, |area| area.min.y);
    let asked = page.asked.as_ref().map(|text| toast(canvas, text, ROWS, [left, bottom]));
    asked.or(lowest).map_or(reserved, |area| (area.min.y - MARGIN).min(reserved))
}

/// Draws a text with its lower left at the given place. Returns its area.
fn toast(canvas: &mut HudCanvas<'_>, text: &str, style: Style, [left, bottom]: [f32; 2]) -> Rect {
    let widest = canvas.screen.width() - left - 4.0 * MARGIN;
    let galley = canvas.wrapped(text.to_owned(), style, widest);
    let size = galley.size() + vec2(2.0 * MARGIN, 2.0 * MARGIN);
    let corner = pos2(left + MARGIN, (bottom - size.y - MARGIN).max(0.0));
    let area = Rect::from_min_size(corner, size);
    let panel = canvas.open_panel();
    canvas.close_panel(panel, area);
    canvas.add(Shape::galley(corner + vec2(MARGIN, MARGIN), galley, style.colour));
    area
}

/// Draws a bar, and above it the name of the step. Returns their area.
fn progress(canvas: &mut HudCanvas<'_>, what: &str, fraction: Option<f32>, left: f32) -> Rect {
    let screen = canvas.screen;
    let row = canvas.row(TEXT);
    let widest = (screen.width() - left - 4.0 * MARGIN).max(1.0);
    let width = BAR[0].max(canvas.width(what, TEXT)).min(widest);
    let size = vec2(width + 2.0 * MARGIN, row + BAR[1] + 3.0 * MARGIN);
    let corner = pos2(left + MARGIN, (screen.max.y - size.y - MARGIN).max(0.0));
    let area = Rect::from_min_size(corner, size);
    let panel = canvas.open_panel();
    canvas.close_panel(panel, area);
    let at = corner + vec2(MARGIN, MARGIN);
    canvas.text_within(at, TextAlign::Left, width, what, TEXT);
    let bar = Rect::from_min_size(at + vec2(0.0, row + MARGIN), vec2(width, BAR[1]));
    canvas.fill(bar, DIM);
    let done = fraction.unwrap_or_default().clamp(0.0, 1.0);
    canvas.fill(Rect::from_min_size(bar.min, vec2(width * done, BAR[1])), GOOD);
    area
}
