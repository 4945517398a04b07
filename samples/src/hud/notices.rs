//! The lower edge: the answer to a request, and below it the newest message or the progress of
//! loading.

use egui::{Align2, Label, Rect, Sense, Ui, pos2, vec2};

use super::choices;
use super::page::{HudAnswer, HudPage};
use super::panel::{self, row};
use super::style::{DIM, GOOD, MARGIN, MARK, Style};

const TEXT: Style = Style::text(13.0, MARK);
/// The style of rows, monospaced so that numbers and marks are aligned.
const ROWS: Style = Style::number(11.5, MARK);
const BAR: [f32; 2] = [320.0, 10.0];

/// The result of showing the lower edge.
pub struct Notices {
    /// The remaining room above.
    pub above: Rect,
    /// The area that is taken.
    pub taken: Rect,
    /// The area of a list.
    pub list: Option<Rect>,
    /// The index of the clicked row of a list.
    pub clicked: Option<usize>,
}

impl Default for Notices {
    fn default() -> Self {
        Self { above: Rect::NOTHING, taken: Rect::NOTHING, list: None, clicked: None }
    }
}

/// Shows the lower edge of `room`.
pub fn show(ui: &mut Ui, page: &HudPage, room: Rect) -> Notices {
    // A row is always reserved, so that a message moves nothing.
    let row = ui.fonts_mut(|fonts| fonts.row_height(&TEXT.font()));
    let mut rest = room.shrink(MARGIN);
    let lowest = match (&page.progress, &page.toast) {
        (Some((what, fraction)), _) => Some(progress(ui, what, *fraction, rest)),
        (None, Some(text)) => Some(message(ui, text, TEXT, rest)),
        (None, None) => None,
    };
    rest.max.y = lowest.map_or(rest.max.y, |area| area.min.y - MARGIN);
    let mut clicked = None;
    let list = match &page.asked {
        Some(HudAnswer::List(list)) => Some(choices::show(ui, list, rest, &mut clicked)),
        _ => None,
    };
    let asked = match &page.asked {
        Some(HudAnswer::Rows(text)) => Some(message(ui, text, ROWS, rest)),
        _ => list,
    };
    rest.max.y = asked.map_or(rest.max.y, |area| area.min.y - MARGIN);
    let reserved = room.max.y - row - 4.0 * MARGIN;
    let above = Rect { min: room.min, max: pos2(room.max.x, rest.max.y.min(reserved)) };
    let taken = [lowest, asked].into_iter().flatten().fold(Rect::NOTHING, Rect::union);
    Notices { above, taken, list, clicked }
}

/// Shows a text in the lower left. Returns its area.
fn message(ui: &mut Ui, text: &str, style: Style, room: Rect) -> Rect {
    panel::show(ui, room, Align2::LEFT_BOTTOM, |ui| {
        ui.add(Label::new(style.of(text)).wrap());
    })
}

/// Shows a progress bar below the name of the step. Returns their area.
fn progress(ui: &mut Ui, what: &str, fraction: Option<f32>, room: Rect) -> Rect {
    panel::show(ui, room, Align2::LEFT_BOTTOM, |ui| {
        ui.set_max_width(BAR[0].min(ui.available_width()));
        row(ui, TEXT.of(what));
        ui.add_space(MARGIN);
        let size = vec2(ui.available_width(), BAR[1]);
        let (bar, _) = ui.allocate_exact_size(size, Sense::hover());
        ui.painter().rect_filled(bar, 0.0, DIM);
        let done = fraction.unwrap_or_default().clamp(0.0, 1.0);
        let part = vec2(bar.width() * done, bar.height());
        ui.painter().rect_filled(Rect::from_min_size(bar.min, part), 0.0, GOOD);
    })
}
