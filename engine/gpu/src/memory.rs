//! Buffers, images and textures, with uploads to the GPU and read-backs from it.

pub(crate) mod allocation;
mod attempts;
pub(crate) mod buffer;
pub(crate) mod depth_layers;
pub(crate) mod device_memory;
pub(crate) mod dynamic_texture;
pub(crate) mod image;
pub(crate) mod instance_numbers;
pub(crate) mod memory_error;
pub(crate) mod memory_use;
pub(crate) mod readback;
pub(crate) mod resample;
pub(crate) mod sampled_texture;
mod texel_blocks;
pub(crate) mod texture_array;
mod texture_sampler;
pub(crate) mod texture_set;
pub(crate) mod texture_table;
pub(crate) mod texture_uploads;
pub(crate) mod upload;
pub(crate) mod volume_texture;
