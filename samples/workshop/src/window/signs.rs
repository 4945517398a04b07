//! The signs over the model: the cube, handles of planes, measured lines, names, and messages.

use antumbra::glam::Vec2;
use egui::{Align2, Color32, FontId, Mesh, Painter, Pos2, Rect, Stroke, pos2, vec2};
use samples::hud::style::{DIM, MARGIN, MARK, NAME, PANEL, SELECTED, VALUE};

use super::context::InteractionContext;
use super::drag::place_of;
use super::interaction::{HANDLE_SHARE, Interaction};
use super::tools::{MM, handle_of};

/// The colours of the axes x, y and z.
const AXIS_COLOURS: [Color32; 3] = [
    Color32::from_rgb(255, 110, 100),
    Color32::from_rgb(120, 210, 110),
    Color32::from_rgb(110, 165, 255),
];

/// The height of text, in points.
const TEXT: f32 = 12.0;

/// The least cosine of the angle at which the name of a face is written on it.
const LEAST_FACING: f32 = 0.42;

/// Paints all signs in the part of the image that the panel does not cover.
///
/// A notice is about the current image.
pub fn paint(
    painter: &Painter,
    room: Rect,
    interaction: &Interaction,
    seen: &InteractionContext<'_>,
    notice: Option<&str>,
) {
    let scale = painter.ctx().pixels_per_point();
    cube(painter, interaction, seen, scale);
    handles(painter, interaction, seen, scale);
    measured(painter, interaction, seen, scale);
    hovered(painter, room, interaction, seen, scale);
    let state = match interaction.path() {
        path if path.is_recording() => Some("recording the path"),
        path if path.is_playing() => Some("playing the path"),
        _ => None,
    };
    let above: Vec<&str> = state.into_iter().chain(notice).collect();
    if !above.is_empty() {
        let at = pos2(room.center().x, room.min.y + MARGIN);
        text(painter, room, at, Align2::CENTER_TOP, &above.join("\n"));
    }
    if let Some(message) = interaction.message() {
        let at = pos2(room.center().x, room.max.y - MARGIN);
        text(painter, room, at, Align2::CENTER_BOTTOM, message);
    }
}

fn points(place: Vec2, scale: f32) -> Pos2 {
    pos2(place.x / scale, place.y / scale)
}

fn cube(painter: &Painter, interaction: &Interaction, seen: &InteractionContext<'_>, scale: f32) {
    let cube = interaction.cube();
    let meant = interaction.cursor().and_then(|cursor| cube.view_at(&seen.camera, cursor));
    for cell in cube.cells(&seen.camera) {
        let corners = cell.corners.map(|corner| points(corner, scale));
        let light = (70.0 + 60.0 * cell.facing) as u8;
        let fill = match meant {
            Some(view) if view == cell.view => MARK,
            _ => Color32::from_rgb(light, light + 8, light + 18),
        };
        // A polygon's soft border would have spikes on a face that is seen from its edge.
        let mut face = Mesh::default();
        corners.iter().for_each(|corner| face.colored_vertex(*corner, fill));
        face.add_triangle(0, 1, 2);
        face.add_triangle(0, 2, 3);
        painter.add(face);
        for side in 0..4 {
            let ends = [corners[side], corners[(side + 1) % 4]];
            painter.line_segment(ends, Stroke::new(0.5, SELECTED));
        }
    }
    let height = cube.half_edge / scale * 0.44;
    for label in cube.labels(&seen.camera) {
        if label.facing >= LEAST_FACING {
            let at = points(label.at, scale);
            let font = FontId::proportional(height);
            painter.text(at, Align2::CENTER_CENTER, label.name, font, Color32::WHITE);
        }
    }
}

fn handles(
    painter: &Painter,
    interaction: &Interaction,
    seen: &InteractionContext<'_>,
    scale: f32,
) {
    let radius = interaction.cube().half_edge * HANDLE_SHARE / scale;
    let under = interaction.cursor().and_then(|cursor| interaction.handle_at(cursor, seen));
    for (axis, plane) in interaction.tools().planes.iter().enumerate() {
        let handle = place_of(&seen.view, handle_of(&seen.bounds, axis, plane));
        let Some(at) = handle.filter(|_| plane.is_on) else { continue };
        let at = points(at, scale);
        let colour = if under == Some(axis) { MARK } else { AXIS_COLOURS[axis] };
        painter.circle(at, radius, PANEL, Stroke::new(2.0, colour));
        let font = FontId::proportional(radius * 1.3);
        painter.text(at, Align2::CENTER_CENTER, ["x", "y", "z"][axis], font, colour);
    }
}

fn measured(
    painter: &Painter,
    interaction: &Interaction,
    seen: &InteractionContext<'_>,
    scale: f32,
) {
    let Some(line) = interaction.measured() else { return };
    let place = |point: antumbra::glam::DVec3| {
        place_of(&seen.view, point.as_vec3()).map(|place| points(place, scale))
    };
    let from = place(line.from);
    let to = line.to.and_then(place);
    if let (Some(from), Some(to), Some(end)) = (from, to, line.to) {
        painter.line_segment([from, to], Stroke::new(3.5, PANEL));
        painter.line_segment([from, to], Stroke::new(1.5, MARK));
        let length = format!("{:.2} mm", line.from.distance(end) * f64::from(MM));
        let middle = pos2((from.x + to.x) * 0.5, (from.y + to.y) * 0.5 - 4.0);
        text(painter, painter.clip_rect(), middle, Align2::CENTER_BOTTOM, &length);
    }
    for end in [from, to].into_iter().flatten() {
        painter.circle(end, 3.5, MARK, Stroke::new(1.0, PANEL));
    }
}

/// Writes the name of the object below the pointer beside it.
fn hovered(
    painter: &Painter,
    room: Rect,
    interaction: &Interaction,
    seen: &InteractionContext<'_>,
    scale: f32,
) {
    let (Some(surface), Some(cursor)) = (interaction.hovered(), interaction.cursor()) else {
        return;
    };
    let name = seen.document.name(surface.object);
    if !name.is_empty() {
        let at = points(cursor, scale) + vec2(14.0, 12.0);
        text(painter, room, at, Align2::LEFT_TOP, name);
    }
}

/// Writes a text on a background, moved so that it fits into `room`.
fn text(painter: &Painter, room: Rect, at: Pos2, align: Align2, text: &str) {
    let font = FontId::proportional(TEXT);
    let width = (room.width() - 4.0 * MARGIN).max(1.0);
    let galley = painter.layout(text.to_owned(), font, VALUE, width);
    let size = galley.size() + vec2(2.0 * MARGIN, MARGIN * 0.75);
    let mut area = align.anchor_size(at, size);
    let over = (area.max - room.max).max(vec2(0.0, 0.0));
    area = area.translate(-over);
    let under = (room.min - area.min).max(vec2(0.0, 0.0));
    area = area.translate(under);
    painter.rect(area, 3.0, PANEL, Stroke::new(1.0, DIM), egui::StrokeKind::Inside);
    let inside = area.center() - galley.size() * 0.5;
    painter.galley(inside, galley, NAME);
}
