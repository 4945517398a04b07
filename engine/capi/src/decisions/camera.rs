//! Cameras from the matrices of a host.

use cull::{ClipY, CullView, DepthConvention, ViewProjection};
use glam::Mat4;

use crate::error::Failure;
use crate::layout::{layout, versioned};

/// Depth is 1 at the near plane, and 0 at the far plane or infinitely far away.
pub const ANTUMBRA_DEPTH_REVERSED: u32 = 0;
/// Depth is 0 at the near plane, and 1 at the far plane or infinitely far away.
pub const ANTUMBRA_DEPTH_STANDARD: u32 = 1;

/// The y axis of clip space points down, as in Vulkan.
pub const ANTUMBRA_CLIP_Y_DOWN: u32 = 0;
/// The y axis of clip space points up: the host flips images by a viewport of negative height.
pub const ANTUMBRA_CLIP_Y_UP: u32 = 1;

/// The camera of one frame: the host's matrix, with its jitter, and the image that is drawn.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraCamera {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The number of fractional bits in the rasteriser's vertex positions (pixels):
    /// `subPixelPrecisionBits` of `VkPhysicalDeviceLimits`. A rasteriser that does not snap
    /// vertices to a grid takes the number of fractional bits that its positions always have. With
    /// 32-bit floats this is 22 minus the logarithm to base 2 of the image's larger side, rounded
    /// up: 12 for up to 1,024 pixels, 11 for up to 2,048. With 64-bit floats it is 24. A smaller
    /// number is always safe, since boxes are then tested a little larger; a number that is too
    /// large may lose a sample. Values above 24 count as 24. Default: 4, the minimum of Vulkan.
    pub sub_pixel_bits: u32,
    /// Required: the matrix from world to clip space, column by column, by which shaders multiply
    /// positions. Depth is from 0 to 1.
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

    /// Returns the matrix with its conventions.
    pub(crate) fn projection(&self) -> Result<ViewProjection, Failure> {
        let depth = match self.depth {
            ANTUMBRA_DEPTH_REVERSED => DepthConvention::Reversed,
            ANTUMBRA_DEPTH_STANDARD => DepthConvention::Standard,
            other => {
                let message =
                    format_args!("camera.depth is {other}, which is not an ANTUMBRA_DEPTH_..");
                return Err(Failure::argument(message));
            }
        };
        let y = match self.clip_y {
            ANTUMBRA_CLIP_Y_DOWN => ClipY::Down,
            ANTUMBRA_CLIP_Y_UP => ClipY::Up,
            other => {
                let message =
                    format_args!("camera.clip_y is {other}, which is not an ANTUMBRA_CLIP_Y_..");
                return Err(Failure::argument(message));
            }
        };
        let matrix = Mat4::from_cols_array(&self.clip_from_world);
        Ok(ViewProjection { matrix, depth, y })
    }
}
