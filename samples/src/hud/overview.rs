//! The panel in the upper left: the numbers that a person looks for first, and below them details.

use epaint::{Pos2, Rect, Shape, Stroke, pos2, vec2};

use super::canvas::{HudCanvas, TextAlign};
use super::graph;
use super::layout::{Measures, Room};
use super::page::{ExactnessVerdict, HudFigure, HudPage, Overview, Split};
use super::style::{BAD, DIM, GOOD, MARGIN, MARK, NAME, Style, VALUE};

const TITLE: Style = Style::text(13.0, VALUE);
const LARGE: Style = Style::number(27.0, VALUE);
const MIDDLE: Style = Style::number(17.0, VALUE);
const UNIT: Style = Style::text(10.5, NAME);
const ROW_NAME: Style = Style::text(11.5, NAME);
const ROW_VALUE: Style = Style::number(10.5, VALUE);
const NARROW_VALUE: Style = Style::number(15.0, VALUE);
const BAR_HEIGHT: f32 = 6.0;
const GAP: f32 = 5.0;
const MORE: &str = "more in a larger window";

/// Draws the panel. Returns its area.
pub fn draw(canvas: &mut HudCanvas<'_>, page: &HudPage, measures: &Measures) -> Option<Rect> {
    let overview = page.overview.as_ref()?;
    let bottom = canvas.screen.max.y - MARGIN * 0.5;
    let panel = canvas.open_panel();
    let begin = canvas.shapes.len();
    let end = match measures.room {
        Room::Full => full(canvas, overview, measures.inner_width()),
        Room::Narrow => narrow(canvas, overview, measures.inner_width()),
        Room::None => return None,
    };
    if end > bottom {
        // A part that does not fit as a whole is left out as a whole.
        canvas.shapes.truncate(begin);
        return None;
    }
    let end = match measures.room {
        Room::Full => details(canvas, page, measures.inner_width(), end, bottom),
        _ => end,
    };
    let area = Rect::from_min_size(Pos2::ZERO, vec2(measures.panel_width, end + MARGIN * 0.5));
    canvas.close_panel(panel, area);
    Some(area)
}

/// Draws the whole overview, `width` points wide. Returns its lower end.
fn full(canvas: &mut HudCanvas<'_>, overview: &Overview, width: f32) -> f32 {
    let (left, right) = (MARGIN, MARGIN + width);
    let strategy = Style { colour: MARK, ..TITLE };
    let title = canvas.text(pos2(right, GAP), TextAlign::Right, &overview.strategy, strategy);
    let room = title.min.x - left - MARGIN;
    canvas.text_within(pos2(left, GAP), TextAlign::Left, room, &overview.scene, TITLE);
    let y = headline(canvas, overview, title.max.y + 2.0, width);
    let y = graph::draw(canvas, overview, pos2(left, y), width) + 2.0;
    let y = figures(canvas, &overview.objects, y, width);
    let y = overview.split.map_or(y, |split| bar(canvas, split, y + 2.0, width));
    let y = times(canvas, &overview.times, y + 3.0, width);
    let y = verdict(canvas, &overview.verdict, y + 3.0, width);
    canvas.text_within(pos2(left, y), TextAlign::Left, width, &overview.hint, UNIT).max.y
}

/// Draws the rate, large, and the time of a frame. Returns their lower end.
fn headline(canvas: &mut HudCanvas<'_>, overview: &Overview, y: f32, width: f32) -> f32 {
    let rate = canvas.text(pos2(MARGIN, y), TextAlign::Left, &overview.rate.value, LARGE);
    let small = canvas.row(UNIT);
    let beside = pos2(rate.max.x + GAP, rate.max.y - small - 3.5);
    canvas.text(beside, TextAlign::Left, overview.rate.name, UNIT);
    let right = MARGIN + width;
    let name = pos2(right, rate.max.y - small - 3.5);
    let name = canvas.text(name, TextAlign::Right, overview.frame_time.name, UNIT);
    let at = pos2(name.min.x - GAP, rate.max.y - canvas.row(MIDDLE) - 2.0);
    canvas.text(at, TextAlign::Right, &overview.frame_time.value, MIDDLE);
    rate.max.y + 1.0
}

/// Draws numbers in columns, with their names below. Returns their lower end.
fn figures(canvas: &mut HudCanvas<'_>, figures: &[HudFigure], y: f32, width: f32) -> f32 {
    let column = width / figures.len().max(1) as f32;
    let below = y + canvas.row(MIDDLE);
    for (place, figure) in figures.iter().enumerate() {
        let left = MARGIN + place as f32 * column;
        let room = column - 2.0;
        // The last one is what the others come down to.
        let colour = if place + 1 == figures.len() { GOOD } else { VALUE };
        let style = Style { colour, ..MIDDLE };
        canvas.text_within(pos2(left, y), TextAlign::Left, room, &figure.value, style);
        canvas.text_within(pos2(left, below), TextAlign::Left, room, figure.name, UNIT);
    }
    below + canvas.row(UNIT) + 2.0
}

