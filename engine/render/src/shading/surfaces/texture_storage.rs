//! The two ways that textures lie on the GPU, and the choice between them.

/// The way that the textures of materials and lights lie on the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TextureStorage {
    /// An image for each, as large as it is, which shaders find by its number: for devices with
    /// [`OptionalFeature::DescriptorIndexing`](gpu::OptionalFeature::DescriptorIndexing). Textures
    /// of any size come while a renderer runs, and none needs
    /// [room](crate::SpareCapacity::textures).
    #[default]
    Bindless,
    /// Pages: at most [`MAX_PAGES`](scene::limits::MAX_PAGES) arrays of images of one size and
    /// sampler, for every device. Images may be resampled to share a page.
    ArrayPacked,
}

impl TextureStorage {
    /// Returns the best for so many textures on a device that indexes at most so many.
    pub(crate) fn best(textures: u64, indexed: u32) -> Self {
        if indexed > 0 && textures <= indexed.into() { Self::Bindless } else { Self::ArrayPacked }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_device_cannot_index_lies_on_pages() {
        assert_eq!(TextureStorage::best(0, 0), TextureStorage::ArrayPacked);
        assert_eq!(TextureStorage::best(2_000, 1_984), TextureStorage::ArrayPacked);
        assert_eq!(TextureStorage::best(1_984, 1_984), TextureStorage::Bindless);
    }
}
