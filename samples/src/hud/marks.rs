//! Outlines of areas of the image that differ.

use epaint::{Rect, Shape, Stroke, StrokeKind, pos2};

use super::canvas::HudCanvas;
use super::style::BAD;

/// The width of an outline in points.
const WIDTH_POINTS: f32 = 2.0;

/// Outlines areas, each given by its left, top, right and bottom edge in pixels.
pub fn draw(canvas: &mut HudCanvas<'_>, areas: &[[u32; 4]]) {
    for area in areas {
        let [left, top, right, bottom] = area.map(|edge| edge as f32 / canvas.scale);
        let area = Rect::from_min_max(pos2(left, top), pos2(right, bottom));
        let stroke = Stroke::new(WIDTH_POINTS, BAD);
        canvas.add(Shape::rect_stroke(area, 0.0, stroke, StrokeKind::Outside));
    }
}
