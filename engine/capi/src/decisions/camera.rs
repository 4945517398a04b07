//! Cameras from the matrices of a host.

use cull::{ClipY, DepthConvention, View, ViewProjection};
use glam::Mat4;

use crate::error::Failure;
use crate::layout::{Versioned, layout};

/// Depth is 1 at the near plane and 0 infinitely far away.
pub const ANTUMBRA_DEPTH_REVERSED: u32 = 0;
/// Depth is 0 at the near plane and 1 at the far plane, or infinitely far away.
pub const ANTUMBRA_DEPTH_STANDARD: u32 = 1;

/// The y of clip space points down, as Vulkan's.
pub const ANTUMBRA_CLIP_Y_DOWN: u32 = 0;
/// The y of clip space points up: the host turns images over by a viewport of negative height.
pub const ANTUMBRA_CLIP_Y_UP: u32 = 1;

/// The camera of one frame: the host's matrix, with its jitter, and the image that is drawn.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraCamera {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Steps of the sub-pixel grid as a power of two: `VkPhysicalDeviceLimits`'
    /// `subPixelPrecisionBits`, or more where positions are more precise.
    pub sub_pixel_bits: u32,
    /// World to clip space as shaders multiply it with positions, column by column; depth from 0 to
    /// 1.
    pub clip_from_world: [f32; 16],
    /// Width of the image (pixels), above 0.
    pub width: u32,
    /// Height of the image (pixels), above 0.
    pub height: u32,
    /// The direction in which depths grow: an `ANTUMBRA_DEPTH_..`. Default:
    /// `ANTUMBRA_DEPTH_REVERSED`.
    pub depth: u32,
    /// The direction of y: an `ANTUMBRA_CLIP_Y_..`. Default: `ANTUMBRA_CLIP_Y_DOWN`.
    pub clip_y: u32,
}
layout!(AntumbraCamera: struct_size, sub_pixel_bits, clip_from_world, width, height, depth,
    clip_y);

// SAFETY: the first field is the size.
unsafe impl Versioned for AntumbraCamera {
    const REQUIRED_FIELDS: usize = 5;
    const DEFAULT: Self = Self {
        struct_size: size_of::<Self>() as u32,
        sub_pixel_bits: 8,
        clip_from_world: [0.0; 16],
        width: 0,
        height: 0,
        depth: ANTUMBRA_DEPTH_REVERSED,
        clip_y: ANTUMBRA_CLIP_Y_DOWN,
    };
}

impl AntumbraCamera {
    /// Returns the view.
    pub(crate) fn view(&self) -> Result<View, Failure> {
        if self.width == 0 || self.height == 0 {
            return Err(Failure::argument("camera.width and camera.height must be above 0"));
        }
        View::from_matrix(&self.projection()?, [self.width, self.height], self.sub_pixel_bits)
            .map_err(|error| Failure::argument(format_args!("camera.clip_from_world: {error}")))
    }

    /// Returns the matrix and what it means.
    pub(crate) fn projection(&self) -> Result<ViewProjection, Failure> {
        let depth = match self.depth {
            ANTUMBRA_DEPTH_REVERSED => DepthConvention::Reversed,
            ANTUMBRA_DEPTH_STANDARD => DepthConvention::Standard,
            _ => return Err(Failure::argument("camera.depth is no ANTUMBRA_DEPTH_..")),
        };
        let y = match self.clip_y {
            ANTUMBRA_CLIP_Y_DOWN => ClipY::Down,
            ANTUMBRA_CLIP_Y_UP => ClipY::Up,
            _ => return Err(Failure::argument("camera.clip_y is no ANTUMBRA_CLIP_Y_..")),
        };
        let matrix = Mat4::from_cols_array(&self.clip_from_world);
        Ok(ViewProjection { matrix, depth, y })
    }
}
