//! What is written and drawn over a picture, from plain values.

use bench::legend::LegendEntry;
use render::Rect;

/// Everything that is shown over one picture.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HudPage {
    /// The most important numbers, in the upper left.
    pub overview: Option<Overview>,
    /// Groups of names and values below the overview, the most important first.
    pub details: Vec<Vec<(String, String)>>,
    /// The meaning of the colours that are shown.
    pub legends: Vec<Legend>,
    /// Areas to outline: left, top, right and bottom edge in pixels.
    pub marks: Vec<[u32; 4]>,
    /// What goes on that must be seen without reading.
    pub signs: Vec<Sign>,
    /// All keys, over the middle of the picture.
    pub help: Option<Help>,
    /// What was asked for: a list or field, or rows about something, above what is at the lower
    /// edge.
    pub asked: Option<String>,
    /// Something that went wrong or was just done, at the lower edge.
    pub toast: Option<String>,
    /// What is on its way, and how much of it is done (0 to 1, where that is known): a bar in place
    /// of the toast.
    pub progress: Option<(String, Option<f32>)>,
}

/// The numbers that a person looks for first.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overview {
    /// The scene.
    pub scene: String,
    /// The strategy that decides what is drawn.
    pub strategy: String,
    /// Frames a second.
    pub rate: Figure,
    /// Time from frame to frame.
    pub frame_time: Figure,
    /// The last frames, oldest first (milliseconds a frame).
    pub frames_ms: Vec<f32>,
    /// What `frames_ms` are of, as a caption.
    pub caption: &'static str,
    /// What a frame may take (milliseconds), drawn as a line across the graph.
    pub budget_ms: Option<f32>,
    /// Objects: of the scene, in the frustum, drawn.
    pub objects: [Figure; 3],
    /// How many of those in the frustum are drawn, and how many are not.
    pub split: Option<Split>,
    /// Time of the GPU and of the CPU.
    pub times: [Figure; 2],
    /// Whether the picture is right.
    pub verdict: Verdict,
    /// The keys that lead on.
    pub hint: String,
}

/// A number and what it is.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Figure {
    /// The number.
    pub value: String,
    /// What it counts or measures.
    pub name: &'static str,
}

/// The objects in the frustum: `drawn + culled` are all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Split {
    /// Those that are drawn.
    pub drawn: u64,
    /// Those that are occluded and left out.
    pub culled: u64,
}

/// Whether the picture equals the one without occlusion culling.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Verdict {
    /// It does, and why.
    Exact(String),
    /// It may not, and why.
    Inexact(String),
    /// There is no picture yet.
    #[default]
    Unknown,
}

/// The meaning of some colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    /// What is coloured.
    pub title: &'static str,
    /// Colours and their meanings.
    pub entries: Vec<LegendEntry>,
    /// The part of the picture that it explains: it is in the upper left of that; `None` for the
    /// whole picture, where it is in the upper right.
    pub area: Option<Rect>,
}

/// What goes on, shown by a frame and a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// The culling stands still.
    Frozen,
    /// The camera's path is recorded.
    Recording,
    /// A screenshot was taken.
    Screenshot,
}

/// The keys, in groups.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Help {
    /// What the groups are about, and their keys with what they do.
    pub groups: Vec<(&'static str, Vec<(String, String)>)>,
}
