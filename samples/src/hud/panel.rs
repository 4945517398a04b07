//! Panels: contents on a dark background that are placed as a whole.

use egui::{Align, Align2, Frame, Label, Layout, Margin, Rect, Ui, UiBuilder, Vec2, WidgetText};

use super::style::PANEL;

/// The margins of a panel: left and right, and top and bottom.
pub const MARGINS: [i8; 2] = [8, 6];

/// Shows `contents` on a panel at an edge or corner of `room`; larger contents extend beyond it.
/// Returns the panel's area.
pub fn show(ui: &mut Ui, room: Rect, place: Align2, contents: impl Fn(&mut Ui)) -> Rect {
    let size = measure(ui, room.size(), &contents);
    show_at(ui, place.align_size_within_rect(size, room), room.size(), contents)
}

/// Shows a panel like [`show`] if it fits as a whole without overlapping `taken`.
pub fn show_if_fits(
    ui: &mut Ui,
    room: Rect,
    place: Align2,
    taken: Rect,
    contents: impl Fn(&mut Ui),
) -> Option<Rect> {
    let size = measure(ui, room.size(), &contents);
    let area = place.align_size_within_rect(size, room);
    let fits = size.x <= room.width() && size.y <= room.height() && !area.intersects(taken);
    fits.then(|| show_at(ui, area, room.size(), contents))
}

/// Shows a text in one row, with an ellipsis if it does not fit.
pub fn row(ui: &mut Ui, text: impl Into<WidgetText>) {
    ui.add(Label::new(text).truncate());
}

/// Returns the size of a panel with `contents` that may use all of `room`.
fn measure(ui: &mut Ui, room: Vec2, contents: impl Fn(&mut Ui)) -> Vec2 {
    let area = Rect::from_min_size(ui.max_rect().min, room);
    let mut tried = ui.new_child(builder(area).invisible());
    draw(&mut tried, contents).size()
}

/// Shows a panel that was measured to be as large as `area`, laid out as if it had `room`.
fn show_at(ui: &mut Ui, area: Rect, room: Vec2, contents: impl Fn(&mut Ui)) -> Rect {
    let mut shown = ui.new_child(builder(Rect::from_min_size(area.min, room)));
    draw(&mut shown, contents)
}

fn builder(area: Rect) -> UiBuilder {
    UiBuilder::new().max_rect(area).layout(Layout::top_down(Align::Min))
}

fn draw(ui: &mut Ui, contents: impl Fn(&mut Ui)) -> Rect {
    let [sides, ends] = MARGINS;
    let frame = Frame::new().fill(PANEL).inner_margin(Margin::symmetric(sides, ends));
    frame.show(ui, |ui| contents(ui)).response.rect
}
