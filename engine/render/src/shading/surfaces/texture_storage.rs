//! The two ways that textures lie on the GPU, and the choice between them.

/// The way that the textures of materials and lights lie on the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TextureStorage {
    /// An image for each, as large as it is, which shaders find by its number: for devices with
    /// [`Optional::IndexedTextures`](gpu::Optional::IndexedTextures). Textures of any size come
    /// while a renderer runs, and none needs [room](crate::SpareRoom::textures).
    #[default]
    Images,
    /// Pages: at most [`MAX_PAGES`](scene::limits::MAX_PAGES) arrays of images of one size and
    /// sampler, for every device. Images may be resampled to share a page.
    Pages,
}

impl TextureStorage {
    /// Returns the best of a device that has descriptor indexing or not.
    pub(crate) fn best(has_indexing: bool) -> Self {
        if has_indexing { Self::Images } else { Self::Pages }
    }
}
