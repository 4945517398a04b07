//! What the engine thinks, in text and a graph over the picture.

mod arrange;

use std::sync::Arc;

use epaint::text::{FontDefinitions, FontId, Fonts, TextOptions, ViewportKey};
use epaint::{
    ClippedShape, Color32, Galley, ImageData, Primitive, Shape, Stroke, TessellationOptions,
    Tessellator, pos2, vec2,
};
use render::{FlatOverlay, FlatVertex};

use arrange::{MARGIN, Places, Sizes};

const FONT_POINTS: f32 = 12.5;
/// Sizes of text to try, the largest with room first: of what is usual.
const TEXT_SIZES: [f32; 4] = [1.0, 0.88, 0.76, 0.66];
/// So many groups are worth more than the list of keys.
const FEW_GROUPS: usize = 2;
const MORE: &str = "a larger window shows more";
const BAR_POINTS: [f32; 2] = [320.0, 10.0];
const GRAPH_POINTS: [f32; 2] = [260.0, 56.0];
const PANEL: Color32 = Color32::from_rgba_premultiplied(7, 8, 12, 200);
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
    /// Groups of names and values, the most important first, in the upper left.
    pub facts: Vec<Vec<(String, String)>>,
    /// Keys and what they do, in the upper right.
    pub keys: Vec<(String, String)>,
    /// Something that went wrong or was just done, at the lower edge. Nothing else is there.
    pub notice: Option<String>,
    /// What is on its way, and how much of it is done (0 to 1, where that is known): a bar in place of the
    /// notice.
    pub progress: Option<(String, Option<f32>)>,
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

/// Whether there is room for the keys.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Keys {
    Listed,
    LeftOut,
}

/// What of a page there is room for, and where.
struct Fitted {
    places: Places,
    sizes: Sizes,
    /// Points are so many pixels.
    scale: f32,
    /// Groups that are shown.
    kept: usize,
}

impl Hud {
    /// Lays `page` out for a picture of `size` pixels, `scale` of them a point, in place of what is in
    /// `overlay`. Where it would hide much of the picture, text gets smaller, down to two thirds; then
    /// the least important parts are left out.
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
        let size_in = |scale: f32| size.map(|side| side as f32 / scale);
        let fitted = self.fit(page, scale, size);
        let scale = fitted.as_ref().map_or(scale * TEXT_SIZES[TEXT_SIZES.len() - 1], |it| it.scale);
        let [width, height] = size_in(scale);
        let screen = epaint::Rect::from_min_size(pos2(0.0, 0.0), vec2(width, height));
        // A notice alone has no panel beside it.
        if let (Some(fitted), false) = (&fitted, page.facts.is_empty()) {
            self.facts(page, fitted, screen);
            self.keys(page, fitted, screen);
        }
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

    /// The first of all ways to show less that there is room for.
    fn fit(&mut self, page: &HudPage, scale: f32, size: [u32; 2]) -> Option<Fitted> {
        let smallest = TEXT_SIZES[TEXT_SIZES.len() - 1];
        let groups = page.facts.len();
        let whole = TEXT_SIZES.map(|text| (text, groups, Keys::Listed));
        let with_keys = (FEW_GROUPS..groups).rev().map(|kept| (smallest, kept, Keys::Listed));
        let without = (1..=groups).rev().map(|kept| (smallest, kept, Keys::LeftOut));
        whole.into_iter().chain(with_keys).chain(without).find_map(|(text, kept, keys)| {
            let scale = scale * text;
            let screen = size.map(|side| side as f32 / scale);
            let sizes = self.sizes(page, scale, screen[0], (kept, keys));
            let places = sizes.arrange(screen)?;
            Some(Fitted { places, sizes, scale, kept })
        })
    }

