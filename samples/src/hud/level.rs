//! How much the HUD shows.

use clap::ValueEnum;

/// How much of the HUD is wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum HudLevel {
    /// No text, but what went wrong.
    #[default]
    Off,
    /// The numbers that a person looks for first.
    #[value(name = "on")]
    Compact,
    /// These, and all others that have room.
    #[value(name = "details")]
    Detailed,
}

impl HudLevel {
    /// Returns the level after this one; after all, nothing.
    pub const fn next(self) -> Self {
        match self {
            Self::Off => Self::Compact,
            Self::Compact => Self::Detailed,
            Self::Detailed => Self::Off,
        }
    }
}
