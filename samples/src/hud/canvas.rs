//! The canvas that collects shapes and texts of the HUD, in points from the upper left of the
//! image.

use std::sync::Arc;

use epaint::text::{Fonts, LayoutJob, TextFormat, TextWrapping};
use epaint::{ClippedShape, Color32, Galley, Pos2, Rect, Shape, Stroke, pos2, vec2};

use super::style::{PANEL, Style};

/// The end of a text that is at its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextAlign {
    /// Its left end.
    Left,
    /// Its right end.
    Right,
}

/// A panel whose size is known when all its contents are laid out.
#[derive(Clone, Copy, Debug)]
pub struct OpenPanel(usize);

/// A collector of the shapes of one image.
pub struct HudCanvas<'a> {
    fonts: &'a mut Fonts,
    /// The shapes, in the order of drawing.
    pub shapes: Vec<ClippedShape>,
    /// The pixels per point.
    pub scale: f32,
    /// The area of the whole image.
    pub screen: Rect,
}

impl<'a> HudCanvas<'a> {
    /// Creates an empty canvas of `size` pixels.
    pub fn new(fonts: &'a mut Fonts, size: [u32; 2], scale: f32) -> Self {
        let [width, height] = size.map(|side| side as f32 / scale);
        let screen = Rect::from_min_size(Pos2::ZERO, vec2(width, height));
        Self { fonts, shapes: Vec::new(), scale, screen }
    }

    /// Begins a panel below all that is added from now on.
    pub fn open_panel(&mut self) -> OpenPanel {
        self.add(Shape::Noop);
        OpenPanel(self.shapes.len() - 1)
    }

    /// Gives a panel its area.
    pub fn close_panel(&mut self, OpenPanel(place): OpenPanel, area: Rect) {
        let shape = Shape::rect_filled(area, 0.0, PANEL);
        self.shapes[place] = ClippedShape::new(self.screen, shape);
    }

    /// Adds any shape.
    pub fn add(&mut self, shape: Shape) {
        self.shapes.push(ClippedShape::new(self.screen, shape));
    }

    /// Fills an area.
    pub fn fill(&mut self, area: Rect, colour: Color32) {
        self.add(Shape::rect_filled(area, 0.0, colour));
    }

    /// Draws a line.
    pub fn line(&mut self, ends: [Pos2; 2], width: f32, colour: Color32) {
        self.add(Shape::line_segment(ends, Stroke::new(width, colour)));
    }

    /// Writes one row from `at` on, cut with an ellipsis beyond `width`. Returns its area.
    pub fn text_within(
        &mut self,
        at: Pos2,
        align: TextAlign,
        width: f32,
        text: &str,
        style: Style,
    ) -> Rect {
        let mut job = LayoutJob::single_section(
            text.to_owned(),
            TextFormat::simple(style.font(), style.colour),
        );
        job.wrap = TextWrapping::truncate_at_width(width.max(1.0));
        let galley = self.fonts.with_pixels_per_point(self.scale).layout_job(job);
        let left = match align {
            TextAlign::Left => at.x,
            TextAlign::Right => at.x - galley.size().x,
        };
        let corner = pos2(left, at.y);
        let area = Rect::from_min_size(corner, galley.size());
        self.add(Shape::galley(corner, galley, style.colour));
        area
    }

    /// Writes one row in its full length. Returns its area.
    pub fn text(&mut self, at: Pos2, align: TextAlign, text: &str, style: Style) -> Rect {
        self.text_within(at, align, f32::INFINITY, text, style)
    }

    /// Lays a text out in as many rows as it takes.
    pub fn wrapped(&mut self, text: String, style: Style, width: f32) -> Arc<Galley> {
        let mut fonts = self.fonts.with_pixels_per_point(self.scale);
        fonts.layout(text, style.font(), style.colour, width.max(1.0))
    }

    /// Returns the width of a text, in points.
    pub fn width(&mut self, text: &str, style: Style) -> f32 {
        let mut fonts = self.fonts.with_pixels_per_point(self.scale);
        fonts.layout_no_wrap(text.to_owned(), style.font(), style.colour).size().x
    }

    /// Returns the height of a row, in points.
    pub fn row(&mut self, style: Style) -> f32 {
        self.fonts.with_pixels_per_point(self.scale).row_height(&style.font()).max(1.0)
    }
}
