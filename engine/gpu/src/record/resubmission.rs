//! The submits of a recorded frame beyond the first.

/// Submits of a recorded frame beyond the first. They decide who resets the queries of a frame: the
/// CPU can only for the next run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Resubmission {
    /// Each frame is submitted once at most. Its queries are reset by the CPU where the device
    /// allows it ([`OptionalFeature::HostQueryReset`](crate::OptionalFeature::HostQueryReset)),
    /// since some drivers wait once per query that a command resets.
    Never,
    /// A host may submit a frame again before it is safe. Each run resets its queries by commands.
    Allowed,
}
