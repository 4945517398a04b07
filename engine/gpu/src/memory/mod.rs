//! Buffers, images and textures, and what goes up to the GPU and comes back.

pub(crate) mod buffer;
pub(crate) mod dynamic_texture;
pub(crate) mod image;
pub(crate) mod readback;
pub(crate) mod resample;
pub(crate) mod texture_array;
pub(crate) mod upload;
