//! The amount of text in the HUD.

use clap::ValueEnum;

/// The amount of text in the HUD.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum HudLevel {
    /// No text, but errors.
    #[default]
    Off,
    /// The numbers that a person looks for first.
    #[value(name = "on")]
    Compact,
    /// These numbers, and all others that fit.
    #[value(name = "details")]
    Detailed,
}

impl HudLevel {
    /// Returns the level after this one; after the last one, the first.
    pub const fn next(self) -> Self {
        match self {
            Self::Off => Self::Compact,
            Self::Compact => Self::Detailed,
            Self::Detailed => Self::Off,
        }
    }
}
