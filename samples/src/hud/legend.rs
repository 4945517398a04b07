//! Legends: the meanings of the colours in an image.

use bench::legend::LegendEntry;
use egui::{Align2, Color32, Pos2, Rect, Sense, Ui, vec2};

use super::page::Legend;
use super::panel;
use super::style::{NAME, Style, VALUE};

const TITLE: Style = Style::text(11.5, VALUE);
const MEANING: Style = Style::text(11.0, NAME);
/// The width of one colour, and of each colour of a scale.
const SWATCH: f32 = 14.0;
const STEP: f32 = 5.0;
const HEIGHT: f32 = 8.0;

/// Shows one legend, in the upper left of its area or in the upper right of `room`. A point has
/// `scale` pixels. Returns its area, or `None` if it does not fit without overlapping `taken`.
pub fn show(ui: &mut Ui, legend: &Legend, room: Rect, taken: Rect, scale: f32) -> Option<Rect> {
    let (room, place) = match legend.area {
        Some(area) => {
            let [origin, size] =
                [area.origin, area.size].map(|side| side.map(|side| side as f32 / scale));
            (Rect::from_min_size(Pos2::from(origin), size.into()), Align2::LEFT_TOP)
        }
        None => (room, Align2::RIGHT_TOP),
    };
    panel::show_if_fits(ui, room, place, taken, |ui| {
        ui.label(TITLE.of(legend.title));
        for entry in &legend.entries {
            ui.horizontal(|ui| {
                swatch(ui, entry);
                ui.label(MEANING.of(&entry.meaning));
            });
        }
    })
}

/// Shows the colours of an entry side by side.
fn swatch(ui: &mut Ui, entry: &LegendEntry) {
    let width = SWATCH.max(entry.colours.len() as f32 * STEP);
    let row = ui.fonts_mut(|fonts| fonts.row_height(&MEANING.font()));
    let (area, _) = ui.allocate_exact_size(vec2(width, row), Sense::hover());
    let area = Rect::from_center_size(area.center(), vec2(width, HEIGHT));
    let step = width / entry.colours.len().max(1) as f32;
    for (place, [red, green, blue]) in entry.colours.iter().copied().enumerate() {
        let at = area.min + vec2(place as f32 * step, 0.0);
        let colour = Color32::from_rgb(red, green, blue);
        ui.painter().rect_filled(Rect::from_min_size(at, vec2(step, HEIGHT)), 0.0, colour);
    }
}
