//! The errors of the execution of plans.

/// An error of the execution. Its text is a sentence for the user.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The GPU layer failed.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
    /// A strategy that does not count samples, and a threshold.
    #[error(transparent)]
    CannotCount(#[from] CannotCount),
    /// A view and the leaves of another scene.
    #[error(
        "this view was made for another scene's leaves: each view goes with the `LeafTable` that it was made for"
    )]
    ForeignView,
    /// A request for shaders that this build cannot compile.
    #[error(
        "this build has no shader compiler, it cannot use the shaders in {0}; build with --features shader-compiler"
    )]
    NoShaderCompiler(String),
}

/// A strategy that does not count samples, and a threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the strategy `{strategy}` does not count samples, which a threshold of {threshold_samples} needs: use `antumbra` or `antumbra_queries`, or set the threshold to 0"
)]
pub struct CannotCount {
    /// The strategy that was asked for.
    pub strategy: cull::Strategy,
    /// The threshold in samples.
    pub threshold_samples: u32,
}
