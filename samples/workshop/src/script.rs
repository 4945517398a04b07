//! Scripts: a command per line, in order. Empty lines and lines that begin with `#` are ignored.
//!
//! The names of parts and groups may contain spaces: they extend to the end of the line. Lengths
//! are in millimetres, angles in degrees, and pixels count from the upper left.

use std::path::{Path, PathBuf};

use antumbra::ObjectId;
use antumbra::cull::{SectionMember, SectionMode, SectionPlanes};
use antumbra::glam::DVec3;
use antumbra::render::{DebugOverlay, EdgeMode};
use bench::input_file;
use bench::options::UsageError;
use bench::section_args::{PlaneList, parse_planes};
use bench::terminal::shown;

use crate::document::Display;
use crate::orbit::{CubeView, OrbitCamera};

/// The largest gap of an exploded view: a kilometre, beyond which coordinates lose millimetres.
const MOST_GAP_MM: f32 = 1.0e6;

/// The largest script that is accepted.
const MOST_BYTES: u64 = 4 << 20;

/// A pixel of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pixel {
    /// The column, from the left.
    pub x: u32,
    /// The row, from the top.
    pub y: u32,
}

/// An action of the user.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Selects the part under a pixel, or clears the selection if there is none.
    Pick(Pixel),
    /// Selects a part or a group by its name.
    Select(String),
    /// Clears the selection.
    Deselect,
    /// Hides the selection, or a part by its name.
    Hide(Option<String>),
    /// Shows a part by its name, or all parts.
    Show(Option<String>),
    /// Hides everything except the selection.
    Isolate,
    /// Shows the selection, or a part by its name, transparent.
    Ghost(Option<String>),
    /// Turns the lid towards an angle until it touches something.
    Lid {
        /// The angle, in degrees; 0 is closed.
        degrees: f32,
    },
    /// Moves all shown parts apart.
    Explode {
        /// The least gap between their boxes, in millimetres.
        gap_mm: f32,
    },
    /// Moves all parts back to their places.
    Assemble,
    /// Measures the distance between the points under two pixels.
    Distance {
        /// The pixel of one point.
        from: Pixel,
        /// The pixel of the other point.
        to: Pixel,
    },
    /// Measures the edge of the model near the point under a pixel.
    Edge(Pixel),
    /// Changes the drawing of edges.
    Edges(EdgeMode),
    /// Changes the debug overlay.
    Overlay(DebugOverlay),
    /// Changes the section planes.
    Section(SectionPlanes),
    /// Changes how section planes affect a part or a group by its name, or the selection.
    Member {
        /// The effect of section planes.
        member: SectionMember,
        /// The name.
        name: Option<String>,
    },
    /// Turns the camera to a view of the cube.
    View(CubeView),
    /// Moves the camera. Only windows and animations use this, not scripts.
    Camera(OrbitCamera),
    /// Selects objects; used by windows.
    SelectObjects(Vec<ObjectId>),
    /// Changes the display of objects; used by windows.
    DisplayObjects {
        /// The objects.
        objects: Vec<ObjectId>,
        /// The display.
        display: Display,
    },
    /// Measures the distance between two seen points, in metres.
    DistanceOfPoints {
        /// One point.
        from: DVec3,
        /// The other point.
        to: DVec3,
    },
    /// Measures the edge of an object near a seen point of it.
    EdgeOfObject {
        /// The object.
        object: ObjectId,
        /// The point, in metres.
        point: DVec3,
    },
    /// Changes the projection: 0 is perspective, 1 orthographic.
    Flatness(f32),
    /// Tessellates curved parts for the image.
    Tessellate {
        /// The wanted length of the sides of their triangles, in pixels.
        piece_px: f32,
    },
    /// Moves the camera so that everything shown is visible.
    Fit,
    /// Plays the camera's path once, in a number of frames.
    Play {
        /// The number of frames.
        frames: u32,
    },
    /// Writes an image.
    Image(PathBuf),
    /// Writes everything shown, in its place, as a binary glTF file.
    Export(PathBuf),
}

