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

/// Returns the number of seeds of a long test: that of `ANTUMBRA_SEEDS`, or this one.
fn seeds_or(usual: u64) -> u64 {
    let named = std::env::var("ANTUMBRA_SEEDS").ok().and_then(|seeds| seeds.parse().ok());
    named.unwrap_or(usual)
}
