//! The limits of a scene that every device supports. Many devices support more.

/// The size of a storage buffer that every device supports, in bytes.
pub const STORAGE_BYTES_ANYWHERE: u64 = 1 << 27;

/// The size of an object in a storage buffer, in bytes: three rows of its transform, its tint and
/// its mesh.
pub const INSTANCE_BYTES: u64 = 64;

/// The most objects, with room for added ones; transparent objects are counted separately.
pub const OBJECTS_ANYWHERE: u64 = STORAGE_BYTES_ANYWHERE / INSTANCE_BYTES;

/// The most objects, including transparent ones, in a scene with point or spot lights.
pub const LIT_OBJECTS_ANYWHERE: u64 = STORAGE_BYTES_ANYWHERE / 32;

/// The most materials.
pub const MATERIALS_ANYWHERE: u64 = STORAGE_BYTES_ANYWHERE / 64 - 1;

/// The most vertices of all skinned meshes together.
pub const SKINNED_VERTICES_ANYWHERE: u64 = STORAGE_BYTES_ANYWHERE / 40;

/// The most images; an image that is sampled both as colours and as numbers counts twice.
pub const IMAGES_ANYWHERE: u64 = MAX_PAGES as u64 * 256;

/// The most texture pages of a scene: fewer than the 16 samplers that every device has.
pub const MAX_PAGES: usize = 12;

/// The most layers of a page on any device: a texture's place must fit 32 bits.
pub const MAX_LAYERS: u32 = 2048;

/// The most textures with an image of their own, on devices that index images: a texture's place
/// has 15 bits, and one value means no texture.
pub const MAX_OWN_IMAGES: u32 = (1 << 15) - 1;

/// The most different texture transforms, besides the identity: a transform's number has 16 bits.
pub const MAX_TEXTURE_TRANSFORMS: usize = (1 << 16) - 1;

/// The most lights of a scene: a place in the light table has 16 bits.
pub const MAX_LIGHTS: usize = 1 << 16;

/// The most point and spot lights that shine on an object; the weakest are left out.
pub const MAX_LIGHTS_PER_OBJECT: usize = 16;

/// The most directional lights that shine: each one lights every pixel.
pub const MAX_DIRECTIONAL_LIGHTS: usize = 4;

/// The most lens flares of a renderer: the visible samples of each are counted in every frame.
pub const MAX_FLARES: usize = 64;

/// The most texels of a panorama that are kept, 8192 by 4096: 128 MiB.
pub const MAX_PANORAMA_TEXELS: u64 = 1 << 25;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limits_are_those_of_what_lies_in_the_buffers() {
        assert_eq!(OBJECTS_ANYWHERE, 2_097_152);
        assert_eq!(LIT_OBJECTS_ANYWHERE, 4_194_304);
        assert_eq!(MATERIALS_ANYWHERE, 2_097_151);
        assert_eq!(SKINNED_VERTICES_ANYWHERE, 3_355_443);
        assert_eq!(IMAGES_ANYWHERE, 3072);
    }
}