    fn sizes(
        &mut self,
        page: &HudPage,
        scale: f32,
        width: f32,
        (kept, keys): (usize, Keys),
    ) -> Sizes {
        let row = self.row_points(scale);
        let letter = self.letter_points(scale);
        let long = |text: &str| text.chars().count() as f32 * letter;
        let both = |texts: &[(String, String)]| {
            let widest = |(a, b): (f32, f32), it: &(String, String)| {
                (a.max(long(&it.0)), b.max(long(&it.1)))
            };
            texts.iter().fold((0.0, 0.0), widest)
        };
        let group = |facts: &Vec<(String, String)>| {
            let (names, values) = both(facts);
            (names, values, facts.len())
        };
        let mut groups: Vec<_> = page.facts.iter().take(kept).map(group).collect();
        let listed = (keys == Keys::Listed && !page.keys.is_empty()).then(|| {
            let (keys, deeds) = both(&page.keys);
            [keys + deeds + MARGIN, page.keys.len() as f32 * row]
        });
        if kept < page.facts.len() || (listed.is_none() && !page.keys.is_empty()) {
            groups.push((long(MORE), 0.0, 1));
        }
        // There is always room for a short one, so that it moves nothing.
        let notice = self.notice_text(page, scale, width).map_or(row, |text| text.size().y);
        let notice = if page.progress.is_some() { row + MARGIN + BAR_POINTS[1] } else { notice };
        Sizes {
            row,
            graph: [GRAPH_POINTS[0] + MARGIN + long("1000.0 ms"), GRAPH_POINTS[1]],
            groups,
            keys: listed,
            notice_height: notice + 4.0 * MARGIN,
        }
    }

