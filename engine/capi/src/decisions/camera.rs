//! Cameras from the matrices of a host.

use cull::{ClipY, CullView, DepthConvention, ViewProjection};
use glam::Mat4;

use crate::error::Failure;
use crate::layout::{layout, versioned};

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
    /// The steps per pixel, as a power of two, that the rasteriser moves vertices by:
    /// `subPixelPrecisionBits` of `VkPhysicalDeviceLimits`. A rasteriser that moves none to a grid
    /// takes the bits behind the point that its positions have for sure: with 32-bit floats 22 less
    /// those of the image's larger side, so 12 for up to 1,024 pixels and 11 for up to 2,048; with
    /// 64-bit floats 24. Fewer are always right, since boxes are tested a little larger; too many
    /// may lose a sample. Up to 24, and more count as 24. Default: 4, the fewest of Vulkan.
    pub sub_pixel_bits: u32,
    /// Required: world to clip space as shaders multiply it with positions, column by column;
    /// depth from 0 to 1.
    pub clip_from_world: [f32; 16],
    /// Required: width of the image (pixels).
    pub width: u32,
    /// Required: height of the image (pixels).
    pub height: u32,
    /// The direction in which depths grow: an `ANTUMBRA_DEPTH_..`. Default:
    /// `ANTUMBRA_DEPTH_REVERSED`.
    pub depth: u32,
    /// The direction of y: an `ANTUMBRA_CLIP_Y_..`. Default: `ANTUMBRA_CLIP_Y_DOWN`.
    pub clip_y: u32,
}
layout!(AntumbraCamera: struct_size, sub_pixel_bits, clip_from_world, width, height, depth,
    clip_y);

versioned!(AntumbraCamera: 5,
    required: [clip_from_world, width, height],
    defaults: { sub_pixel_bits: 4 }
);

impl AntumbraCamera {
    /// Returns the view.
    pub(crate) fn view(&self) -> Result<CullView, Failure> {
        CullView::from_matrix(&self.projection()?, [self.width, self.height], self.sub_pixel_bits)
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
