//! The reason why a scene is refused.

/// A part of a scene that cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// A mesh that cannot be drawn.
    #[error("the mesh \"{mesh}\" cannot be drawn: {fault}")]
    BrokenMesh {
        /// The mesh's name.
        mesh: String,
        /// The fault, as the end of a sentence.
        fault: &'static str,
    },
    /// Surfaces that cannot be drawn.
    #[error("{part} {index} of the surfaces cannot be drawn: {fault}")]
    BrokenSurfaces {
        /// The kind of part: a mesh, a material, a light...
        part: &'static str,
        /// The index among parts of its kind.
        index: usize,
        /// The fault, as the end of a sentence.
        fault: &'static str,
    },
    /// An environment that cannot be used.
    #[error("the environment cannot be used: {fault}")]
    BrokenEnvironment {
        /// The fault, as the end of a sentence.
        fault: &'static str,
    },
    /// An object that cannot be drawn.
    #[error("object {index} cannot be drawn: {fault}")]
    BrokenObject {
        /// The index in [`Scene::objects`](crate::Scene::objects).
        index: usize,
        /// The fault, as the end of a sentence.
        fault: &'static str,
    },
}