    /// The graph, and below it names in one column and values in the next.
    fn facts(&mut self, page: &HudPage, fitted: &Fitted, screen: epaint::Rect) {
        let Fitted { places, sizes, scale, kept } = fitted;
        let [width, height] = places.panel;
        let panel = epaint::Rect::from_min_size(pos2(0.0, 0.0), vec2(width, height));
        self.fill(screen, panel, PANEL);
        self.graph(page, *scale, screen);
        for (group, [names, values]) in page.facts.iter().take(*kept).zip(&places.groups) {
            for (place, (name, value)) in group.iter().enumerate() {
                let down = place as f32 * sizes.row;
                self.text(*scale, screen, [names[0], names[1] + down], name, NAME);
                self.text(*scale, screen, [values[0], values[1] + down], value, VALUE);
            }
        }
        if let Some([more, _]) = places.groups.get(*kept) {
            self.text(*scale, screen, *more, MORE, MARK);
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
        let bottom = MARGIN + height;
        let beside = MARGIN + width + MARGIN;
        if longest > 0.0 {
            self.text(scale, screen, [beside, MARGIN], &format!("{top_ms:.1} ms"), NAME);
        }
        for (place, ms) in page.frames_ms.iter().skip(skipped).enumerate() {
            if !ms.is_finite() {
                continue;
            }
            let is_late = page.budget_ms.is_some_and(|budget| *ms > budget);
            let x = MARGIN + place as f32 * 2.0;
            let bar = epaint::Rect::from_min_max(
                pos2(x, bottom - height * (ms / top_ms).clamp(0.0, 1.0)),
                pos2(x + 1.5, bottom),
            );
            self.fill(screen, bar, if is_late { LATE } else { GOOD });
        }
        if let Some(budget) = page.budget_ms {
            let y = bottom - height * (budget / top_ms).clamp(0.0, 1.0);
            let line = [pos2(MARGIN, y), pos2(MARGIN + width, y)];
            let line = Shape::line_segment(line, Stroke::new(1.0, MARK));
            self.shapes.push(ClippedShape::new(screen, line));
            // Not over the text at the top.
            let row = self.row_points(scale);
            let text = [beside, (y - row / 2.0).clamp(MARGIN + row, bottom)];
            self.text(scale, screen, text, &format!("{budget:.1} ms"), MARK);
        }
    }

    fn keys(&mut self, page: &HudPage, fitted: &Fitted, screen: epaint::Rect) {
        let Fitted { places, sizes, scale, .. } = fitted;
        let (Some([left, top]), Some([width, height])) = (places.keys, sizes.keys) else { return };
        let size = vec2(width + 2.0 * MARGIN, height + 2.0 * MARGIN);
        self.fill(screen, epaint::Rect::from_min_size(pos2(left, top), size), PANEL);
        let longest = page.keys.iter().map(|(key, _)| key.chars().count()).max().unwrap_or(0);
        let deeds = left + longest as f32 * self.letter_points(*scale) + 2.0 * MARGIN;
        for (place, (key, deed)) in page.keys.iter().enumerate() {
            let y = top + MARGIN + place as f32 * sizes.row;
            self.text(*scale, screen, [left + MARGIN, y], key, MARK);
            self.text(*scale, screen, [deeds, y], deed, VALUE);
        }
    }

    /// A bar, and above it what is on its way.
    fn progress(&mut self, page: &HudPage, scale: f32, screen: epaint::Rect) -> bool {
        let Some((what, fraction)) = &page.progress else { return false };
        let row = self.row_points(scale);
        let width = BAR_POINTS[0].min(screen.width() - 4.0 * MARGIN).max(1.0);
        let text = what.chars().count() as f32 * self.letter_points(scale);
        let widest = (screen.width() - 2.0 * MARGIN).max(1.0);
        let panel =
            vec2((width.max(text) + 2.0 * MARGIN).min(widest), row + BAR_POINTS[1] + 3.0 * MARGIN);
        let corner = pos2(MARGIN, (screen.max.y - panel.y - MARGIN).max(0.0));
        self.fill(screen, epaint::Rect::from_min_size(corner, panel), PANEL);
        let place = corner + vec2(MARGIN, MARGIN);
        self.text(scale, screen, place.into(), what, MARK);
        let bar = place + vec2(0.0, row + MARGIN);
        let whole = vec2(width, BAR_POINTS[1]);
        self.fill(screen, epaint::Rect::from_min_size(bar, whole), NAME);
        let done = fraction.unwrap_or_default().clamp(0.0, 1.0);
        let done = vec2(width * done, BAR_POINTS[1]);
        self.fill(screen, epaint::Rect::from_min_size(bar, done), GOOD);
        true
    }

    fn notice(&mut self, page: &HudPage, scale: f32, screen: epaint::Rect) {
        if self.progress(page, scale, screen) {
            return;
        }
        let Some(galley) = self.notice_text(page, scale, screen.width()) else { return };
        let size = galley.size() + vec2(2.0 * MARGIN, 2.0 * MARGIN);
        let corner = pos2(MARGIN, (screen.max.y - size.y - MARGIN).max(0.0));
        self.fill(screen, epaint::Rect::from_min_size(corner, size), PANEL);
        let place = corner + vec2(MARGIN, MARGIN);
        self.shapes.push(ClippedShape::new(screen, Shape::galley(place, galley, MARK)));
    }

    /// The notice in as many rows as it takes in a picture that is so wide.
    fn notice_text(&mut self, page: &HudPage, scale: f32, width: f32) -> Option<Arc<Galley>> {
        let text = page.notice.clone()?;
        let wrap = (width - 4.0 * MARGIN).max(1.0);
        Some(self.fonts.with_pixels_per_point(scale).layout(text, font(), MARK, wrap))
    }

    fn row_points(&mut self, scale: f32) -> f32 {
        self.fonts.with_pixels_per_point(scale).row_height(&font()).max(1.0)
    }

    /// All letters are as wide.
    fn letter_points(&mut self, scale: f32) -> f32 {
        const SAMPLE: &str = "0123456789";
        let mut fonts = self.fonts.with_pixels_per_point(scale);
        let width = fonts.layout_no_wrap(SAMPLE.to_owned(), font(), VALUE).size().x;
        width / SAMPLE.len() as f32
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