impl Command {
    /// Parses a command.
    ///
    /// # Errors
    /// The error in the line, and what is expected.
    pub fn parse(line: &str) -> Result<Self, String> {
        let (verb, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        let name = || (!rest.is_empty()).then(|| rest.to_owned());
        let nothing = |command: Self| {
            if rest.is_empty() {
                Ok(command)
            } else {
                Err(format!("'{verb}' takes nothing, not '{rest}'"))
            }
        };
        match verb {
            "pick" => pixels::<1>(rest).map(|[at]| Self::Pick(at)),
            "select" => {
                name().map(Self::Select).ok_or("'select' takes the name of a part".to_owned())
            }
            "deselect" => nothing(Self::Deselect),
            "hide" => Ok(Self::Hide(name())),
            "show" => Ok(Self::Show(name())),
            "isolate" => nothing(Self::Isolate),
            "ghost" => Ok(Self::Ghost(name())),
            "lid" => number(rest, "an angle in degrees").map(|degrees| Self::Lid { degrees }),
            "explode" => {
                let gap_mm = number(rest, "a gap in millimetres")?;
                if !(0.0..=MOST_GAP_MM).contains(&gap_mm) {
                    return Err(format!("a gap is 0 to {MOST_GAP_MM} mm, not {gap_mm}"));
                }
                Ok(Self::Explode { gap_mm })
            }
            "assemble" => nothing(Self::Assemble),
            "distance" => pixels::<2>(rest).map(|[from, to]| Self::Distance { from, to }),
            "edge" => pixels::<1>(rest).map(|[at]| Self::Edge(at)),
            "edges" => edge_mode(rest).map(Self::Edges),
            "depth-complexity" => depth_complexity(rest).map(Self::Overlay),
            "section" => section(rest).map(Self::Section),
            "whole" => Ok(Self::Member { member: SectionMember::Whole, name: name() }),
            "cut" => Ok(Self::Member { member: SectionMember::Cut, name: name() }),
            "view" => CubeView::named(rest).map(Self::View).ok_or_else(|| {
                format!("'{rest}' is not a view: front, top-left, back-bottom-right, ..., or iso")
            }),
            "projection" => match rest {
                "perspective" => Ok(Self::Flatness(0.0)),
                "orthographic" => Ok(Self::Flatness(1.0)),
                _ => Err(format!("a projection is perspective or orthographic, not '{rest}'")),
            },
            "tessellate" => {
                let piece_px = number(rest, "a length in pixels")?;
                if !(0.25..=10_000.0).contains(&piece_px) {
                    return Err(format!("a length is 0.25 to 10000 pixels, not {piece_px}"));
                }
                Ok(Self::Tessellate { piece_px })
            }
            "fit" => nothing(Self::Fit),
            "play" => {
                rest.parse().ok().filter(|frames| (1..=100_000).contains(frames)).map_or_else(
                    || {
                        Err(format!(
                            "'play' takes a number of frames from 1 to 100000, not '{rest}'"
                        ))
                    },
                    |frames| Ok(Self::Play { frames }),
                )
            }
            "image" => file(rest, "png").map(Self::Image),
            "export" => file(rest, "glb").map(Self::Export),
            _ => Err(format!(
                "unknown command '{verb}'; there are pick, select, deselect, hide, show, isolate, ghost, lid, explode, assemble, distance, edge, edges, depth-complexity, section, whole, cut, view, projection, tessellate, fit, play, image, export"
            )),
        }
    }
}

impl Command {
    /// Returns the command relative to the scene's origin, which is at `origin_m` in the
    /// coordinates of the script, in metres.
    #[must_use]
    pub fn from_origin(&self, origin_m: DVec3) -> Self {
        match self {
            Self::Section(section) => Self::Section(section.from_origin(origin_m)),
            other => other.clone(),
        }
    }

