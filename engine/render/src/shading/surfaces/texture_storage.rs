//! The two storages of textures on the GPU, and the choice between them.

/// The storage of the textures of materials and lights on the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TextureStorage {
    /// A separate image for each texture, in its own size, which shaders index by number. For
    /// devices with
    /// [`OptionalFeature::DescriptorIndexing`](gpu::OptionalFeature::DescriptorIndexing). Textures
    /// of any size can be added while a renderer runs, without
    /// [room](crate::SpareCapacity::textures) for them.
    #[default]
    Bindless,
    /// Pages: at most [`MAX_PAGES`](scene::limits::MAX_PAGES) arrays of images with one size and
    /// sampler, on every device. Images may be resampled to share a page.
    ArrayPacked,
}

impl TextureStorage {
    /// Returns the best storage for `textures` textures on a device that can index `indexed` of
    /// them.
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
