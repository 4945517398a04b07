//! What can go wrong between a scene and its picture.

/// An error of the engine. Its text is a sentence for the user.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The GPU layer failed.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
    /// The hierarchy could not be built.
    #[error("the scene cannot be culled: {0}")]
    Hierarchy(#[from] cull::HierarchyError),
    /// The scene is not whole.
    #[error(transparent)]
    Scene(#[from] crate::scene::SceneError),
    /// The strategy `ideal` without the set of what is visible.
    #[error(
        "the strategy `ideal` draws what is known to be visible: find it with `Renderer::visible_set` first"
    )]
    NoVisibleSet,
    /// Shaders were asked for that this build cannot compile.
    #[error(
        "this build has no shader compiler, it cannot use the shaders in {0}; build with --features shader-compiler"
    )]
    NoShaderCompiler(String),
}
