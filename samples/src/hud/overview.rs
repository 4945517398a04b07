//! The panel in the upper left: the most important numbers, with details below.

use egui::{Align, Align2, Label, Layout, Rect, Sense, Shape, Sides, Stroke, Ui, pos2, vec2};

use super::graph;
use super::layout::{Measures, Room};
use super::page::{ExactnessVerdict, HudFigure, HudPage, Overview, Split};
use super::panel::{self, row};
use super::style::{BAD, DIM, GOOD, MARK, NAME, Style, VALUE};

const TITLE: Style = Style::text(13.0, VALUE);
const LARGE: Style = Style::number(27.0, VALUE);
const MIDDLE: Style = Style::number(17.0, VALUE);
const UNIT: Style = Style::text(10.5, NAME);
const ROW_NAME: Style = Style::text(11.5, NAME);
const ROW_VALUE: Style = Style::number(10.5, VALUE);
const NARROW_VALUE: Style = Style::number(15.0, VALUE);
const BAR_HEIGHT: f32 = 6.0;
const GAP: f32 = 5.0;
/// The distance from the lower edge of large letters to that of small letters beside them.
const BASELINE: f32 = 4.0;
const MORE: &str = "more in a larger window";

/// Shows the panel. Returns its area.
pub fn show(ui: &mut Ui, page: &HudPage, measures: &Measures) -> Option<Rect> {
    let overview = page.overview.as_ref()?;
    let screen = ui.max_rect();
    let width = measures.inner_width();
    let contents = |ui: &mut Ui| {
        ui.set_width(width);
        match measures.room {
            Room::Full => {
                full(ui, overview);
                details(ui, page, screen.max.y);
            }
            Room::Narrow => narrow(ui, overview),
            Room::None => {}
        }
    };
    let has_room = measures.room != Room::None;
    // A part that does not fit completely is left out.
    has_room
        .then(|| panel::show_if_fits(ui, screen, Align2::LEFT_TOP, Rect::NOTHING, contents))
        .flatten()
}

/// Shows the whole overview.
fn full(ui: &mut Ui, overview: &Overview) {
    let strategy = Style { colour: MARK, ..TITLE };
    Sides::new().shrink_left().truncate().show(
        ui,
        |ui| ui.label(TITLE.of(&overview.scene)),
        |ui| ui.label(strategy.of(&overview.strategy)),
    );
    headline(ui, overview);
    graph::show(ui, overview);
    ui.add_space(2.0);
    figures(ui, &overview.objects);
    if let Some(split) = overview.split {
        bar(ui, split);
    }
    times(ui, &overview.times);
    verdict(ui, &overview.verdict);
    row(ui, UNIT.of(&overview.hint));
}

/// Shows the frame rate in large letters and the frame time, each with its unit on the same line.
fn headline(ui: &mut Ui, overview: &Overview) {
    let height = ui.fonts_mut(|fonts| fonts.row_height(&LARGE.font()));
    let (area, _) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::hover());
    let painter = ui.painter();
    let text = |at, align: Align2, text: &str, style: Style| {
        painter.text(at, align, text, style.font(), style.colour)
    };
    let rate = text(area.left_top(), Align2::LEFT_TOP, &overview.rate.value, LARGE);
    let bottom = area.max.y - BASELINE;
    let beside = pos2(rate.max.x + GAP, bottom);
    text(beside, Align2::LEFT_BOTTOM, overview.rate.name, UNIT);
    let right = pos2(area.max.x, bottom);
    let name = text(right, Align2::RIGHT_BOTTOM, overview.frame_time.name, UNIT);
    let at = pos2(name.min.x - GAP, area.max.y - 0.5 * BASELINE);
    text(at, Align2::RIGHT_BOTTOM, &overview.frame_time.value, MIDDLE);
}

/// Shows numbers in columns, with their names below.
fn figures(ui: &mut Ui, figures: &[HudFigure]) {
    ui.columns(figures.len(), |columns| {
        let last = figures.len().saturating_sub(1);
        for (place, (ui, figure)) in columns.iter_mut().zip(figures).enumerate() {
            // The last figure is the result of the others.
            let colour = if place == last { GOOD } else { VALUE };
            row(ui, Style { colour, ..MIDDLE }.of(&figure.value));
            row(ui, UNIT.of(figure.name));
        }
    });
}