/// Draws the drawn part of the objects in the frustum, as a share and as a sum. Returns its lower
/// end.
fn bar(canvas: &mut HudCanvas<'_>, Split { drawn, culled }: Split, y: f32, width: f32) -> f32 {
    let whole = Rect::from_min_size(pos2(MARGIN, y), vec2(width, BAR_HEIGHT));
    canvas.fill(whole, DIM);
    let all = drawn.saturating_add(culled);
    let share = drawn as f32 / all.max(1) as f32;
    // A few among many still show.
    let least = if drawn > 0 { 2.0 } else { 0.0 };
    let part = vec2((width * share).max(least), BAR_HEIGHT);
    canvas.fill(Rect::from_min_size(whole.min, part), GOOD);
    let sum = format!(
        "{} drawn + {} occluded = {}",
        super::grouped(drawn),
        super::grouped(culled),
        super::grouped(all)
    );
    let at = pos2(MARGIN, whole.max.y + 2.0);
    canvas.text_within(at, TextAlign::Left, width, &sum, UNIT).max.y + 2.0
}

/// Draws names and times side by side. Returns their lower end.
fn times(canvas: &mut HudCanvas<'_>, times: &[HudFigure], y: f32, width: f32) -> f32 {
    let column = width / times.len().max(1) as f32;
    let (high, low) = (canvas.row(MIDDLE), canvas.row(UNIT));
    for (place, figure) in times.iter().enumerate() {
        let left = MARGIN + place as f32 * column;
        let name = pos2(left, y + high - low - 2.0);
        let name = canvas.text(name, TextAlign::Left, figure.name, UNIT);
        let at = pos2(name.max.x + GAP, y);
        canvas.text_within(at, TextAlign::Left, left + column - at.x, &figure.value, MIDDLE);
    }
    y + high
}

/// Draws a check mark or a warning triangle, and a sentence; where nothing is claimed, the sentence
/// alone. Returns their lower end.
fn verdict(canvas: &mut HudCanvas<'_>, verdict: &ExactnessVerdict, y: f32, width: f32) -> f32 {
    let row = canvas.row(ROW_NAME);
    let (text, colour) = match verdict {
        ExactnessVerdict::Exact(text) => (text, GOOD),
        ExactnessVerdict::Inexact(text) => (text, BAD),
        ExactnessVerdict::Unclaimed(text) => {
            canvas.text_within(pos2(MARGIN, y), TextAlign::Left, width, text, ROW_NAME);
            return y + row;
        }
    };
    let [left, size] = [MARGIN, row * 0.7];
    let [top, low] = [y + row * 0.18, y + row * 0.82];
    let mark = match verdict {
        ExactnessVerdict::Exact(_) => {
            let points = [(0.0, 0.55), (0.38, 1.0), (1.0, 0.05)];
            let points = points.map(|(x, y)| pos2(left + x * size, top + y * (low - top)));
            Shape::line(points.to_vec(), Stroke::new(2.0, colour))
        }
        _ => {
            let points = [(0.5, 0.0), (1.0, 1.0), (0.0, 1.0)];
            let points = points.map(|(x, y)| pos2(left + x * size, top + y * (low - top)));
            Shape::convex_polygon(points.to_vec(), colour, Stroke::NONE)
        }
    };
    canvas.add(mark);
    let at = pos2(left + size + GAP, y);
    let style = Style { colour, ..ROW_NAME };
    canvas.text_within(at, TextAlign::Left, MARGIN + width - at.x, text, style).max.y + 1.0
}

/// Draws the most important numbers alone, one below the other. Returns their lower end.
fn narrow(canvas: &mut HudCanvas<'_>, overview: &Overview, width: f32) -> f32 {
    let [objects, in_frustum, drawn] = &overview.objects;
    let mut y = GAP;
    for figure in [&overview.rate, &overview.times[0], objects, in_frustum, drawn] {
        let at = pos2(MARGIN, y);
        y = canvas.text_within(at, TextAlign::Left, width, &figure.value, NARROW_VALUE).max.y - 2.0;
        let at = pos2(MARGIN, y);
        y = canvas.text_within(at, TextAlign::Left, width, figure.name, UNIT).max.y + 1.0;
    }
    y
}

/// Draws groups of names and values below `y`, as many as fit above `bottom`. Returns their lower
/// end.
fn details(canvas: &mut HudCanvas<'_>, page: &HudPage, width: f32, y: f32, bottom: f32) -> f32 {
    let (row, right) = (canvas.row(ROW_NAME), MARGIN + width);
    let mut y = y;
    let mut groups = page.details.iter().filter(|group| !group.is_empty()).peekable();
    while let Some(group) = groups.next() {
        let more = if groups.peek().is_some() { row } else { 0.0 };
        if y + 2.0 * GAP + group.len() as f32 * row + more + GAP > bottom {
            let at = pos2(MARGIN, y + GAP);
            let style = Style { colour: MARK, ..UNIT };
            return canvas.text_within(at, TextAlign::Left, width, MORE, style).max.y;
        }
        y += GAP;
        canvas.line([pos2(MARGIN, y), pos2(right, y)], 1.0, DIM);
        y += GAP;
        for (name, value) in group {
            let name = canvas.text(pos2(MARGIN, y), TextAlign::Left, name, ROW_NAME);
            let room = right - name.max.x - GAP;
            canvas.text_within(pos2(right, y), TextAlign::Right, room, value, ROW_VALUE);
            y += row;
        }
    }
    y
}
