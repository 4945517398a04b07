//! The outcome of the check of an assumption.

/// The outcome of the check of an assumption.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CheckResult {
    /// The assumption holds in everything that was tested.
    Passed,
    /// The assumption does not hold: the observation, as a sentence.
    Failed(String),
    /// The assumption was not tested: the reason, as a sentence.
    Skipped(String),
}

impl CheckResult {
    /// Returns [`CheckResult::Passed`] if `faults` is 0, else a failure with the number and the
    /// sentence.
    pub(super) fn of_faults(faults: usize, of: usize, sentence: &str) -> Self {
        match faults {
            0 => Self::Passed,
            _ => Self::Failed(format!("{faults} of {of} {sentence}")),
        }
    }

    /// Returns a word for the result.
    #[must_use]
    pub const fn word(&self) -> &'static str {
        match self {
            Self::Passed => "held",
            Self::Failed(_) => "BROKEN",
            Self::Skipped(_) => "not tested",
        }
    }

    /// Returns the observation or the reason; empty if the assumption holds.
    #[must_use]
    pub fn detail(&self) -> &str {
        match self {
            Self::Passed => "",
            Self::Failed(detail) | Self::Skipped(detail) => detail,
        }
    }
}
