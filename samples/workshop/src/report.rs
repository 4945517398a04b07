//! The report of a script: the outcome of each command, as JSON.

use bench::transparency::{FragmentsReport, TransparencyReport};
use serde::Serialize;

/// The report of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScriptReport {
    /// The version of this format.
    pub version: u32,
    /// The name of the model.
    pub model: String,
    /// The device that drew the model.
    pub device: String,
    /// The number of parts.
    pub parts: u64,
    /// The number of triangles.
    pub triangles: u64,
    /// The commands in their order.
    pub steps: Vec<ScriptStep>,
    /// The method of transparency; absent unless fragments were requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transparency: Option<TransparencyReport>,
    /// The number of messages of the validation layers.
    pub validation_messages: u64,
}

/// A command and its outcome.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScriptStep {
    /// The command, as written in the script.
    pub command: String,
    /// The outcome.
    #[serde(flatten)]
    pub outcome: CommandOutcome,
}

/// The outcome of a command.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CommandOutcome {
    /// The command was carried out.
    Done,
    /// The command was impossible, for this reason. Nothing has changed.
    Refused(String),
    /// The machine failed, for this reason. The script ended at this command.
    Failed(String),
    /// The part under a pixel; `None` if there is none.
    Picked(Option<PickedPoint>),
    /// The selected parts.
    Selected(Vec<String>),
    /// The lid was turned.
    Lid(LidTurn),
    /// The parts were moved apart.
    Exploded {
        /// The least gap between the boxes of two parts, along the axis with the largest gap, in
        /// millimetres; `None` for a single part.
        least_gap_mm: Option<f64>,
    },
    /// A distance was measured.
    Distance {
        /// The distance, in millimetres; `None` if there is no part under one of the pixels.
        distance_mm: Option<f64>,
    },
    /// An edge of the model was measured.
    Edge {
        /// The length from corner to corner, in millimetres; `None` if no edge is near.
        length_mm: Option<f64>,
    },
    /// The drawing of edges was changed.
    Edges {
        /// The stage that widens lines on this device; absent if no edges are drawn.
        #[serde(skip_serializing_if = "Option::is_none")]
        path: Option<String>,
    },
    /// Curved parts were tessellated.
    Tessellated {
        /// The number of their triangles.
        triangles: u64,
        /// The method by which the device computed them.
        path: String,
    },
    /// Frames were drawn.
    Played {
        /// The number of frames.
        frames: u32,
    },
    /// An image was written.
    Image {
        /// The file.
        file: String,
        /// The parts that own a pixel of the image.
        visible: Vec<String>,
        /// The fragments of its transparent parts; absent if fragments are not sorted.
        #[serde(skip_serializing_if = "Option::is_none")]
        fragments: Option<FragmentsReport>,
        /// A sentence about missing fragments and the remedy; absent if none are missing.
        #[serde(skip_serializing_if = "Option::is_none")]
        inexact: Option<String>,
    },
    /// A model was written.
    Exported {
        /// The file.
        file: String,
        /// The size in bytes.
        bytes: u64,
        /// A sentence about shown parts that are missing in the file; absent if none are missing.
        #[serde(skip_serializing_if = "Option::is_none")]
        left_out: Option<String>,
    },
}

/// Returns a sentence about fragments of transparent parts that were not blended, with the remedy;
/// `None` if all were.
pub fn not_blended(fragments: &FragmentsReport) -> Option<String> {
    let FragmentsReport { without_room, left_out, .. } = *fragments;
    let without_room = (without_room > 0).then(|| {
        format!("{without_room} fragments of ghosts found no room: more --fragments-per-pixel help, as far as a buffer of the device has room")
    });
    let left_out = (left_out > 0).then(|| {
        format!("{left_out} fragments of ghosts lie behind too many others: ghost fewer parts")
    });
    let sentences: Vec<String> = without_room.into_iter().chain(left_out).collect();
    (!sentences.is_empty()).then(|| sentences.join("; "))
}

impl CommandOutcome {
    /// Returns the reason why the command failed or is incomplete, if there is one.
    pub fn failure(&self) -> Option<&str> {
        match self {
            Self::Refused(reason) => Some(reason),
            Self::Image { inexact, .. } => inexact.as_deref(),
            _ => None,
        }
    }

    /// Returns the outcome as a sentence for the user, unless the image shows it.
    pub fn sentence(&self) -> Option<String> {
        match self {
            Self::Done | Self::Played { .. } | Self::Picked(_) => None,
            Self::Refused(reason) | Self::Failed(reason) => Some(reason.clone()),
            Self::Selected(names) => match &names[..] {
                [] => None,
                [name] => Some(name.clone()),
                names => Some(format!("{} parts are selected", names.len())),
            },
            Self::Lid(LidTurn { degrees, contact: None }) => {
                Some(format!("lid at {degrees:.1}\u{b0}"))
            }
            Self::Lid(LidTurn { degrees, contact: Some([moving, fixed]) }) => {
                Some(format!("lid at {degrees:.1}\u{b0}: the {moving} touches the {fixed}"))
            }
            Self::Exploded { least_gap_mm } => {
                least_gap_mm.map(|gap_mm| format!("least gap {gap_mm:.3} mm"))
            }
            Self::Distance { distance_mm: Some(distance_mm) } => {
                Some(format!("distance {distance_mm:.3} mm"))
            }
            Self::Distance { distance_mm: None } => Some("no part is there".to_owned()),
            Self::Edge { length_mm: Some(length_mm) } => Some(format!("edge {length_mm:.3} mm")),
            Self::Edge { length_mm: None } => Some("no edge is there".to_owned()),
            Self::Edges { path } => path.as_ref().map(|path| format!("edges by {path}")),
            Self::Tessellated { triangles, path } => {
                Some(format!("{triangles} triangles by {path}"))
            }
            Self::Image { file, inexact: but, .. } | Self::Exported { file, left_out: but, .. } => {
                let but = but.iter().map(|but| format!("; {but}"));
                Some(format!("wrote {file}{}", but.collect::<String>()))
            }
        }
    }
}

/// A point of a part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PickedPoint {
    /// The name of the part.
    pub part: String,
    /// The point in the world, in millimetres.
    pub point_mm: [f64; 3],
}

/// The end of a turn of the lid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LidTurn {
    /// The angle, in degrees; 0 is closed.
    pub degrees: f32,
    /// The parts in contact: a part of the lid, and a fixed one.
    pub contact: Option<[String; 2]>,
}
