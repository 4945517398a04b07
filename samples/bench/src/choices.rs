//! The named choices of the command line, each with its list of names and a parser that suggests.

use std::fmt;
use std::num::NonZeroU32;

use crate::strategy::Strategy;

/// A choice that has a name on the command line and in reports.
pub trait Named: Copy + 'static {
    /// What is chosen, for messages: "unknown WHAT".
    const WHAT: &'static str;
    /// Every value, in the order in which help and messages list them.
    const VALUES: &'static [Self];
    /// The name of one value: lower case, stable.
    fn name(self) -> &'static str;
}

/// Implements [`Named`], `Display` and nothing else for an enum, from one list of names.
macro_rules! named {
    ($type:ident, $what:literal, $($value:ident => $name:literal),+) => {
        impl Named for $type {
            const WHAT: &'static str = $what;
            const VALUES: &'static [Self] = &[$(Self::$value),+];
            fn name(self) -> &'static str {
                match self { $(Self::$value => $name),+ }
            }
        }
        impl fmt::Display for $type {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str(self.name())
            }
        }
    };
}

/// What the camera walks through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// Streets between buildings, with props: nearly everything is hidden from eye level.
    City,
    /// Objects side by side on a plane: from above nothing hides anything.
    Field,
}
named!(Scene, "scene", City => "city", Field => "field");

/// How the camera moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraPath {
    /// At eye level along the streets.
    Street,
    /// Above the roofs: little is hidden.
    Fly,
    /// Along the streets, but every tenth frame jumps somewhere else.
    Cut,
}
named!(CameraPath, "path", Street => "street", Fly => "fly", Cut => "cut");

/// How much the Vulkan validation layer looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Validation {
    /// The layer is not loaded.
    Off,
    /// Core checks.
    On,
    /// Core checks and synchronization validation.
    Sync,
}
named!(Validation, "validation mode", Off => "off", On => "on", Sync => "sync");

/// How the GPU skips draws that turned out hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Predicates {
    /// Conditional rendering where the device has it, counts otherwise.
    Auto,
    /// `VK_EXT_conditional_rendering`.
    Conditional,
    /// A compute pass that writes draw counts.
    Count,
    /// A compute pass that writes instance counts.
    Instances,
}
named!(Predicates, "way to skip draws", Auto => "auto", Conditional => "conditional",
    Count => "count", Instances => "instances");

/// Whether the engine weighs what its tests cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Costs {
    /// It tests whatever may be hidden.
    Ignored,
    /// It measures at the start what things cost on the device, and leaves out tests that do not pay.
    Measured,
}
named!(Costs, "way to weigh costs", Ignored => "ignored", Measured => "measured");

impl From<Costs> for render::Costs {
    fn from(costs: Costs) -> Self {
        match costs {
            Costs::Ignored => Self::Ignored,
            Costs::Measured => Self::Measured,
        }
    }
}

impl Named for Strategy {
    const WHAT: &'static str = "strategy";
    const VALUES: &'static [Self] = &Self::ALL;
    fn name(self) -> &'static str {
        self.name()
    }
}

/// Which frames are compared with plain frustum culling, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verify {
    /// None.
    Off,
    /// Every K-th frame, beginning with the first; the same ones where they only warm up.
    EveryNth(NonZeroU32),
}

impl Verify {
    /// Whether the frame of this number is compared.
    pub fn includes(self, frame: u32) -> bool {
        match self {
            Self::Off => false,
            Self::EveryNth(interval) => frame.is_multiple_of(interval.get()),
        }
    }
}

/// Which Vulkan device draws.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DeviceChoice {
    /// The one that the engine scores highest.
    Best,
    /// The one at this place of `--list-devices`.
    Index(usize),
    /// The one whose name contains this, whatever its case.
    Name(String),
}

/// Finds a value by its name; the error lists all names and suggests the nearest.
///
/// # Errors
/// A sentence, when no value has that name.
pub fn parse_named<T: Named>(text: &str) -> Result<T, String> {
    if let Some(&value) = T::VALUES.iter().find(|value| value.name() == text) {
        return Ok(value);
    }
    let names: Vec<&str> = T::VALUES.iter().map(|value| value.name()).collect();
    Err(unknown(T::WHAT, text, &names))
}

/// A sentence about a name that nobody has: it lists those that there are and suggests the nearest.
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

/// The name within few typing errors of the text, or that it begins.
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
    fn every_name_parses_to_its_value() {
        for &scene in Scene::VALUES {
            assert_eq!(parse_named::<Scene>(scene.name()), Ok(scene));
        }
        for &path in CameraPath::VALUES {
            assert_eq!(parse_named::<CameraPath>(path.name()), Ok(path));
        }
        for &strategy in Strategy::VALUES {
            assert_eq!(parse_named::<Strategy>(strategy.name()), Ok(strategy));
        }
    }

    #[test]
    fn a_typing_error_gets_a_suggestion() {
        let message = parse_named::<Strategy>("antumbar").unwrap_err();
        assert!(message.starts_with("unknown strategy 'antumbar': there is frustum"), "{message}");
        assert!(message.ends_with("did you mean 'antumbra'?"), "{message}");
        assert!(parse_named::<Scene>("CITY").unwrap_err().ends_with("did you mean 'city'?"));
        assert!(parse_named::<Predicates>("cond").unwrap_err().contains("'conditional'"));
    }

    #[test]
    fn something_else_gets_no_suggestion() {
        for text in ["", "x", "mountains"] {
            let message = parse_named::<CameraPath>(text).unwrap_err();
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
