//! The options of edges and outlines, and their checks.

use cull::ObjectId;
use scene::EdgeRules;

use crate::error::Error;
use crate::passes::EdgeStyle;

/// The edges that are drawn, and the background that they are drawn over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EdgeMode {
    /// No edges, at no cost.
    #[default]
    Off,
    /// Visible edges on paper. Surfaces only hide.
    Visible,
    /// Visible edges, and hidden edges as dashes, on paper.
    HiddenDashed,
    /// Visible edges over the surfaces.
    Shaded,
    /// Visible edges over the surfaces, and hidden edges as dashes.
    ShadedWithHiddenDashed,
}

impl EdgeMode {
    /// Returns true if paper covers the colours of surfaces.
    pub fn is_on_paper(self) -> bool {
        matches!(self, Self::Visible | Self::HiddenDashed)
    }

    /// Returns true if hidden edges are drawn as well.
    pub fn shows_hidden(self) -> bool {
        matches!(self, Self::HiddenDashed | Self::ShadedWithHiddenDashed)
    }
}

/// The options of edges. Colours are linear red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeOptions {
    /// The edges that are drawn.
    pub mode: EdgeMode,
    /// The width of lines in pixels: above 0, at most 64.
    pub width_pixels: f32,
    /// The colour of visible edges.
    pub colour: [f32; 3],
    /// The colour of hidden edges.
    pub hidden_colour: [f32; 3],
    /// The colour of the paper.
    pub paper: [f32; 3],
    /// The length of a dash in pixels: above 0, at most 1024.
    pub dash_pixels: f32,
    /// The length of a gap between dashes in pixels: from 0 to 1024.
    pub gap_pixels: f32,
    /// The angle between two faces above which their edge is drawn in any view, in degrees: from 0
    /// to 180. An edge with a smaller angle is drawn where it is a silhouette.
    pub crease_degrees: f32,
}

impl Default for EdgeOptions {
    fn default() -> Self {
        Self {
            mode: EdgeMode::Off,
            width_pixels: 2.0,
            colour: [0.0; 3],
            hidden_colour: [0.2, 0.22, 0.25],
            paper: [1.0; 3],
            dash_pixels: 6.0,
            gap_pixels: 4.0,
            crease_degrees: EdgeRules::default().crease_degrees,
        }
    }
}

impl EdgeOptions {
    /// Returns the rules that make an edge a feature.
    pub(crate) fn rules(&self) -> EdgeRules {
        EdgeRules { crease_degrees: self.crease_degrees, ..EdgeRules::default() }
    }

    /// Returns the style of visible edges.
    pub(crate) fn visible(&self) -> EdgeStyle {
        EdgeStyle {
            width_pixels: self.width_pixels,
            colour: self.colour,
            dash_pixels: 0.0,
            gap_pixels: 0.0,
        }
    }

    /// Returns the style of hidden edges.
    pub(crate) fn hidden(&self) -> EdgeStyle {
        EdgeStyle {
            colour: self.hidden_colour,
            dash_pixels: self.dash_pixels,
            gap_pixels: self.gap_pixels,
            ..self.visible()
        }
    }
}

/// A line around objects, drawn over everything: it surrounds all pixels that the objects would
/// have if nothing hid them. Objects of one outline that overlap in the image share one line.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectOutline {
    /// The objects. An id that no object has is ignored until an object gets it.
    pub objects: Vec<ObjectId>,
    /// The colour: linear red, green and blue.
    pub colour: [f32; 3],
    /// The width of the line in pixels: above 0, at most 32.
    pub width_pixels: f32,
}

impl ObjectOutline {
    /// Returns the style of the edges, whose outer halves form the line.
    pub(crate) fn style(&self) -> EdgeStyle {
        EdgeStyle {
            width_pixels: 2.0 * self.width_pixels,
            colour: self.colour,
            dash_pixels: 0.0,
            gap_pixels: 0.0,
        }
    }
}

/// Refuses impossible options of edges.
pub(crate) fn check_edges(options: &EdgeOptions) -> Result<(), Error> {
    let rule = |is_kept, sentence| Rule { is_kept, sentence };
    refuse(&[
        rule(is_width(options.width_pixels, 64.0), "a line is above 0 and at most 64 pixels wide"),
        rule(
            is_width(options.dash_pixels, 1024.0),
            "a dash is above 0 and at most 1024 pixels long",
        ),
        rule((0.0..=1024.0).contains(&options.gap_pixels), "a gap is 0 to 1024 pixels long"),
        rule((0.0..=180.0).contains(&options.crease_degrees), "a crease angle is 0 to 180 degrees"),
        rule(
            [options.colour, options.hidden_colour, options.paper].iter().all(is_colour),
            "the parts of a colour are numbers from 0 to 1",
        ),
    ])
}

/// Refuses impossible outlines.
pub(crate) fn check_outlines(outlines: &[ObjectOutline]) -> Result<(), Error> {
    let is_wide = outlines.iter().all(|outline| is_width(outline.width_pixels, 32.0));
    let is_coloured = outlines.iter().all(|outline| is_colour(&outline.colour));
    let rule = |is_kept, sentence| Rule { is_kept, sentence };
    refuse(&[
        rule(is_wide, "an outline is above 0 and at most 32 pixels wide"),
        rule(is_coloured, "the parts of a colour are numbers from 0 to 1"),
    ])
}

/// A rule of options.
struct Rule {
    is_kept: bool,
    sentence: &'static str,
}

/// Refuses the first rule that is not kept.
fn refuse(rules: &[Rule]) -> Result<(), Error> {
    match rules.iter().find(|rule| !rule.is_kept) {
        Some(rule) => Err(Error::Edges(rule.sentence)),
        None => Ok(()),
    }
}

fn is_width(pixels: f32, most: f32) -> bool {
    pixels > 0.0 && pixels <= most
}

fn is_colour(colour: &[f32; 3]) -> bool {
    colour.iter().all(|part| (0.0..=1.0).contains(part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_options_are_refused_by_a_sentence() {
        let fine = EdgeOptions::default();
        assert!(check_edges(&fine).is_ok());
        let nan = f32::NAN;
        for options in [
            EdgeOptions { width_pixels: 0.0, ..fine },
            EdgeOptions { width_pixels: nan, ..fine },
            EdgeOptions { dash_pixels: 0.0, ..fine },
            EdgeOptions { gap_pixels: -1.0, ..fine },
            EdgeOptions { crease_degrees: 181.0, ..fine },
            EdgeOptions { colour: [0.0, nan, 0.0], ..fine },
        ] {
            let error = check_edges(&options).unwrap_err().to_string();
            assert!(error.starts_with("edges and outlines: "), "{error}");
        }
        let outline = ObjectOutline { objects: Vec::new(), colour: [1.0; 3], width_pixels: 33.0 };
        assert!(check_outlines(&[outline]).is_err());
    }
}
