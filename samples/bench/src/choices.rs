//! The named choices of the command line, and the suggestion of a name after a typing error.

use std::fmt;
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::str::FromStr;

use antumbra::render::{self, EdgeMode, EdgeOptions};
use clap::ValueEnum;

use crate::options::PathChoice;
use crate::strategy::{self, Strategy};

/// The scene that the camera walks through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GeneratorChoice {
    /// Streets between buildings, with props: nearly everything is hidden from eye level.
    City,
    /// Objects side by side on a plane: from above nothing hides anything.
    Field,
    /// Machines of many small parts in halls: nearly all parts are enclosed by others.
    Assembly,
    /// A waffle maker of some thirty parts.
    Waffle,
}

impl GeneratorChoice {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::City, Self::Field, Self::Assembly, Self::Waffle];

    /// Returns true if the number of its objects and a seed can be chosen.
    pub fn takes_numbers(self) -> bool {
        self != Self::Waffle
    }

    /// Returns its default path.
    pub fn default_path(self) -> CameraPathChoice {
        match self {
            Self::City | Self::Field | Self::Assembly => CameraPathChoice::Street,
            Self::Waffle => CameraPathChoice::Fly,
        }
    }
}

impl fmt::Display for GeneratorChoice {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&name_of(self))
    }
}

/// The camera's path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CameraPathChoice {
    /// At eye level along the streets.
    Street,
    /// Above the roofs: little is hidden.
    Fly,
    /// Along the streets, but every tenth frame jumps somewhere else.
    Cut,
}

impl fmt::Display for CameraPathChoice {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&name_of(self))
    }
}

/// The projection of the walk's cameras.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProjectionChoice {
    /// The camera's own: perspective, unless a file has another projection.
    Perspective,
    /// Orthographic, with a slice of the scene in front of the eye.
    Orthographic,
    /// In perspective, moved within the pixel from frame to frame, as for temporal anti-aliasing.
    Jittered,
}

impl fmt::Display for ProjectionChoice {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&name_of(self))
    }
}

/// The edges of objects that a walk draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EdgesChoice {
    /// None.
    Off,
    /// Visible edges on paper.
    Visible,
    /// The same, with hidden edges in dashes.
    Hidden,
    /// Visible edges over the surfaces, and hidden ones in dashes.
    Shaded,
}

impl EdgesChoice {
    /// Returns the renderer's options of edges.
    pub fn options(self) -> EdgeOptions {
        let mode = match self {
            Self::Off => EdgeMode::Off,
            Self::Visible => EdgeMode::Visible,
            Self::Hidden => EdgeMode::HiddenDashed,
            Self::Shaded => EdgeMode::ShadedWithHiddenDashed,
        };
        EdgeOptions { mode, ..EdgeOptions::default() }
    }
}

/// The checks of the Vulkan validation layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ValidationChoice {
    /// The layer is not loaded.
    Off,
    /// The core checks: valid usage of every call.
    On,
    /// Core checks and synchronization validation.
    Sync,
}

/// The way in which the GPU skips hidden draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PredicatesChoice {
    /// The one that costs least by the costs measured at the start.
    Auto,
    /// `VK_EXT_conditional_rendering`: the device skips draws.
    Conditional,
    /// A compute pass that writes draw counts.
    Count,
    /// A compute pass that writes instance counts.
    Instances,
    /// A compute pass that lists what a round reveals, for one draw with a count.
    Compacted,
}

/// The treatment of driver quirks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum QuirksChoice {
    /// Everything is used as it is.
    #[value(alias = "driver")]
    None,
    /// A self-test comes first, and what it finds broken is not used.
    Tested,
}

/// The cost model of the engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CostModelChoice {
    /// None: everything that may be hidden is tested.
    #[value(alias = "ignored")]
    Off,
    /// Costs measured on the device at the start: tests that do not pay are left out.
    Measured,
}

impl From<CostModelChoice> for render::CostModel {
    fn from(choice: CostModelChoice) -> Self {
        match choice {
            CostModelChoice::Off => Self::Off,
            CostModelChoice::Measured => Self::Measured,
        }
    }
}

/// The frames that are compared with plain frustum culling, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verify {
    /// No frame is compared.
    Off,
    /// Every K-th frame, beginning with the first; the same frames in warm-ups.
    EveryNth(NonZeroU32),
}

impl Verify {
    /// Returns true if the frame of this number is compared.
    pub fn includes(self, frame: u32) -> bool {
        match self {
            Self::Off => false,
            Self::EveryNth(interval) => frame.is_multiple_of(interval.get()),
        }
    }
}

/// The Vulkan device that draws.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DeviceChoice {
    /// The device that the engine scores highest.
    Best,
    /// The device at this place of `--list-devices`.
    Index(usize),
    /// The device whose name contains this text, in any case.
    Name(String),
}

impl FromStr for Verify {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "off" => Ok(Self::Off),
            "every" => Ok(Self::EveryNth(NonZeroU32::MIN)),
            _ => text.parse().map(Self::EveryNth).map_err(|_| {
                "it takes 'every', 'off' or a whole number K above 0 (every K-th frame)".to_owned()
            }),
        }
    }
}