/// Shows the drawn share of the objects in the frustum, as a bar and as a sum.
fn bar(ui: &mut Ui, Split { drawn, culled }: Split) {
    ui.add_space(4.0);
    let size = vec2(ui.available_width(), BAR_HEIGHT);
    let (whole, _) = ui.allocate_exact_size(size, Sense::hover());
    ui.painter().rect_filled(whole, 0.0, DIM);
    let all = drawn.saturating_add(culled);
    let share = drawn as f32 / all.max(1) as f32;
    // A small number remains visible.
    let least = if drawn > 0 { 2.0 } else { 0.0 };
    let part = vec2((whole.width() * share).max(least), BAR_HEIGHT);
    ui.painter().rect_filled(Rect::from_min_size(whole.min, part), 0.0, GOOD);
    ui.add_space(2.0);
    let [drawn, culled, all] = [drawn, culled, all].map(super::grouped);
    row(ui, UNIT.of(format!("{drawn} drawn + {culled} occluded = {all}")));
}

/// Shows names and times side by side.
fn times(ui: &mut Ui, times: &[HudFigure]) {
    ui.columns(times.len(), |columns| {
        for (ui, figure) in columns.iter_mut().zip(times) {
            let height = ui.fonts_mut(|fonts| fonts.row_height(&MIDDLE.font()));
            let size = vec2(ui.available_width(), height);
            ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Max), |ui| {
                ui.label(UNIT.of(figure.name));
                row(ui, MIDDLE.of(&figure.value));
            });
        }
    });
}

/// Shows a check mark or a warning triangle with a sentence; only the sentence if nothing is
/// claimed.
fn verdict(ui: &mut Ui, verdict: &ExactnessVerdict) {
    let (text, colour) = match verdict {
        ExactnessVerdict::Exact(text) => (text, GOOD),
        ExactnessVerdict::Inexact(text) => (text, BAD),
        ExactnessVerdict::Unclaimed(text) => return row(ui, ROW_NAME.of(text)),
    };
    ui.horizontal(|ui| {
        let height = ui.fonts_mut(|fonts| fonts.row_height(&ROW_NAME.font()));
        let (area, _) = ui.allocate_exact_size(vec2(9.0, height), Sense::hover());
        let area = Rect::from_center_size(area.center(), vec2(9.0, 9.0));
        let at = |x: f32, y: f32| area.min + vec2(x, y) * area.size();
        let mark = match verdict {
            ExactnessVerdict::Exact(_) => {
                let points = vec![at(0.0, 0.55), at(0.38, 1.0), at(1.0, 0.05)];
                Shape::line(points, Stroke::new(2.0, colour))
            }
            _ => {
                let points = vec![at(0.5, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
                Shape::convex_polygon(points, colour, Stroke::NONE)
            }
        };
        ui.painter().add(mark);
        row(ui, Style { colour, ..ROW_NAME }.of(text));
    });
}

/// Shows only the most important numbers, one below the other.
fn narrow(ui: &mut Ui, overview: &Overview) {
    let [objects, in_frustum, drawn] = &overview.objects;
    for figure in [&overview.rate, &overview.times[0], objects, in_frustum, drawn] {
        row(ui, NARROW_VALUE.of(&figure.value));
        row(ui, UNIT.of(figure.name));
    }
}

/// Shows groups of names and values above `bottom`, as many as fit.
fn details(ui: &mut Ui, page: &HudPage, bottom: f32) {
    let height = ui.fonts_mut(|fonts| fonts.row_height(&ROW_NAME.font()));
    let bottom = bottom - f32::from(panel::MARGINS[1]);
    let mut groups = page.details.iter().filter(|group| !group.is_empty()).peekable();
    while let Some(group) = groups.next() {
        let more = if groups.peek().is_some() { height + GAP } else { 0.0 };
        let top = ui.cursor().min.y;
        if top + 2.0 * GAP + group.len() as f32 * height + more > bottom {
            ui.add_space(GAP);
            return row(ui, Style { colour: MARK, ..UNIT }.of(MORE));
        }
        ui.add_space(GAP);
        let line = ui.available_rect_before_wrap().x_range();
        ui.painter().hline(line, ui.cursor().min.y, Stroke::new(1.0, DIM));
        ui.add_space(GAP);
        for (name, value) in group {
            Sides::new().height(height).shrink_right().truncate().show(
                ui,
                |ui| ui.label(ROW_NAME.of(name)),
                |ui| ui.add(Label::new(ROW_VALUE.of(value))),
            );
        }
    }
}
