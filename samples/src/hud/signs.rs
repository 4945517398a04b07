//! Signs that are understood without reading: a coloured frame, and a badge with a shape.

use epaint::{Color32, Pos2, Rect, Shape, Stroke, pos2, vec2};

use super::canvas::HudCanvas;
use super::page::Sign;
use super::style::PANEL;

/// The width of the frame around the image, in points.
const FRAME: f32 = 3.0;
const BADGE: f32 = 24.0;

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
pub fn draw(canvas: &mut HudCanvas<'_>, signs: &[Sign]) {
    let screen = canvas.screen;
    let badges = BADGE * signs.len() as f32;
    let badge = BADGE.min(screen.width() / 4.0).min(screen.height() / 4.0);
    for (place, sign) in signs.iter().enumerate() {
        let inner = screen.shrink(place as f32 * FRAME);
        frame(canvas, inner, colour_of(*sign));
        let left = screen.center().x - badges * 0.5 + place as f32 * BADGE;
        let top = signs.len() as f32 * FRAME;
        draw_badge(canvas, *sign, Rect::from_min_size(pos2(left, top), vec2(badge, badge)));
    }
}

fn frame(canvas: &mut HudCanvas<'_>, area: Rect, colour: Color32) {
    let Rect { min, max } = area;
    for edge in [
        Rect::from_min_max(min, pos2(max.x, min.y + FRAME)),
        Rect::from_min_max(pos2(min.x, max.y - FRAME), max),
        Rect::from_min_max(pos2(min.x, min.y + FRAME), pos2(min.x + FRAME, max.y - FRAME)),
        Rect::from_min_max(pos2(max.x - FRAME, min.y + FRAME), pos2(max.x, max.y - FRAME)),
    ] {
        canvas.fill(edge, colour);
    }
}

/// Draws two bars for a stop, a disc for a recording, a camera for an image.
fn draw_badge(canvas: &mut HudCanvas<'_>, sign: Sign, area: Rect) {
    canvas.fill(area, PANEL);
    let colour = colour_of(sign);
    let side = area.width();
    let at = |x: f32, y: f32| area.min + vec2(x * side, y * side);
    let part = |from: Pos2, to: Pos2| Shape::rect_filled(Rect::from_min_max(from, to), 0.0, colour);
    match sign {
        Sign::Frozen => {
            canvas.add(part(at(0.25, 0.2), at(0.43, 0.8)));
            canvas.add(part(at(0.57, 0.2), at(0.75, 0.8)));
        }
        Sign::Recording => canvas.add(Shape::circle_filled(at(0.5, 0.5), 0.28 * side, colour)),
        Sign::Screenshot => {
            canvas.add(part(at(0.15, 0.32), at(0.85, 0.78)));
            canvas.add(part(at(0.36, 0.2), at(0.64, 0.32)));
            canvas.add(Shape::circle_filled(at(0.5, 0.55), 0.16 * side, PANEL));
            let ring = Stroke::new(1.0, colour);
            canvas.add(Shape::circle_stroke(at(0.5, 0.55), 0.1 * side, ring));
        }
    }
}
