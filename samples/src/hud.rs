//! What the engine thinks, in text and a graph over the picture.

use epaint::text::{FontDefinitions, FontId, Fonts, TextOptions, ViewportKey};
use epaint::{
    ClippedShape, Color32, ImageData, Primitive, Shape, Stroke, TessellationOptions, Tessellator,
    pos2, vec2,
};
use render::{FlatOverlay, FlatVertex};

const FONT_POINTS: f32 = 12.5;
const MARGIN_POINTS: f32 = 10.0;
const GRAPH_POINTS: [f32; 2] = [260.0, 56.0];
const PANEL: Color32 = Color32::from_rgba_premultiplied(8, 10, 14, 225);
const NAME: Color32 = Color32::from_rgb(150, 160, 175);
const VALUE: Color32 = Color32::from_rgb(235, 240, 245);
const GOOD: Color32 = Color32::from_rgb(90, 200, 120);
const LATE: Color32 = Color32::from_rgb(235, 110, 80);
const MARK: Color32 = Color32::from_rgb(250, 210, 90);

/// What is written beside the picture.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HudPage {
    /// The last frames, oldest first (milliseconds a frame).
    pub frames_ms: Vec<f32>,
    /// What a frame may take, drawn as a line across the graph.
    pub budget_ms: Option<f32>,
    /// Groups of names and values, in the upper left.
    pub facts: Vec<Vec<(String, String)>>,
    /// Keys and what they do, in the upper right.
    pub keys: Vec<(String, String)>,
    /// Something that went wrong or was just done, at the lower edge.
    pub notice: Option<String>,
}

/// Lays pages out with fonts of its own.
pub struct Hud {
    fonts: Fonts,
    shapes: Vec<ClippedShape>,
}

impl Default for Hud {
    fn default() -> Self {
        Self {
            fonts: Fonts::new(TextOptions::default(), FontDefinitions::default()),
            shapes: Vec::new(),
        }
    }
}

impl Hud {
    /// Lays `page` out for a picture of `size` pixels, `scale` of them a point, in place of what is in
    /// `overlay`.
    ///
    /// # Errors
    /// An atlas that the device cannot hold.
    pub fn lay_out(
        &mut self,
        page: &HudPage,
        size: [u32; 2],
        scale: f32,
        overlay: &mut FlatOverlay,
    ) -> Result<(), render::Error> {
        let scale = if scale.is_finite() { scale.clamp(0.5, 8.0) } else { 1.0 };
        self.fonts.begin_pass(TextOptions::default(), ViewportKey::default());
        self.shapes.clear();
        let points = size.map(|side| side as f32 / scale);
        let screen = epaint::Rect::from_min_size(pos2(0.0, 0.0), vec2(points[0], points[1]));
        self.facts(page, scale, screen);
        self.keys(page, scale, screen);
        self.notice(page, scale, screen);
        self.bring_atlas(overlay)?;

        let mut tessellator = Tessellator::new(
            scale,
            TessellationOptions::default(),
            self.fonts.font_image_size(),
            self.fonts.texture_atlas().prepared_discs(),
        );
        overlay.clear();
        for part in tessellator.tessellate_shapes(std::mem::take(&mut self.shapes)) {
            let Primitive::Mesh(mesh) = part.primitive else { continue };
            let vertices: Vec<FlatVertex> =
                mesh.vertices.iter().map(|it| vertex(it, scale)).collect();
            overlay.add([0, 0], size, &vertices, &mesh.indices);
        }
        Ok(())
    }

    /// The graph, and below it names in one column and values in the next.
    fn facts(&mut self, page: &HudPage, scale: f32, screen: epaint::Rect) {
        let row = self.row_points(scale);
        let names = page.facts.iter().flatten().map(|(name, _)| name.as_str());
        let names = self.widest(scale, names);
        let values = page.facts.iter().flatten().map(|(_, value)| value.as_str());
        let values = self.widest(scale, values);
        let graph = GRAPH_POINTS[0] + 3.0 * MARGIN_POINTS + self.widest(scale, ["1000.0 ms"]);
        let width = (names + values + 3.0 * MARGIN_POINTS).max(graph);
        let rows = page.facts.iter().map(|group| group.len() as f32 + 0.5).sum::<f32>();
        let height = GRAPH_POINTS[1] + rows * row + 3.0 * MARGIN_POINTS;
        let panel = epaint::Rect::from_min_size(pos2(0.0, 0.0), vec2(width, height));
        self.fill(screen, panel, PANEL);
        self.graph(page, scale, screen);
        let mut y = GRAPH_POINTS[1] + 2.0 * MARGIN_POINTS;
        for group in &page.facts {
            for (name, value) in group {
                self.text(scale, screen, [MARGIN_POINTS, y], name, NAME);
                self.text(scale, screen, [names + 2.0 * MARGIN_POINTS, y], value, VALUE);
                y += row;
            }
            y += row / 2.0;
        }
    }

