//! The graph of frame times: one bar per frame, a labelled scale, and marks on bars that exceed it.

use egui::{Align2, Painter, Rect, Sense, Sides, Stroke, Ui, pos2, vec2};

use super::page::Overview;
use super::scale::GraphScale;
use super::style::{BAD, DIM, GOOD, MARK, NAME, Style};

const HEIGHT: f32 = 46.0;
/// The width of the numbers of the scale.
const GUTTER: f32 = 34.0;
/// The distance between bars, and the width of a bar.
const PITCH: [f32; 2] = [2.0, 1.5];
/// The height of the mark on a bar that exceeds the scale.
const CUT_MARK: f32 = 4.0;
const CAPTION: Style = Style::text(10.5, NAME);
const SCALE: Style = Style::number(9.5, NAME);

/// Shows the graph in the available width.
pub fn show(ui: &mut Ui, overview: &Overview) {
    let scale = GraphScale::of(&overview.frames_ms, overview.budget_ms);
    let cut = scale.filter(|scale| scale.cut > 0).map_or(String::new(), |scale| {
        format!("{} cut, longest {:.0}", scale.cut, scale.slowest_ms)
    });
    Sides::new().shrink_left().truncate().show(
        ui,
        |ui| ui.label(CAPTION.of(overview.caption)),
        |ui| ui.label(Style { colour: BAD, ..CAPTION }.of(cut)),
    );
    ui.add_space(2.0);
    let size = vec2(ui.available_width(), HEIGHT);
    let (area, _) = ui.allocate_exact_size(size, Sense::hover());
    let plot = Rect::from_min_max(pos2(area.min.x + GUTTER, area.min.y), area.max);
    if let Some(scale) = scale {
        let row = ui.fonts_mut(|fonts| fonts.row_height(&SCALE.font()));
        rules(ui.painter(), &scale, plot);
        bars(ui.painter(), overview, &scale, plot);
        budget(ui.painter(), overview, &scale, plot, row);
    }
    ui.add_space(4.0);
}

/// Draws the lines of the scale with their numbers.
fn rules(painter: &Painter, scale: &GraphScale, plot: Rect) {
    for (share, y, align) in
        [(1.0, plot.min.y, Align2::RIGHT_TOP), (0.0, plot.max.y, Align2::RIGHT_BOTTOM)]
    {
        painter.hline(plot.x_range(), y, Stroke::new(1.0, DIM));
        let at = pos2(plot.min.x - 4.0, y);
        painter.text(at, align, number(share * scale.top_ms), SCALE.font(), SCALE.colour);
    }
}

fn bars(painter: &Painter, overview: &Overview, scale: &GraphScale, plot: Rect) {
    let shown = (plot.width() / PITCH[0]) as usize;
    let frames = &overview.frames_ms;
    let skipped = frames.len().saturating_sub(shown);
    for (place, ms) in frames.iter().skip(skipped).enumerate().filter(|(_, ms)| ms.is_finite()) {
        let x = plot.min.x + place as f32 * PITCH[0];
        let top = plot.max.y - scale.height(*ms) * plot.height();
        let is_late = overview.budget_ms.is_some_and(|budget| *ms > budget * 1.05);
        let bar = Rect::from_min_max(pos2(x, top), pos2(x + PITCH[1], plot.max.y));
        painter.rect_filled(bar, 0.0, if is_late { BAD } else { GOOD });
        if *ms > scale.top_ms {
            let mark = Rect::from_min_size(bar.min, vec2(PITCH[1], CUT_MARK));
            painter.rect_filled(mark, 0.0, MARK);
        }
    }
}

/// Draws the line of the frame budget, and its number if there is room for it between the ends of
/// the scale.
fn budget(painter: &Painter, overview: &Overview, scale: &GraphScale, plot: Rect, row: f32) {
    let Some(budget_ms) = overview.budget_ms else { return };
    let y = plot.max.y - scale.height(budget_ms) * plot.height();
    painter.hline(plot.x_range(), y, Stroke::new(1.0, MARK));
    if y - 1.5 * row >= plot.min.y && y + 1.5 * row <= plot.max.y {
        let at = pos2(plot.min.x - 4.0, y);
        painter.text(at, Align2::RIGHT_CENTER, number(budget_ms), SCALE.font(), MARK);
    }
}

fn number(ms: f32) -> String {
    match ms {
        _ if ms == 0.0 => "0".to_owned(),
        _ if (ms - ms.round()).abs() < 0.01 => format!("{ms:.0}"),
        _ => format!("{ms:.1}"),
    }
}
