//! What is said when a file cannot be used: which file, what in it, why, and what to do.

/// Why a file cannot be used. It says which file, which object in it, the reason, and what can be done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {object}: {reason} ({})", .cause.advice())]
pub struct ImportError {
    /// The file's path, or what stands for it where it came from memory.
    pub file: String,
    /// What in it, like "mesh 3, primitive 0, attribute POSITION".
    pub object: String,
    /// What is wrong with that.
    pub reason: String,
    /// Of which sort that is.
    pub cause: Cause,
}

/// Sorts of reasons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cause {
    /// It could not be read from the disk.
    Unreadable,
    /// It breaks a rule of glTF 2.0 or of an extension.
    Malformed,
    /// It needs something that is not implemented here.
    Unsupported,
    /// It reaches for something outside of its folder.
    Forbidden,
    /// It asks for more than [`Limits`](crate::Limits) allow.
    TooLarge,
    /// Nobody waits for it any more.
    GivenUp,
}

impl Cause {
    /// What the user can do.
    pub fn advice(self) -> &'static str {
        match self {
            Self::Unreadable => "check that the file is there, whole, and may be read",
            Self::Malformed => {
                "the file is damaged or its exporter is wrong: export it again, or see what the \
                 glTF validator says"
            }
            Self::Unsupported => "export it again without this",
            Self::Forbidden => {
                "put what the scene needs into its folder, and name it by a relative path"
            }
            Self::GivenUp => "load it again if you want it after all",
            Self::TooLarge => "make the scene smaller, or raise the limits if you trust the file",
        }
    }
}
