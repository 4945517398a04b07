//! The head-up display: the engine's state in numbers, a graph and signs over the image.
//!
//! A [`HudPage`] has plain values. [`Measures`] determines the size of points and the parts that
//! fit; each part draws itself on a canvas: the [overview](self), the lower edge, legends, signs,
//! and the page of keys.

mod canvas;
mod graph;
mod help;
mod layout;
mod legend;
mod level;
mod marks;
mod overview;
mod page;
mod scale;
mod signs;
mod style;
#[cfg(test)]
mod tests;
mod toast;

use antumbra::render;
use antumbra::render::{FlatOverlay, FlatVertex};
use epaint::text::{FontDefinitions, Fonts, TextOptions, ViewportKey};
use epaint::{ClippedShape, Color32, ImageData, Primitive, TessellationOptions, Tessellator};

use canvas::HudCanvas;
pub use layout::{Measures, PANEL_SHARE, Room};
pub use level::HudLevel;
pub use page::{ExactnessVerdict, Help, HudFigure, HudPage, Legend, Overview, Sign, Split};

/// The layout of pages, with fonts of its own.
pub struct Hud {
    fonts: Fonts,
}

impl Default for Hud {
    fn default() -> Self {
        Self { fonts: Fonts::new(TextOptions::default(), FontDefinitions::default()) }
    }
}

impl Hud {
    /// Lays `page` out for an image of `size` pixels, `scale` of them per point of the window,
    /// replacing the contents of `overlay`. Parts that do not fit are left out.
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
        let measures = Measures::of(size, scale);
        let shapes = self.shapes(page, size, &measures);
        self.upload_atlas(overlay)?;
        let mut tessellator = Tessellator::new(
            measures.scale,
            TessellationOptions::default(),
            self.fonts.font_image_size(),
            self.fonts.texture_atlas().prepared_discs(),
        );
        overlay.clear();
        for part in tessellator.tessellate_shapes(shapes) {
            let Primitive::Mesh(mesh) = part.primitive else { continue };
            let vertices: Vec<FlatVertex> =
                mesh.vertices.iter().map(|it| vertex(it, measures.scale)).collect();
            overlay.add([0, 0], size, &vertices, &mesh.indices);
        }
        Ok(())
    }

    /// Returns the shapes of a page, later ones over earlier ones.
    fn shapes(&mut self, page: &HudPage, size: [u32; 2], measures: &Measures) -> Vec<ClippedShape> {
        self.fonts.begin_pass(TextOptions::default(), ViewportKey::default());
        let mut canvas = HudCanvas::new(&mut self.fonts, size, measures.scale);
        signs::draw(&mut canvas, &page.signs);
        marks::draw(&mut canvas, &page.marks);
        // The panel goes down to the edge: what is said for a while is beside it and hides nothing
        // of it.
        let has_panel = page.overview.is_some() && page.help.is_none();
        let left = if has_panel { measures.panel_width } else { 0.0 };
        let bottom = toast::draw(&mut canvas, page, left);
        let is_helped =
            page.help.as_ref().and_then(|help| help::draw(&mut canvas, help, bottom)).is_some();
        // The keys are read alone: nothing is beside them.
        if !is_helped {
            let panel = overview::draw(&mut canvas, page, measures);
            let left = panel.map_or(0.0, |panel| panel.max.x);
            let mut top = 0.0;
            for legend in &page.legends {
                let area = legend::draw(&mut canvas, legend, top, left);
                top = area.filter(|_| legend.area.is_none()).map_or(top, |area| area.max.y);
            }
        }
        canvas.shapes
    }

    /// Uploads the glyphs that were drawn for the first time.
    fn upload_atlas(&mut self, overlay: &mut FlatOverlay) -> Result<(), render::Error> {
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

fn vertex(vertex: &epaint::Vertex, scale: f32) -> FlatVertex {
    FlatVertex {
        position: [vertex.pos.x * scale, vertex.pos.y * scale],
        texture_position: [vertex.uv.x, vertex.uv.y],
        colour: vertex.color.to_array(),
    }
}

/// Returns a number with its thousands separated.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}
