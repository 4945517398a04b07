//! The submits of a recorded frame beyond the first.

/// The submits of a recorded frame beyond the first. They determine how the frame's queries are
/// reset, because a reset by the CPU only holds for the next run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Resubmission {
    /// A frame is submitted at most once. The CPU resets its queries if the device supports it
    /// ([`OptionalFeature::HostQueryReset`](crate::OptionalFeature::HostQueryReset)), because some
    /// drivers wait for each query that a command resets.
    Never,
    /// A host may submit a frame again before it is safe. Commands reset the queries in each run.
    Allowed,
}
