//! The contents of the HUD over an image, as plain values.

use antumbra::render::Rect;
use bench::legend::LegendEntry;

/// The contents of the HUD over one image.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HudPage {
    /// The most important numbers, in the upper left.
    pub overview: Option<Overview>,
    /// Groups of names and values below the overview, the most important first.
    pub details: Vec<Vec<(String, String)>>,
    /// The meaning of the colours in the image.
    pub legends: Vec<Legend>,
    /// Areas to outline: left, top, right and bottom edge in pixels.
    pub marks: Vec<[u32; 4]>,
    /// Signs that are understood without reading.
    pub signs: Vec<Sign>,
    /// All keys, over the middle of the image.
    pub help: Option<Help>,
    /// The answer to a request, above the lower edge.
    pub asked: Option<HudAnswer>,
    /// A message about an error or a finished action, at the lower edge.
    pub toast: Option<String>,
    /// The scene that is loading, and its finished fraction (0 to 1, if known), shown as a bar in
    /// place of the toast.
    pub progress: Option<(String, Option<f32>)>,
}

/// The most important numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overview {
    /// The name of the scene.
    pub scene: String,
    /// The strategy that decides about draws.
    pub strategy: String,
    /// The frames per second.
    pub rate: HudFigure,
    /// The time from frame to frame.
    pub frame_time: HudFigure,
    /// The last frames, oldest first (milliseconds per frame).
    pub frames_ms: Vec<f32>,
    /// The kind of frames in `frames_ms`, as a caption.
    pub caption: &'static str,
    /// The budget of a frame (milliseconds), drawn as a line across the graph.
    pub budget_ms: Option<f32>,
    /// Objects: of the scene, in the frustum, drawn.
    pub objects: [HudFigure; 3],
    /// The numbers of drawn and culled objects in the frustum.
    pub split: Option<Split>,
    /// The times of the GPU and of the CPU.
    pub times: [HudFigure; 2],
    /// The claim about the correctness of the image.
    pub verdict: ExactnessVerdict,
    /// The keys to try next, as a text.
    pub hint: String,
}

/// A number and its name.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HudFigure {
    /// The number with its unit, as text.
    pub value: String,
    /// The quantity.
    pub name: &'static str,
}

/// The objects in the frustum: the sum of `drawn` and `culled`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Split {
    /// The number of drawn objects.
    pub drawn: u64,
    /// The number of objects that are left out because they are occluded.
    pub culled: u64,
}

/// A claim whether the image equals the image without occlusion culling.
#[derive(Debug, Clone, PartialEq)]
pub enum ExactnessVerdict {
    /// The images are equal, for this reason.
    Exact(String),
    /// The images may differ, for this reason.
    Inexact(String),
    /// Nothing is claimed, for this reason; empty before the first image.
    Unclaimed(String),
}

impl Default for ExactnessVerdict {
    fn default() -> Self {
        Self::Unclaimed(String::new())
    }
}

/// The meaning of some colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    /// The subject of the colours.
    pub title: &'static str,
    /// Colours and their meanings.
    pub entries: Vec<LegendEntry>,
    /// The part of the image that the legend explains, with the legend in its upper left; `None`
    /// for the whole image, with the legend in the upper right.
    pub area: Option<Rect>,
}

/// A state that a frame and a badge show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// The culling is frozen.
    Frozen,
    /// The path of the camera is being recorded.
    Recording,
    /// A screenshot was taken.
    Screenshot,
}

/// The keys, in groups.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Help {
    /// The titles of the groups, and their keys with descriptions.
    pub groups: Vec<(&'static str, Vec<(String, String)>)>,
}

/// The answer to a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum HudAnswer {
    /// Rows of text, or a text field.
    Rows(String),
    /// A list to choose from.
    List(ChoiceList),
}

/// A list to choose from.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ChoiceList {
    /// The title above the rows.
    pub title: String,
    /// The names and descriptions of the rows; descriptions may be empty.
    pub rows: Vec<(String, String)>,
    /// The index of the selected row.
    pub selected: usize,
}
