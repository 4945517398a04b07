//! The cancellation of loading: who waits for it may ask for its end at any time.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::core::error::Error;

/// A request to give work up, shared by who may ask and who works: clones are the same request.
/// Work that takes long checks it between its pieces, and ends with [`Error::Cancelled`].
#[derive(Clone, Debug, Default)]
pub struct CancellationToken {
    is_cancelled: Arc<AtomicBool>,
}

impl CancellationToken {
    /// Creates a request that nobody has made yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Creates the request that is made once `flag` is true, such as by the handler of a signal.
    pub fn of_flag(flag: Arc<AtomicBool>) -> Self {
        Self { is_cancelled: flag }
    }

    /// Asks for the end of the work. That cannot be taken back.
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Returns true if the end was asked for.
    pub fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }

    /// Gives the work up if that was asked for.
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
