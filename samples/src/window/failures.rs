//! The errors at the end of a program.

use antumbra::gpu::ValidationLog;
use bench::run_error::RunError;

/// Returns the first error, which is the cause, and logs the others.
///
/// # Errors
/// The first one.
pub fn first_error<const COUNT: usize>(
    results: [Result<(), RunError>; COUNT],
) -> Result<(), RunError> {
    let mut errors = results.into_iter().filter_map(Result::err);
    let first = errors.next();
    errors.for_each(|error| tracing::error!("{error}"));
    first.map_or(Ok(()), Err)
}

/// Checks the messages of the validation layer.
///
/// # Errors
/// The first message, if there is one.
pub fn check_log(log: &ValidationLog) -> Result<(), RunError> {
    let messages = log.drain();
    match messages.first() {
        None => Ok(()),
        Some(first) => Err(RunError::machine(format!(
            "the validation layer has {} messages, the first: {first:?}",
            messages.len()
        ))),
    }
}
