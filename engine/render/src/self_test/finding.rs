//! The outcome of the check of an assumption.

/// The outcome of the check of an assumption.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Finding {
    /// It holds in all that was tried.
    Held,
    /// It does not hold: the observation, as a sentence.
    Broken(String),
    /// It was not tested: the reason, as a sentence.
    NotTested(String),
}

impl Finding {
    /// Returns [`Finding::Held`] if `faults` is 0, else the sentence with the number before it.
    pub(super) fn of_faults(faults: usize, of: usize, sentence: &str) -> Self {
        match faults {
            0 => Self::Held,
            _ => Self::Broken(format!("{faults} of {of} {sentence}")),
        }
    }

    /// Returns a word for it.
    #[must_use]
    pub const fn word(&self) -> &'static str {
        match self {
            Self::Held => "held",
            Self::Broken(_) => "BROKEN",
            Self::NotTested(_) => "not tested",
        }
    }

    /// Returns the observation or the reason; nothing where it held.
    #[must_use]
    pub fn detail(&self) -> &str {
        match self {
            Self::Held => "",
            Self::Broken(detail) | Self::NotTested(detail) => detail,
        }
    }
}
