//! A picture to draw charts on: an SVG that follows the reader's light or dark mode.

use plotters::coord::Shift;
use plotters::prelude::{
    DrawingArea, DrawingAreaErrorKind, FontStyle, IntoDrawingArea, IntoFont, SVGBackend, TextStyle,
};
use thiserror::Error;

use super::palette::{self, Colour};
use crate::result_page::escaped;
use crate::run_error::RunError;

/// A part of a picture that is drawn on.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The error of a picture that could not be drawn.
#[derive(Debug, Error)]
#[error("a plot could not be drawn: {0}")]
pub struct DrawError(#[from] DrawingAreaErrorKind<std::io::Error>);

impl From<DrawError> for RunError {
    fn from(error: DrawError) -> Self {
        Self::machine(error)
    }
}

/// Draws a picture of `size` in pixels and returns its SVG.
///
/// # Errors
/// When it cannot be drawn.
pub fn picture(
    size: (u32, u32),
    description: &str,
    draw: impl FnOnce(&Area<'_>) -> Result<(), DrawError>,
) -> Result<String, DrawError> {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
    area.fill(&palette::BACKGROUND.rgb())?;
    draw(&area)?;
    area.present()?;
    drop(area);
    let title = escaped(description);
    let style = palette::style_sheet();
    Ok(svg.replacen('>', &format!(">\n<title>{title}</title>\n<style>{style}</style>"), 1))
}

/// Returns the style of labels in a colour.
pub fn label(colour: Colour) -> TextStyle<'static> {
    // The backend writes sizes 1.24 times smaller.
    ("sans-serif", 15.5).into_font().color(&colour.rgb())
}

/// Returns the style of the title of a chart.
pub fn title() -> TextStyle<'static> {
    ("sans-serif", 19.8).into_font().style(FontStyle::Bold).color(&palette::INK.rgb())
}
