//! The graph of frame times: one bar per frame, a labelled scale, and marks on bars that exceed it.

use epaint::{Pos2, Rect, pos2, vec2};

use super::canvas::{HudCanvas, TextAlign};
use super::page::Overview;
use super::scale::GraphScale;
use super::style::{BAD, DIM, GOOD, MARGIN, MARK, NAME, Style};

const HEIGHT: f32 = 46.0;
/// The width of the numbers of the scale.
const GUTTER: f32 = 34.0;
/// The distance between bars, and the width of a bar.
const PITCH: [f32; 2] = [2.0, 1.5];
/// The height of the mark on a bar that is cut.
const CUT_MARK: f32 = 4.0;
const CAPTION: Style = Style::text(10.5, NAME);
const SCALE: Style = Style::number(9.5, NAME);

/// Draws the graph from `corner` on, `width` points wide. Returns its lower end.
pub fn draw(canvas: &mut HudCanvas<'_>, overview: &Overview, corner: Pos2, width: f32) -> f32 {
    let scale = GraphScale::of(&overview.frames_ms, overview.budget_ms);
    let caption = canvas.text(corner, TextAlign::Left, overview.caption, CAPTION);
    if let Some(GraphScale { cut, slowest_ms, .. }) = scale.filter(|scale| scale.cut > 0) {
        let text = format!("{cut} cut, longest {slowest_ms:.0}");
        let at = pos2(corner.x + width, corner.y);
        canvas.text(at, TextAlign::Right, &text, Style { colour: BAD, ..CAPTION });
    }
    let plot = Rect::from_min_size(
        pos2(corner.x + GUTTER, caption.max.y + 2.0),
        vec2(width - GUTTER, HEIGHT),
    );
    if let Some(scale) = scale {
        rules(canvas, &scale, plot);
        bars(canvas, overview, &scale, plot);
        budget(canvas, overview, &scale, plot);
    }
    plot.max.y + MARGIN * 0.5
}

/// Draws the lines of the scale with their numbers.
fn rules(canvas: &mut HudCanvas<'_>, scale: &GraphScale, plot: Rect) {
    let row = canvas.row(SCALE);
    for (share, above) in [(1.0, 0.0), (0.0, row)] {
        let y = plot.max.y - share * plot.height();
        canvas.line([pos2(plot.min.x, y), pos2(plot.max.x, y)], 1.0, DIM);
        let at = pos2(plot.min.x - 4.0, y - above);
        canvas.text(at, TextAlign::Right, &number(share * scale.top_ms), SCALE);
    }
}

fn bars(canvas: &mut HudCanvas<'_>, overview: &Overview, scale: &GraphScale, plot: Rect) {
    let shown = (plot.width() / PITCH[0]) as usize;
    let frames = &overview.frames_ms;
    let skipped = frames.len().saturating_sub(shown);
    for (place, ms) in frames.iter().skip(skipped).enumerate().filter(|(_, ms)| ms.is_finite()) {
        let x = plot.min.x + place as f32 * PITCH[0];
        let top = plot.max.y - scale.height(*ms) * plot.height();
        let is_late = overview.budget_ms.is_some_and(|budget| *ms > budget * 1.05);
        let bar = Rect::from_min_max(pos2(x, top), pos2(x + PITCH[1], plot.max.y));
        canvas.fill(bar, if is_late { BAD } else { GOOD });
        if *ms > scale.top_ms {
            let mark = Rect::from_min_size(bar.min, vec2(PITCH[1], CUT_MARK));
            canvas.fill(mark, MARK);
        }
    }
}

/// Draws the line that frames should stay below, if it has room beside the ends of the scale.
fn budget(canvas: &mut HudCanvas<'_>, overview: &Overview, scale: &GraphScale, plot: Rect) {
    let Some(budget_ms) = overview.budget_ms else { return };
    let y = plot.max.y - scale.height(budget_ms) * plot.height();
    canvas.line([pos2(plot.min.x, y), pos2(plot.max.x, y)], 1.0, MARK);
    let row = canvas.row(SCALE);
    let top = y - row * 0.5;
    if top >= plot.min.y + row && top + row <= plot.max.y - row {
        let style = Style { colour: MARK, ..SCALE };
        let at = pos2(plot.min.x - 4.0, top);
        canvas.text(at, TextAlign::Right, &number(budget_ms), style);
    }
}

fn number(ms: f32) -> String {
    match ms {
        _ if ms == 0.0 => "0".to_owned(),
        _ if (ms - ms.round()).abs() < 0.01 => format!("{ms:.0}"),
        _ => format!("{ms:.1}"),
    }
}
