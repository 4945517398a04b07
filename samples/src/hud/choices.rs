//! A list to choose from, with keys or the mouse.

use std::ops::Range;
use std::sync::Arc;

use egui::{Align2, Galley, Label, Pos2, Rect, Sense, Ui, pos2, vec2};

use super::page::ChoiceList;
use super::panel;
use super::style::{MARK, NAME, SELECTED, Style, VALUE};

const TITLE: Style = Style::text(12.0, NAME);
const NUMBER: Style = Style::number(11.5, NAME);
const LABEL: Style = Style::number(11.5, VALUE);
const ABOUT: Style = Style::text(11.5, NAME);
/// The space between columns, and around the letters of a row.
const GAP: f32 = 8.0;
const PADDING: f32 = 1.0;
/// The space below the title.
const TITLE_GAP: f32 = 3.0;
/// The least width of the descriptions of rows.
const ABOUT_WIDTH: f32 = 60.0;

/// The laid-out texts of a row.
struct Row {
    number: Arc<Galley>,
    label: Arc<Galley>,
    about: Arc<Galley>,
}

impl Row {
    fn height(&self) -> f32 {
        self.label.size().y.max(self.about.size().y) + 2.0 * PADDING
    }
}

/// Shows the list in the lower left of `room`, or as many rows around the selected one as fit.
/// Returns its area, and stores the index of a clicked row in `clicked`.
pub fn show(ui: &mut Ui, list: &ChoiceList, room: Rect, clicked: &mut Option<usize>) -> Rect {
    let [sides, ends] = panel::MARGINS.map(f32::from);
    let width = room.width() - 2.0 * sides;
    let rows = rows(ui, list, width);
    let line = ui.fonts_mut(|fonts| fonts.row_height(&TITLE.font()));
    let title = ui.painter().layout(list.title.clone(), TITLE.font(), TITLE.colour, width);
    let heights: Vec<f32> = rows.iter().map(Row::height).collect();
    let height = room.height() - 2.0 * ends - title.size().y - TITLE_GAP;
    let shown = if heights.iter().sum::<f32>() <= height {
        0..rows.len()
    } else {
        window(&heights, list.selected, height - 2.0 * line)
    };
    let chosen = std::cell::Cell::new(None);
    let area = panel::show(ui, room, Align2::LEFT_BOTTOM, |ui| {
        ui.add(Label::new(TITLE.of(&list.title)).wrap());
        ui.add_space(TITLE_GAP);
        let columns = columns(&rows);
        let more = |ui: &mut Ui, count: usize, place: &str| {
            if count > 0 {
                ui.label(TITLE.of(format!("... {count} more {place}")));
            }
        };
        more(ui, shown.start, "above");
        for place in shown.clone() {
            let size = vec2(columns[2], heights[place]);
            let (area, response) = ui.allocate_exact_size(size, Sense::click());
            let is_selected = place == list.selected;
            if is_selected || response.hovered() {
                ui.painter().rect_filled(area.expand2(vec2(4.0, 0.0)), 2.0, SELECTED);
            }
            if response.clicked() {
                chosen.set(Some(place));
            }
            draw(ui, &rows[place], area.min, columns, is_selected);
        }
        more(ui, rows.len() - shown.end, "below");
    });
    *clicked = chosen.get();
    area
}

/// Returns the texts of all rows, in columns with a total width of `width`.
fn rows(ui: &Ui, list: &ChoiceList, width: f32) -> Vec<Row> {
    let text = |text: String, style: Style, width: f32| {
        ui.painter().layout(text, style.font(), style.colour, width)
    };
    // Numbers of two digits cannot be typed with one key.
    let number = |place: usize| if place < 9 { (place + 1).to_string() } else { " ".to_owned() };
    let first = list.rows.iter().enumerate().map(|(place, (label, _))| Row {
        number: text(number(place), NUMBER, f32::INFINITY),
        label: text(label.clone(), LABEL, (width - 20.0).max(1.0)),
        about: text(String::new(), ABOUT, f32::INFINITY),
    });
    let mut rows: Vec<Row> = first.collect();
    let [_, left, _] = columns(&rows);
    for (row, (_, about)) in rows.iter_mut().zip(&list.rows) {
        row.about = text(about.clone(), ABOUT, (width - left).max(ABOUT_WIDTH));
    }
    rows
}

/// Returns the left edges of names and descriptions, and the total width.
fn columns(rows: &[Row]) -> [f32; 3] {
    let widest =
        |of: fn(&Row) -> &Galley| rows.iter().map(|row| of(row).size().x).fold(0.0, f32::max);
    let label = widest(|row| &row.number) + GAP;
    let about = label + widest(|row| &row.label) + GAP;
    [label, about, about + widest(|row| &row.about)]
}

fn draw(ui: &Ui, row: &Row, corner: Pos2, widths: [f32; 3], is_selected: bool) {
    let [label, about, _] = widths;
    let top = corner.y + PADDING;
    let painter = ui.painter();
    painter.galley(pos2(corner.x, top), Arc::clone(&row.number), NUMBER.colour);
    let at = pos2(corner.x + label, top);
    if is_selected {
        painter.galley_with_override_text_color(at, Arc::clone(&row.label), MARK)
    } else {
        painter.galley(at, Arc::clone(&row.label), LABEL.colour)
    }
    painter.galley(pos2(corner.x + about, top), Arc::clone(&row.about), ABOUT.colour);
}

/// Returns the shown rows of a list that is higher than `room`: the selected row, and as many rows
/// around it as fit.
fn window(heights: &[f32], selected: usize, room: f32) -> Range<usize> {
    let selected = selected.min(heights.len().saturating_sub(1));
    let mut shown = selected..(selected + 1).min(heights.len());
    let mut left = room - heights.get(selected).copied().unwrap_or_default();
    loop {
        let above = shown.start.checked_sub(1).filter(|place| heights[*place] <= left);
        let below = Some(shown.end)
            .filter(|place| heights.get(*place).is_some_and(|height| *height <= left));
        match (above, below) {
            // The selected row stays in the middle while there are rows on both sides.
            (Some(above), below) if below.is_none() || selected - above <= shown.end - selected => {
                left -= heights[above];
                shown.start = above;
            }
            (_, Some(below)) => {
                left -= heights[below];
                shown.end = below + 1;
            }
            (_, None) => return shown,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_selected_row_is_among_those_that_have_room() {
        for count in 1..30 {
            let heights: Vec<f32> = (0..count).map(|place| 10.0 + (place % 3) as f32).collect();
            for selected in 0..count {
                for room in [0.0, 11.0, 50.0, 100.0, 1e4] {
                    let shown = window(&heights, selected, room);
                    assert!(shown.contains(&selected), "{shown:?} {selected} {room}");
                    let height: f32 = heights[shown.clone()].iter().sum();
                    assert!(height <= room || shown.len() == 1, "{shown:?} {room}");
                    let is_full =
                        |place: Option<&f32>| place.is_none_or(|place| height + place > room);
                    assert!(is_full(heights.get(shown.end)), "{shown:?} {room}");
                    assert!(shown.start == 0 || is_full(heights.get(shown.start - 1)));
                }
            }
        }
    }
}
