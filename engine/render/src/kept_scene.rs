//! The parts of a renderer's scene that only the GPU holds otherwise.

use std::collections::BTreeMap;
use std::sync::Arc;

use scene::{Environment, MeshId, PreparedMesh, PreparedTexture, Scene, TextureId};

/// The data from which [`Renderer::recover`](crate::Renderer::recover) fills the memory of another
/// device. Everything else about a scene is in the renderer's own memory.
pub(crate) struct KeptScene {
    /// The scene that the renderer was created from.
    pub(crate) scene: Arc<Scene>,
    /// The meshes that were added since, and not removed.
    pub(crate) meshes: BTreeMap<MeshId, PreparedMesh>,
    /// The textures that were added since, and not removed.
    pub(crate) textures: BTreeMap<TextureId, PreparedTexture>,
    /// The environment, if another one or none was set since.
    pub(crate) environment: Option<Option<Environment>>,
}

impl KeptScene {
    pub(crate) fn new(scene: Arc<Scene>) -> Self {
        Self { scene, meshes: BTreeMap::new(), textures: BTreeMap::new(), environment: None }
    }
}
