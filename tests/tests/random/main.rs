//! Random input to the whole engine: sequences of calls of a renderer, and files. What a test tries
//! follows from its seeds; the ignored ones try many more of them.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod calls;
mod files;

/// Returns the seeds of a long test: as many as `ANTUMBRA_SEEDS` says, or as usual, from
/// `ANTUMBRA_FIRST_SEED` on.
fn seeds(first: u64, usual: u64) -> std::ops::Range<u64> {
    let named = |name| std::env::var(name).ok().and_then(|number| number.parse().ok());
    let first = named("ANTUMBRA_FIRST_SEED").unwrap_or(first);
    first..first + named("ANTUMBRA_SEEDS").unwrap_or(usual)
}