    /// A bar a frame, as high as it took, red beyond the budget; beside it what its height stands for.
    fn graph(&mut self, page: &HudPage, scale: f32, screen: epaint::Rect) {
        let [width, height] = GRAPH_POINTS;
        let longest =
            page.frames_ms.iter().copied().filter(|ms| ms.is_finite()).fold(0.0, f32::max);
        let top_ms = longest.max(page.budget_ms.unwrap_or_default() * 1.5).max(1.0);
        let shown = (width / 2.0) as usize;
        let skipped = page.frames_ms.len().saturating_sub(shown);
        let bottom = MARGIN_POINTS + height;
        let beside = MARGIN_POINTS + width + MARGIN_POINTS;
        if longest > 0.0 {
            self.text(scale, screen, [beside, MARGIN_POINTS], &format!("{top_ms:.1} ms"), NAME);
        }
        for (place, ms) in page.frames_ms.iter().skip(skipped).enumerate() {
            if !ms.is_finite() {
                continue;
            }
            let is_late = page.budget_ms.is_some_and(|budget| *ms > budget);
            let x = MARGIN_POINTS + place as f32 * 2.0;
            let bar = epaint::Rect::from_min_max(
                pos2(x, bottom - height * (ms / top_ms).clamp(0.0, 1.0)),
                pos2(x + 1.5, bottom),
            );
            self.fill(screen, bar, if is_late { LATE } else { GOOD });
        }
        if let Some(budget) = page.budget_ms {
            let y = bottom - height * (budget / top_ms).clamp(0.0, 1.0);
            let line = [pos2(MARGIN_POINTS, y), pos2(MARGIN_POINTS + width, y)];
            let line = Shape::line_segment(line, Stroke::new(1.0, MARK));
            self.shapes.push(ClippedShape::new(screen, line));
            // Not over the text at the top.
            let row = self.row_points(scale);
            let text = [beside, (y - row / 2.0).clamp(MARGIN_POINTS + row, bottom)];
            self.text(scale, screen, text, &format!("{budget:.1} ms"), MARK);
        }
    }

    fn keys(&mut self, page: &HudPage, scale: f32, screen: epaint::Rect) {
        if page.keys.is_empty() {
            return;
        }
        let row = self.row_points(scale);
        let keys = self.widest(scale, page.keys.iter().map(|(key, _)| key.as_str()));
        let deeds = self.widest(scale, page.keys.iter().map(|(_, deed)| deed.as_str()));
        let size = vec2(
            keys + deeds + 3.0 * MARGIN_POINTS,
            page.keys.len() as f32 * row + 2.0 * MARGIN_POINTS,
        );
        let left = (screen.max.x - size.x).max(0.0);
        self.fill(screen, epaint::Rect::from_min_size(pos2(left, 0.0), size), PANEL);
        for (place, (key, deed)) in page.keys.iter().enumerate() {
            let y = MARGIN_POINTS + place as f32 * row;
            self.text(scale, screen, [left + MARGIN_POINTS, y], key, MARK);
            self.text(scale, screen, [left + keys + 2.0 * MARGIN_POINTS, y], deed, VALUE);
        }
    }

    fn notice(&mut self, page: &HudPage, scale: f32, screen: epaint::Rect) {
        let Some(notice) = &page.notice else { return };
        let wrap = (screen.width() - 4.0 * MARGIN_POINTS).max(1.0);
        let galley =
            self.fonts.with_pixels_per_point(scale).layout(notice.clone(), font(), MARK, wrap);
        let size = galley.size() + vec2(2.0 * MARGIN_POINTS, 2.0 * MARGIN_POINTS);
        let corner = pos2(MARGIN_POINTS, (screen.max.y - size.y - MARGIN_POINTS).max(0.0));
        self.fill(screen, epaint::Rect::from_min_size(corner, size), PANEL);
        let place = corner + vec2(MARGIN_POINTS, MARGIN_POINTS);
        self.shapes.push(ClippedShape::new(screen, Shape::galley(place, galley, MARK)));
    }

    fn row_points(&mut self, scale: f32) -> f32 {
        self.fonts.with_pixels_per_point(scale).row_height(&font()).max(1.0)
    }

    fn widest<'a>(&mut self, scale: f32, texts: impl IntoIterator<Item = &'a str>) -> f32 {
        let mut fonts = self.fonts.with_pixels_per_point(scale);
        let width = |text: &str| fonts.layout_no_wrap(text.to_owned(), font(), VALUE).size().x;
        texts.into_iter().map(width).fold(0.0, f32::max)
    }

    fn text(
        &mut self,
        scale: f32,
        screen: epaint::Rect,
        [x, y]: [f32; 2],
        text: &str,
        colour: Color32,
    ) {
        let mut fonts = self.fonts.with_pixels_per_point(scale);
        let galley = fonts.layout_no_wrap(text.to_owned(), font(), colour);
        self.shapes.push(ClippedShape::new(screen, Shape::galley(pos2(x, y), galley, colour)));
    }

    fn fill(&mut self, screen: epaint::Rect, area: epaint::Rect, colour: Color32) {
        self.shapes.push(ClippedShape::new(screen, Shape::rect_filled(area, 0.0, colour)));
    }

    /// Hands the glyphs on that were drawn for the first time.
    fn bring_atlas(&mut self, overlay: &mut FlatOverlay) -> Result<(), render::Error> {
        let Some(delta) = self.fonts.font_image_delta() else { return Ok(()) };
        let ImageData::Color(image) = &delta.image;
        let size = image.size.map(|side| side as u32);
        let pixels = image.pixels.iter().map(Color32::to_array);
        let Some(origin) = delta.pos else {
            overlay.begin_atlas(size)?;
            return overlay.write_atlas([0, 0], size, pixels);
        };
        overlay.write_atlas(origin.map(|side| side as u32), size, pixels)
    }
}

fn font() -> FontId {
    FontId::monospace(FONT_POINTS)
}

fn vertex(vertex: &epaint::Vertex, scale: f32) -> FlatVertex {
    FlatVertex {
        position: [vertex.pos.x * scale, vertex.pos.y * scale],
        texture_position: [vertex.uv.x, vertex.uv.y],
        colour: vertex.color.to_array(),
    }
}
