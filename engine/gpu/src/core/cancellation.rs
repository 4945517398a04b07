//! The cancellation of long work, such as loading, which can be requested at any time.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::core::error::Error;

/// A request to cancel work. Clones share the request, one clone for the caller and one for the
/// work. Long work checks it between its pieces, and ends with [`Error::Cancelled`].
#[derive(Clone, Debug, Default)]
pub struct CancellationToken {
    is_cancelled: Arc<AtomicBool>,
}

impl CancellationToken {
    /// Creates a token that is not cancelled yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Creates a token that is cancelled once `flag` is true, such as by the handler of a signal.
    pub fn of_flag(flag: Arc<AtomicBool>) -> Self {
        Self { is_cancelled: flag }
    }

    /// Requests the end of the work. This cannot be undone.
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Returns true if the end was requested.
    pub fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }

    /// Returns an error if the end was requested, to end the work.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn check(&self) -> Result<(), Error> {
        if self.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_and_flags_are_the_same_request() {
        let flag = Arc::new(AtomicBool::new(false));
        let token = CancellationToken::of_flag(Arc::clone(&flag));
        let other = token.clone();
        assert!(token.check().is_ok() && other.check().is_ok());
        flag.store(true, Ordering::Relaxed);
        assert!(token.is_cancelled() && matches!(other.check(), Err(Error::Cancelled)));
        let token = CancellationToken::new();
        token.clone().cancel();
        assert!(token.is_cancelled());
    }
}
