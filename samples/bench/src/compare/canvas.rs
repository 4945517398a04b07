//! A picture to draw plots on: an SVG that follows the reader's light or dark mode.

use plotters::coord::Shift;
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::prelude::{
    DrawingArea, IntoDrawingArea, IntoFont, SVGBackend, ShapeStyle, TextStyle,
};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use thiserror::Error;

use super::palette::{self, Colour};

/// A position in a picture, from its upper left corner.
pub type Pixel = (i32, i32);

/// The error of a picture that could not be drawn.
#[derive(Debug, Error)]
#[error("a plot could not be drawn: {0}")]
pub struct DrawError(String);

/// The alignment of a text to its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// The text begins there.
    Left,
    /// The text is centred there.
    Centre,
    /// The text ends there.
    Right,
}

/// The size of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Ticks and notes.
    Small,
    /// Labels.
    Normal,
    /// Titles, bold.
    Title,
}

/// A part of a picture that is drawn on.
pub struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
}

/// Draws a picture of `width` by `height` pixels and returns its SVG.
///
/// # Errors
/// When it cannot be drawn.
pub fn picture(
    (width, height): (u32, u32),
    description: &str,
    draw: impl FnOnce(&Canvas<'_>) -> Result<(), DrawError>,
) -> Result<String, DrawError> {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
    area.fill(&palette::BACKGROUND.rgb()).map_err(failed)?;
    let canvas = Canvas { area };
    draw(&canvas)?;
    canvas.area.present().map_err(failed)?;
    drop(canvas);
    let Some(after_tag) = svg.find('>').map(|end| end + 1) else {
        return Err(DrawError("the picture is empty".to_owned()));
    };
    let style = format!(
        "\n<title>{}</title>\n<style>{}</style>",
        escaped(description),
        palette::style_sheet()
    );
    svg.insert_str(after_tag, &style);
    Ok(svg)
}

/// Returns the text escaped for XML and HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn failed(error: impl std::fmt::Display) -> DrawError {
    DrawError(error.to_string())
}

impl Canvas<'_> {
    /// Returns width and height in pixels.
    pub fn size(&self) -> (i32, i32) {
        let (width, height) = self.area.dim_in_pixel();
        (i32::try_from(width).unwrap_or(i32::MAX), i32::try_from(height).unwrap_or(i32::MAX))
    }

    /// Returns the parts left and right of a vertical line.
    pub fn split_at(&self, x: i32) -> (Self, Self) {
        let (left, right) = self.area.split_horizontally(x);
        (Self { area: left }, Self { area: right })
    }

    /// Draws a line through points.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn line(&self, points: Vec<Pixel>, colour: Colour, width: u32) -> Result<(), DrawError> {
        let style = ShapeStyle { stroke_width: width, ..colour.rgb().into() };
        self.area.draw(&PathElement::new(points, style)).map_err(failed)
    }

    /// Draws a filled circle with an edge of the background's colour.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn dot(&self, place: Pixel, radius: i32, colour: Colour) -> Result<(), DrawError> {
        let edge = palette::BACKGROUND.rgb().filled();
        self.area.draw(&Circle::new(place, radius + 2, edge)).map_err(failed)?;
        self.area.draw(&Circle::new(place, radius, colour.rgb().filled())).map_err(failed)
    }

    /// Draws a filled rectangle between two corners.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn bar(&self, corners: [Pixel; 2], colour: Colour) -> Result<(), DrawError> {
        self.area.draw(&Rectangle::new(corners, colour.rgb().filled())).map_err(failed)
    }

    /// Draws a line of text, centred vertically at its place.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn text(
        &self,
        text: &str,
        place: Pixel,
        (align, size): (Align, Size),
        colour: Colour,
    ) -> Result<(), DrawError> {
        // The backend writes them 1.24 times smaller.
        let font = match size {
            Size::Small => ("sans-serif", 15.5).into_font(),
            Size::Normal => ("sans-serif", 17.4).into_font(),
            Size::Title => ("sans-serif", 19.8).into_font().style(plotters::style::FontStyle::Bold),
        };
        let horizontal = match align {
            Align::Left => HPos::Left,
            Align::Centre => HPos::Center,
            Align::Right => HPos::Right,
        };
        let colour = colour.rgb();
        let style = TextStyle::from(font).color(&colour).pos(Pos::new(horizontal, VPos::Center));
        self.area.draw_text(text, &style, place).map_err(failed)
    }
}
