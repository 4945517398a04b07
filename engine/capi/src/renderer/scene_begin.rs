//! The scene that a renderer begins with: meshes and objects of the host, or a file.

use std::sync::Arc;

use scene::{MaterialId, Scene};

use crate::error::Failure;
use crate::renderer::description::AntumbraRendererDesc;
#[cfg(feature = "import")]
use crate::renderer::playback::Playback;
use crate::renderer::scene_file::AntumbraSceneFile;
use crate::table::Handle;

/// The scene that a renderer begins with.
pub(crate) struct SceneBegin {
    pub scene: Arc<Scene>,
    /// The material of meshes that are added later; `None` in a scene without surfaces.
    pub added_material: Option<MaterialId>,
    /// The clips and cameras of a file.
    #[cfg(feature = "import")]
    pub playback: Option<Playback>,
}

impl SceneBegin {
    /// Returns the scene that a description names. `of_file` returns the scene of a file at rest.
    ///
    /// # Safety
    /// As the rules of the interface.
    pub unsafe fn of(
        desc: &AntumbraRendererDesc,
        of_file: impl FnOnce(AntumbraSceneFile) -> Result<Self, Failure>,
    ) -> Result<Self, Failure> {
        let begin = if desc.scene_file.id() == 0 {
            Self {
                // SAFETY: the caller's promise.
                scene: Arc::new(unsafe { desc.scene() }?),
                added_material: None,
                #[cfg(feature = "import")]
                playback: None,
            }
        } else {
            desc.check_nothing_but_a_file()?;
            of_file(desc.scene_file)?
        };
        // Shadows fall on surfaces.
        Ok(if desc.shadows.is_null() { begin } else { begin.with_surfaces() })
    }

    /// Returns the scene with surfaces. Meshes without any have a material of their vertex colours.
    fn with_surfaces(self) -> Self {
        if self.added_material.is_some() {
            return self;
        }
        let scene = Arc::unwrap_or_clone(self.scene).with_surfaces();
        Self { scene: Arc::new(scene), added_material: Some(MaterialId(0)), ..self }
    }
}