impl FromStr for DeviceChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "" => Err("it takes a place in --list-devices or a part of a name".to_owned()),
            text => Ok(text.parse().map_or_else(|_| Self::Name(text.to_owned()), Self::Index)),
        }
    }
}

/// Returns the name that a value has on the command line.
fn name_of(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// Parses a list of different names, separated by commas.
///
/// # Errors
/// The first name that is unknown or repeated.
pub fn each_once<T: PartialEq>(
    text: &str,
    parse: impl Fn(&str) -> Result<T, String>,
) -> Result<Vec<T>, String> {
    let mut found = Vec::new();
    for name in text.split(',').map(str::trim) {
        let value = parse(name)?;
        if found.contains(&value) {
            return Err(format!("it names '{name}' twice: name each once"));
        }
        found.push(value);
    }
    Ok(found)
}

/// Finds a value by its name.
///
/// # Errors
/// A sentence with all names, and the nearest.
pub fn parse_named<T: ValueEnum>(what: &str, text: &str) -> Result<T, String> {
    T::from_str(text, false).map_err(|_| {
        let names: Vec<String> = T::value_variants().iter().map(name_of).collect();
        unknown(what, text, &names.iter().map(String::as_str).collect::<Vec<_>>())
    })
}

/// Finds one of these values by its name.
///
/// # Errors
/// A sentence with all names, and the nearest.
pub fn parse_listed<T: Copy>(
    what: &str,
    text: &str,
    all: &[T],
    name: fn(T) -> &'static str,
) -> Result<T, String> {
    all.iter().copied().find(|value| name(*value) == text).ok_or_else(|| {
        unknown(what, text, &all.iter().map(|value| name(*value)).collect::<Vec<_>>())
    })
}

/// Finds a strategy by its name.
///
/// # Errors
/// As [`parse_named`].
pub fn parse_strategy(text: &str) -> Result<Strategy, String> {
    // Names of an earlier version are still accepted.
    let name = match text {
        "coherent" => antumbra::methods::CHC.name(),
        "pyramid" => antumbra::methods::HZB.name(),
        name => name,
    };
    parse_listed("strategy", name, &strategy::strategies(), Strategy::name)
}

/// Returns the text as the name of a path file if it ends in .txt or has a slash.
pub fn path_file(text: &str) -> Option<PathBuf> {
    let is_file = text.ends_with(".txt") || text.contains(['/', std::path::MAIN_SEPARATOR]);
    is_file.then(|| PathBuf::from(text))
}

/// Parses the name of a path of generated scenes, or of the file of a recorded path.
///
/// # Errors
/// A name that is neither.
pub fn parse_path(text: &str) -> Result<PathChoice, String> {
    if let Some(file) = path_file(text) {
        return Ok(PathChoice::Recorded(file));
    }
    parse_named("path", text).map(PathChoice::Made).map_err(|message| {
        format!(
            "{message}; a file ends in .txt, or has a slash in its name (cameras have names in glTF files only)"
        )
    })
}

/// Returns a sentence about an unknown name: it lists the known names and suggests the nearest.
pub fn unknown(what: &str, text: &str, names: &[&str]) -> String {
    let mut message = format!("unknown {what} '{text}': there is {}", enumerate(names));
    if let Some(name) = nearest(text, names) {
        message.push_str(&format!("; did you mean '{name}'?"));
    }
    message
}

/// Joins names as in a sentence: "a, b and c".
pub fn enumerate(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [name] => (*name).to_owned(),
        [names @ .., last] => format!("{} and {last}", names.join(", ")),
    }
}

/// Returns the nearest name that begins with the text or differs from it by few typing errors.
fn nearest<'a>(text: &str, names: &[&'a str]) -> Option<&'a str> {
    let text = text.to_lowercase();
    names
        .iter()
        .map(|&name| (strsim::damerau_levenshtein(&text, &name.to_lowercase()), name))
        .filter(|&(distance, name)| {
            distance * 3 <= name.len().max(3)
                || (text.len() >= 2 && name.to_lowercase().starts_with(&text))
        })
        .min()
        .map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_typing_error_gets_a_suggestion() {
        let message = parse_strategy("antumbar").unwrap_err();
        assert!(message.starts_with("unknown strategy 'antumbar': there is frustum"), "{message}");
        assert!(message.ends_with("did you mean 'antumbra'?"), "{message}");
        let message = parse_named::<GeneratorChoice>("scene", "CITY").unwrap_err();
        assert!(message.ends_with("did you mean 'city'?"), "{message}");
    }

    #[test]
    fn something_else_gets_no_suggestion() {
        for text in ["", "x", "mountains"] {
            let message = parse_named::<CameraPathChoice>("path", text).unwrap_err();
            assert!(message.ends_with("there is street, fly and cut"), "{message}");
        }
    }

    #[test]
    fn verify_takes_every_nth_frame_from_the_first() {
        let third = Verify::EveryNth(NonZeroU32::new(3).unwrap());
        let frames: Vec<u32> = (0..8).filter(|&frame| third.includes(frame)).collect();
        assert_eq!(frames, [0, 3, 6]);
        assert!(!Verify::Off.includes(0));
    }
}
