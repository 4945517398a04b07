//! The error of a program's `main`.

use std::error::Error as StdError;
use std::fmt;

/// Any error, for a `main` that passes errors on by `?`. Rust prints the error that `main` returns
/// by its `Debug`: here these are the sentences of the error and of its causes.
pub struct Error(Box<dyn StdError + Send + Sync>);

impl Error {
    /// Returns the error itself, to match it or to follow its causes.
    #[must_use]
    pub fn inner(&self) -> &(dyn StdError + Send + Sync + 'static) {
        &*self.0
    }
}

// `Error` does not implement `std::error::Error`: this conversion would then be one from itself,
// which the standard library has already.
impl<E: Into<Box<dyn StdError + Send + Sync>>> From<E> for Error {
    fn from(error: E) -> Self {
        Self(error.into())
    }
}

impl fmt::Display for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.0)?;
        let mut text = self.0.to_string();
        let mut cause = self.0.source();
        while let Some(next) = cause {
            let sentence = next.to_string();
            // Many errors quote their cause.
            if !text.contains(&sentence) {
                write!(formatter, "\n  because {sentence}")?;
            }
            text = sentence;
            cause = next.source();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("the city cannot be shown")]
    struct Outer(#[from] Inner);

    #[derive(Debug, thiserror::Error)]
    #[error("the file is empty")]
    struct Inner;

    #[test]
    fn a_main_prints_the_sentences_of_an_error_and_of_its_causes() {
        let fail = || -> Result<(), Error> { Err(Outer(Inner))? };
        let error = fail().unwrap_err();
        assert_eq!(error.to_string(), "the city cannot be shown");
        assert_eq!(format!("{error:?}"), "the city cannot be shown\n  because the file is empty");
        assert!(error.inner().is::<Outer>());
        assert_eq!(format!("{:?}", Error::from("plain text")), "plain text");
    }

    #[cfg(feature = "import")]
    #[test]
    fn a_missing_file_is_named_in_a_sentence() {
        let open = || -> Result<(), Error> {
            crate::open_scene("no such city.glb")?;
            Ok(())
        };
        let text = format!("{:?}", open().unwrap_err());
        assert!(text.starts_with("no such city.glb") && !text.contains('{'), "{text}");
    }
}
