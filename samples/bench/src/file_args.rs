//! The options of reading files of scenes.

use antumbra::import::{BrokenParts, LoadOptions};
use clap::Args;

/// The reading of files of scenes, for all programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Args)]
pub struct FileArguments {
    /// Refuse a file of which a part that is shown is broken; else such parts are left out,
    /// and named
    #[arg(long, help_heading = "Scene")]
    pub strict: bool,
    /// Leave each mesh of a file in one piece; else meshes above 65,536 triangles are cut, so that
    /// parts of them are culled
    #[arg(long, help_heading = "Scene")]
    pub whole_meshes: bool,
}

impl FileArguments {
    /// Returns the treatment of broken parts.
    pub fn broken_parts(&self) -> BrokenParts {
        if self.strict { BrokenParts::Refuse } else { BrokenParts::LeaveOut }
    }

    /// Returns the triangles above which a mesh is cut into pieces, if one is.
    pub fn cut_above_triangles(&self) -> Option<usize> {
        LoadOptions::default().cut_above_triangles.filter(|_| !self.whole_meshes)
    }
}
