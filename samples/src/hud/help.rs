//! The page of all keys, in several columns.

use egui::{Align, Align2, Layout, Rect, Ui, vec2};

use super::page::Help;
use super::panel;
use super::style::{MARGIN, MARK, NAME, Style, VALUE};

const TITLE: Style = Style::text(13.0, VALUE);
const KEY: Style = Style::number(11.0, MARK);
const WHAT: Style = Style::text(12.0, NAME);
/// The distance between columns.
const GUTTER: f32 = 24.0;

/// A row of a column.
enum Row<'a> {
    Title(&'a str),
    Key(&'a str, &'a str),
    Empty,
}

/// The numbers of columns to try, in order of preference.
const COLUMNS: [usize; 4] = [3, 2, 4, 1];

/// Shows the page in the middle of `room`. Returns its area, or `None` if it does not fit.
pub fn show(ui: &mut Ui, help: &Help, room: Rect) -> Option<Rect> {
    COLUMNS.into_iter().find_map(|count| {
        let columns = columns(help, count);
        panel::show_if_fits(ui, room, Align2::CENTER_CENTER, Rect::NOTHING, |ui| {
            ui.horizontal_top(|ui| {
                ui.spacing_mut().item_spacing.x = GUTTER;
                for rows in &columns {
                    ui.vertical(|ui| column(ui, rows));
                }
            });
        })
    })
}

fn column(ui: &mut Ui, rows: &[Row<'_>]) {
    ui.spacing_mut().item_spacing.x = MARGIN;
    let height = ui.fonts_mut(|fonts| fonts.row_height(&TITLE.font())) + 1.0;
    let width = |key: &str| {
        let galley = ui.painter().layout_no_wrap(key.to_owned(), KEY.font(), KEY.colour);
        galley.size().x
    };
    let keys = rows.iter().map(|row| match row {
        Row::Key(key, _) => width(key),
        Row::Title(_) | Row::Empty => 0.0,
    });
    let keys = keys.fold(0.0, f32::max).ceil();
    for row in rows {
        match row {
            Row::Title(text) => _ = ui.label(TITLE.of(*text)),
            Row::Key(key, action) => {
                ui.horizontal(|ui| {
                    let right = Layout::right_to_left(Align::Center);
                    ui.allocate_ui_with_layout(vec2(keys, height), right, |ui| {
                        ui.label(KEY.of(*key));
                    });
                    ui.label(WHAT.of(*action));
                });
            }
            Row::Empty => ui.add_space(height),
        }
    }
}

/// Returns the groups in at most `most` columns of about equal height; groups are not split.
fn columns(help: &Help, most: usize) -> Vec<Vec<Row<'_>>> {
    let total: usize = help.groups.iter().map(|(_, keys)| keys.len() + 2).sum();
    let even = total.div_ceil(most.max(1));
    let mut columns: Vec<Vec<Row<'_>>> = vec![Vec::new()];
    for (title, keys) in &help.groups {
        let full = columns.last().map_or(0, Vec::len);
        // Exceeding the even height by half a group is better than falling short by a group.
        if full > 0 && columns.len() < most && full + keys.len() / 2 + 1 > even {
            columns.push(Vec::new());
        }
        let Some(column) = columns.last_mut() else { continue };
        if !column.is_empty() {
            column.push(Row::Empty);
        }
        column.push(Row::Title(title));
        column.extend(keys.iter().map(|(key, action)| Row::Key(key, action)));
    }
    columns
}
