//! Signs that are understood without reading: a coloured frame, a badge with a shape, and outlines
//! of areas.

use egui::{Color32, Painter, Pos2, Rect, Stroke, StrokeKind, pos2, vec2};

use super::page::Sign;
use super::style::{BAD, PANEL};

/// The width of the frame around the image, in points.
const FRAME: f32 = 3.0;
const BADGE: f32 = 24.0;
/// The width of an outline in points.
const OUTLINE: f32 = 2.0;

/// Returns the colour of a sign's frame and badge.
const fn colour_of(sign: Sign) -> Color32 {
    match sign {
        Sign::Frozen => Color32::from_rgb(110, 190, 255),
        Sign::Recording => Color32::from_rgb(255, 70, 60),
        Sign::Screenshot => Color32::from_rgb(255, 255, 255),
    }
}

/// Draws frames around the image, one within the other, and badges in the middle of its upper
/// edge.
pub fn draw(painter: &Painter, signs: &[Sign]) {
    let screen = painter.clip_rect();
    let badges = BADGE * signs.len() as f32;
    let badge = BADGE.min(screen.width() / 4.0).min(screen.height() / 4.0);
    for (place, sign) in signs.iter().enumerate() {
        let inner = screen.shrink(place as f32 * FRAME);
        let stroke = Stroke::new(FRAME, colour_of(*sign));
        painter.rect_stroke(inner, 0.0, stroke, StrokeKind::Inside);
        let left = screen.center().x - badges * 0.5 + place as f32 * BADGE;
        let top = signs.len() as f32 * FRAME;
        draw_badge(painter, *sign, Rect::from_min_size(pos2(left, top), vec2(badge, badge)));
    }
}

/// Outlines areas, each given by its left, top, right and bottom edge in pixels.
pub fn outline(painter: &Painter, areas: &[[u32; 4]], scale: f32) {
    for area in areas {
        let [left, top, right, bottom] = area.map(|edge| edge as f32 / scale);
        let area = Rect::from_min_max(pos2(left, top), pos2(right, bottom));
        painter.rect_stroke(area, 0.0, Stroke::new(OUTLINE, BAD), StrokeKind::Outside);
    }
}

/// Draws two bars for a freeze, a disc for a recording, a camera for a screenshot.
fn draw_badge(painter: &Painter, sign: Sign, area: Rect) {
    painter.rect_filled(area, 0.0, PANEL);
    let colour = colour_of(sign);
    let side = area.width();
    let at = |x: f32, y: f32| area.min + vec2(x * side, y * side);
    let part = |from: Pos2, to: Pos2| {
        painter.rect_filled(Rect::from_min_max(from, to), 0.0, colour);
    };
    match sign {
        Sign::Frozen => {
            part(at(0.25, 0.2), at(0.43, 0.8));
            part(at(0.57, 0.2), at(0.75, 0.8));
        }
        Sign::Recording => _ = painter.circle_filled(at(0.5, 0.5), 0.28 * side, colour),
        Sign::Screenshot => {
            part(at(0.15, 0.32), at(0.85, 0.78));
            part(at(0.36, 0.2), at(0.64, 0.32));
            painter.circle_filled(at(0.5, 0.55), 0.16 * side, PANEL);
            painter.circle_stroke(at(0.5, 0.55), 0.1 * side, Stroke::new(1.0, colour));
        }
    }
}