    /// Returns the first word of the command in a script, or an equivalent for commands of windows.
    pub fn verb(&self) -> &'static str {
        match self {
            Self::Pick(_) => "pick",
            Self::Select(_) | Self::SelectObjects(_) => "select",
            Self::Deselect => "deselect",
            Self::Hide(_) | Self::DisplayObjects { display: Display::Hidden, .. } => "hide",
            Self::Show(_) | Self::DisplayObjects { display: Display::Shown, .. } => "show",
            Self::Ghost(_) | Self::DisplayObjects { display: Display::Ghosted, .. } => "ghost",
            Self::Isolate => "isolate",
            Self::Lid { .. } => "lid",
            Self::Explode { .. } => "explode",
            Self::Assemble => "assemble",
            Self::Distance { .. } | Self::DistanceOfPoints { .. } => "distance",
            Self::Edge(_) | Self::EdgeOfObject { .. } => "edge",
            Self::Edges(_) => "edges",
            Self::Overlay(_) => "depth-complexity",
            Self::Section(_) => "section",
            Self::Member { member: SectionMember::Whole, .. } => "whole",
            Self::Member { .. } => "cut",
            Self::View(_) => "view",
            Self::Camera(_) => "camera",
            Self::Flatness(_) => "projection",
            Self::Tessellate { .. } => "tessellate",
            Self::Fit => "fit",
            Self::Play { .. } => "play",
            Self::Image(_) => "image",
            Self::Export(_) => "export",
        }
    }

    /// Returns true if the command may change the display of parts.
    pub fn changes_displays(&self) -> bool {
        matches!(
            self,
            Self::Hide(_)
                | Self::Show(_)
                | Self::Ghost(_)
                | Self::Isolate
                | Self::DisplayObjects { .. }
        )
    }

    /// Returns true if the command may move surfaces, or change which are shown.
    pub fn changes_surfaces(&self) -> bool {
        let moves = matches!(
            self,
            Self::Lid { .. }
                | Self::Explode { .. }
                | Self::Assemble
                | Self::Section(_)
                | Self::Member { .. }
                | Self::Tessellate { .. }
        );
        moves || self.changes_displays()
    }

    /// Returns the pixels to which the command refers.
    pub fn pixels(&self) -> Vec<Pixel> {
        match self {
            Self::Pick(at) | Self::Edge(at) => vec![*at],
            Self::Distance { from, to } => vec![*from, *to],
            _ => Vec::new(),
        }
    }

    /// Returns the file that the command writes.
    pub fn written_file(&self) -> Option<&Path> {
        match self {
            Self::Image(file) | Self::Export(file) => Some(file),
            _ => None,
        }
    }
}

/// A line of a script.
#[derive(Clone, Debug, PartialEq)]
pub struct ScriptLine {
    /// The text of the line.
    pub text: String,
    /// The command in the line.
    pub command: Command,
}

/// Reads a script.
///
/// # Errors
/// A file that cannot be read, or the number of the first bad line.
pub fn read(path: &Path) -> Result<Vec<ScriptLine>, UsageError> {
    let shown = shown(path);
    let text = input_file::read_text(path, MOST_BYTES)
        .map_err(|error| UsageError(format!("cannot read the script '{shown}': {error}")))?;
    let text = text.trim_start_matches('\u{feff}');
    let lines = (1..).zip(text.lines().map(str::trim));
    let lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    lines
        .map(|(number, line): (u32, &str)| {
            let command = Command::parse(line);
            let command =
                command.map_err(|reason| UsageError(format!("{shown}:{number}: {reason}")))?;
            Ok(ScriptLine { text: line.to_owned(), command })
        })
        .collect()
}

fn number(text: &str, what: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| format!("{what} is a number, not '{text}'"))
}

/// Parses `COUNT` pixels, two numbers each.
fn pixels<const COUNT: usize>(text: &str) -> Result<[Pixel; COUNT], String> {
    let numbers: Option<Vec<u32>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
    let numbers = numbers.filter(|numbers| numbers.len() == 2 * COUNT).ok_or_else(|| {
        format!(
            "{} whole numbers, column and row of a pixel, are expected, not '{text}'",
            2 * COUNT
        )
    })?;
    Ok(std::array::from_fn(|index| Pixel { x: numbers[2 * index], y: numbers[2 * index + 1] }))
}

