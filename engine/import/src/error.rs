//! The error of a file that cannot be used: the file, the object in it, the reason, and the remedy.

/// The reason why a file cannot be used. The message names the file, the object in it, the fault,
/// and a remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {object}: {reason} ({})", .cause.advice())]
pub struct ImportError {
    /// The path of the file, or a name for a file in memory.
    pub file: String,
    /// The object in the file, such as "mesh 3, primitive 0, attribute POSITION".
    pub object: String,
    /// The fault of the object.
    pub reason: String,
    /// The kind of fault.
    pub cause: Cause,
}

/// The kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cause {
    /// A file that could not be read from the disk.
    Unreadable,
    /// A file that is not a scene.
    NotScene,
    /// A violation of glTF 2.0 or of an extension.
    Malformed,
    /// Compressed bytes that cannot be decoded. The glTF validator does not check them.
    Damaged,
    /// A feature that is not supported.
    Unsupported,
    /// A reference to something outside of the file's folder.
    Forbidden,
    /// A demand that exceeds the [`Limits`](crate::Limits).
    TooLarge,
    /// A demand for more memory than the machine has left.
    NoMemory,
    /// A progress function that stopped the loading.
    GivenUp,
}

impl Cause {
    /// Returns advice for the user, as a part of the message.
    pub fn advice(self) -> &'static str {
        match self {
            Self::Unreadable => "check that the file is there, whole, and may be read",
            Self::NotScene => {
                "choose a .gltf, .glb, .stl or .obj file, or copy this one again if it is one"
            }
            Self::Malformed => {
                "the file is damaged or its exporter is wrong: export it again, or see what the \
                 glTF validator says"
            }
            Self::Damaged => {
                "the file is damaged or its exporter is wrong: copy or export it again"
            }
            Self::Unsupported => {
                "export it again as glTF 2.0, without extensions that are named here, and with \
                 images in PNG, JPEG, WebP, or KTX2 of BC, ASTC or 8 bits"
            }
            Self::Forbidden => {
                "put what the scene needs into its folder, and name it by a relative path"
            }
            Self::NoMemory => "end other programs, or make the scene smaller",
            Self::GivenUp => "load it again if you want it after all",
            Self::TooLarge => "make the scene smaller, or raise the limits if you trust the file",
        }
    }
}

/// A reason without the object, which the caller adds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Reason {
    cause: Cause,
    text: String,
}

impl Reason {
    pub(crate) fn malformed(text: impl Into<String>) -> Self {
        Self { cause: Cause::Malformed, text: text.into() }
    }

    pub(crate) fn damaged(text: impl Into<String>) -> Self {
        Self { cause: Cause::Damaged, text: text.into() }
    }

    pub(crate) fn not_scene(text: impl Into<String>) -> Self {
        Self { cause: Cause::NotScene, text: text.into() }
    }

    pub(crate) fn unsupported(text: impl Into<String>) -> Self {
        Self { cause: Cause::Unsupported, text: text.into() }
    }

    pub(crate) fn forbidden(text: impl Into<String>) -> Self {
        Self { cause: Cause::Forbidden, text: text.into() }
    }

    pub(crate) fn unreadable(text: impl Into<String>) -> Self {
        Self { cause: Cause::Unreadable, text: text.into() }
    }

    pub(crate) fn beyond_limits(text: impl Into<String>) -> Self {
        Self { cause: Cause::TooLarge, text: text.into() }
    }

    /// Returns the reason that there is not enough memory for `size_bytes`.
    pub(crate) fn no_memory(size_bytes: u64) -> Self {
        let text = format!("there is no memory for the {} MiB that it takes", size_bytes >> 20);
        Self { cause: Cause::NoMemory, text }
    }

    /// Returns the reason that the progress function stopped loading.
    pub(crate) fn given_up() -> Self {
        Self { cause: Cause::GivenUp, text: "it was given up".to_owned() }
    }

    /// Returns the reason that an amount exceeds its limit.
    pub(crate) fn too_large(what: &str, amount: u64, limit: u64) -> Self {
        Self {
            cause: Cause::TooLarge,
            text: format!("{what}: {amount}, more than the limit of {limit}"),
        }
    }

    /// Returns the reason that an index is out of range.
    pub(crate) fn out_of_range(what: &str, index: usize, count: usize) -> Self {
        Self::malformed(format!("{what} {index} does not exist, {}", there_are(count as u64)))
    }

    pub(crate) fn of(self, object: impl Into<String>) -> Fault {
        Fault { object: object.into(), reason: self }
    }
}

/// The fault of an object in a file; the caller adds the name of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Fault {
    object: String,
    reason: Reason,
}

impl Fault {
    /// Returns the object and the text of the reason.
    pub(crate) fn into_parts(self) -> (String, String) {
        (self.object, self.reason.text)
    }

    /// Returns true if the fault refuses the file even if the scene does not need the object.
    pub(crate) fn is_final(&self) -> bool {
        matches!(self.reason.cause, Cause::TooLarge | Cause::NoMemory | Cause::GivenUp)
    }

    pub(crate) fn in_file(self, file: &str) -> ImportError {
        ImportError {
            file: file.to_owned(),
            object: self.object,
            reason: self.reason.text,
            cause: self.reason.cause,
        }
    }
}

impl From<ImportError> for Fault {
    fn from(error: ImportError) -> Self {
        let ImportError { object, reason, cause, .. } = error;
        Self { object, reason: Reason { cause, text: reason } }
    }
}

/// Turns a reason into a fault by adding the object, whose name is created only for an error.
pub(crate) trait At<T> {
    fn at(self, object: impl FnOnce() -> String) -> Result<T, Fault>;
}

impl<T> At<T> for Result<T, Reason> {
    fn at(self, object: impl FnOnce() -> String) -> Result<T, Fault> {
        self.map_err(|reason| reason.of(object()))
    }
}

/// Returns the number of existing elements, as the end of a sentence about an invalid index.
pub(crate) fn there_are(count: u64) -> String {
    format!("there {}", if count == 1 { "is 1".to_owned() } else { format!("are {count}") })
}

/// Returns text from a file for display: in quotes, without control characters, at a limited
/// length.
pub(crate) fn quoted(text: &str) -> String {
    const LONGEST: usize = 80;
    let mut shown: String = text.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if text.chars().nth(LONGEST).is_some() {
        shown.push_str("...");
    }
    format!("\"{shown}\"")
}
