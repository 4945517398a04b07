//! The options of reading glTF files.

use antumbra::import::BrokenParts;
use clap::Args;

/// The reading of glTF files, for all programs.
#[derive(Clone, Copy, Debug, Args)]
pub struct FileArguments {
    /// Refuse a glTF file of which a part that is shown is broken; else such parts are left out,
    /// and named
    #[arg(long, help_heading = "Scene")]
    pub strict: bool,
}

impl FileArguments {
    /// Returns the treatment of broken parts.
    pub fn broken_parts(&self) -> BrokenParts {
        if self.strict { BrokenParts::Refuse } else { BrokenParts::LeaveOut }
    }
}