/// Parses planes separated by semicolons, optionally after `union`, or `off`.
fn section(text: &str) -> Result<SectionPlanes, String> {
    if text == "off" {
        return Ok(SectionPlanes::default());
    }
    let (mode, planes) = match text.strip_prefix("union ") {
        Some(planes) => (SectionMode::Union, planes),
        None => (SectionMode::Intersection, text),
    };
    let PlaneList(planes) = parse_planes(planes)?;
    SectionPlanes::new(&planes, mode).map_err(|error| error.to_string())
}

fn edge_mode(text: &str) -> Result<EdgeMode, String> {
    match text {
        "off" => Ok(EdgeMode::Off),
        "visible" => Ok(EdgeMode::Visible),
        "hidden" => Ok(EdgeMode::HiddenDashed),
        "shaded" => Ok(EdgeMode::Shaded),
        "shaded-hidden" => Ok(EdgeMode::ShadedWithHiddenDashed),
        _ => Err(format!("edges are off, visible, hidden, shaded or shaded-hidden, not '{text}'")),
    }
}

fn depth_complexity(text: &str) -> Result<DebugOverlay, String> {
    let has_depth_complexity = match text {
        "on" => true,
        "off" => false,
        _ => return Err(format!("depth-complexity is on or off, not '{text}'")),
    };
    Ok(DebugOverlay { has_depth_complexity, ..DebugOverlay::default() })
}

/// Parses the path of an output file.
fn file(text: &str, extension: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if path.extension().is_some_and(|found| found == extension) {
        return Ok(path);
    }
    Err(format!("the name of a file ends in .{extension}, not '{text}'"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_read() {
        for (line, expected) in [
            ("pick 12 7", Command::Pick(Pixel { x: 12, y: 7 })),
            ("select upper plate", Command::Select("upper plate".to_owned())),
            ("hide", Command::Hide(None)),
            ("ghost lid", Command::Ghost(Some("lid".to_owned()))),
            ("lid -3.5", Command::Lid { degrees: -3.5 }),
            ("explode 12", Command::Explode { gap_mm: 12.0 }),
            ("view iso", Command::View(CubeView::ISOMETRIC)),
            ("projection orthographic", Command::Flatness(1.0)),
            ("tessellate 4", Command::Tessellate { piece_px: 4.0 }),
            ("play 30", Command::Play { frames: 30 }),
            ("image out/a b.png", Command::Image(PathBuf::from("out/a b.png"))),
        ] {
            assert_eq!(Command::parse(line), Ok(expected), "{line}");
        }
    }

    #[test]
    fn wrong_lines_say_what_is_expected() {
        for (line, reason) in [
            ("fly", "unknown command 'fly'; there are pick"),
            ("pick 1", "2 whole numbers"),
            ("pick -1 2", "2 whole numbers"),
            ("distance 1 2 3", "4 whole numbers"),
            ("lid NaN", "an angle in degrees is a number"),
            ("explode -1", "0 to 1000000 mm"),
            ("explode 1e38", "0 to 1000000 mm"),
            ("explode", "a gap in millimetres is a number"),
            ("isolate all", "takes nothing"),
            ("view up", "is not a view"),
            ("projection flat", "perspective or orthographic"),
            ("section 0,0,0,1", "normal"),
            ("section 1,0", "four numbers"),
            ("edges thick", "visible, hidden"),
            ("depth-complexity 3", "is on or off"),
            ("tessellate 0", "0.25 to 10000 pixels"),
            ("play 0", "1 to 100000"),
            ("export part.stl", "ends in .glb"),
            ("select", "takes the name"),
        ] {
            let refused = Command::parse(line).unwrap_err();
            assert!(refused.contains(reason), "{line}: {refused}");
        }
        let missing = read(Path::new("/nowhere/script")).unwrap_err().to_string();
        assert!(missing.contains("/nowhere/script"), "{missing}");
    }
}
