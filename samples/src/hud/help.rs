//! The page with all keys, in as many columns as it takes.

use epaint::{Rect, pos2, vec2};

use super::canvas::{HudCanvas, TextAlign};
use super::page::Help;
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

/// The numbers of columns to try, the best first.
const COLUMNS: [usize; 4] = [3, 2, 4, 1];

/// Draws the page in the middle of the image, above `bottom`. Returns its area, or `None` where
/// it has no room.
pub fn draw(canvas: &mut HudCanvas<'_>, help: &Help, bottom: f32) -> Option<Rect> {
    let row = canvas.row(TITLE) + 1.0;
    let room = vec2(canvas.screen.width(), bottom);
    let (columns, widths, size) = COLUMNS.into_iter().find_map(|count| {
        let columns = columns(help, count);
        let rows = columns.iter().map(Vec::len).max()?;
        let widths: Vec<[f32; 2]> = columns.iter().map(|column| widths(canvas, column)).collect();
        let gutters = (columns.len() - 1) as f32 * GUTTER;
        let texts: f32 = widths.iter().map(|[keys, actions]| keys + MARGIN + actions).sum();
        let size = vec2(texts + gutters + 4.0 * MARGIN, rows as f32 * row + 2.0 * MARGIN);
        (size.x <= room.x && size.y <= room.y).then_some((columns, widths, size))
    })?;
    let corner = pos2((canvas.screen.width() - size.x) * 0.5, ((bottom - size.y) * 0.5).max(0.0));
    let area = Rect::from_min_size(corner, size);
    let panel = canvas.open_panel();
    canvas.close_panel(panel, area);
    let mut left = corner.x + 2.0 * MARGIN;
    for (rows, [keys, actions]) in columns.iter().zip(widths) {
        for (down, content) in rows.iter().enumerate() {
            let y = corner.y + MARGIN + down as f32 * row;
            match content {
                Row::Title(text) => {
                    canvas.text(pos2(left, y), TextAlign::Left, text, TITLE);
                }
                Row::Key(name, action) => {
                    canvas.text(pos2(left + keys, y + 1.0), TextAlign::Right, name, KEY);
                    canvas.text(pos2(left + keys + MARGIN, y), TextAlign::Left, action, WHAT);
                }
                Row::Empty => {}
            }
        }
        left += keys + MARGIN + actions + GUTTER;
    }
    Some(area)
}

/// Returns the widths of a column's keys and of their texts.
fn widths(canvas: &mut HudCanvas<'_>, rows: &[Row<'_>]) -> [f32; 2] {
    rows.iter().fold([0.0, 0.0], |[keys, actions], row| match row {
        Row::Key(key, action) => {
            [canvas.width(key, KEY).max(keys), canvas.width(action, WHAT).max(actions)]
        }
        Row::Title(_) | Row::Empty => [keys, actions],
    })
}

/// Returns the groups in at most so many columns of about equal height; a group stays together.
fn columns(help: &Help, most: usize) -> Vec<Vec<Row<'_>>> {
    let total: usize = help.groups.iter().map(|(_, keys)| keys.len() + 2).sum();
    let even = total.div_ceil(most.max(1));
    let mut columns: Vec<Vec<Row<'_>>> = vec![Vec::new()];
    for (title, keys) in &help.groups {
        let full = columns.last().map_or(0, Vec::len);
        // Half a group over is nearer to even than a group less.
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
