//! Views from the matrices of a host.

use cull::{Camera, View};
use glam::{Mat3, Mat4, Vec3};

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

/// The view of one frame: the host's matrix, with its jitter, and the image that is drawn.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraViewDesc {
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
layout!(AntumbraViewDesc: struct_size, sub_pixel_bits, clip_from_world, width, height, depth,
    clip_y);

// SAFETY: the first field is the size.
unsafe impl Versioned for AntumbraViewDesc {
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

impl AntumbraViewDesc {
    /// Returns the view.
    pub(crate) fn view(&self) -> Result<View, Failure> {
        if self.width == 0 || self.height == 0 {
            return Err(Failure::argument("view.width and view.height must be above 0"));
        }
        if self.depth != ANTUMBRA_DEPTH_REVERSED || self.clip_y != ANTUMBRA_CLIP_Y_DOWN {
            let message = "this version takes ANTUMBRA_DEPTH_REVERSED and ANTUMBRA_CLIP_Y_DOWN";
            return Err(Failure::argument(message));
        }
        let camera = camera(&Mat4::from_cols_array(&self.clip_from_world))?;
        Ok(View::new(&camera, [self.width, self.height], self.sub_pixel_bits))
    }
}

/// Returns the camera of a matrix: in perspective, with an infinite far plane.
fn camera(matrix: &Mat4) -> Result<Camera, Failure> {
    let [x, y, z, w] = [0, 1, 2, 3].map(|row| matrix.row(row));
    let rows = Mat3::from_cols(x.truncate(), y.truncate(), w.truncate());
    let eye = rows.transpose().inverse() * -Vec3::new(x.w, y.w, w.w);
    let is_centred = x.truncate().dot(w.truncate()).abs() + y.truncate().dot(w.truncate()).abs()
        <= 1.0e-4 * y.truncate().length();
    if !(eye.is_finite() && is_centred && z.truncate().length() <= 1.0e-6 && z.w > 0.0) {
        return Err(Failure::argument(
            "view.clip_from_world is no symmetric perspective projection with an infinite far \
             plane and reversed depth",
        ));
    }
    let scale = w.truncate().length();
    Ok(Camera {
        eye,
        forward: w.truncate(),
        up: -y.truncate(),
        fov_y: 2.0 * (scale / y.truncate().length()).atan(),
        near: z.w / scale,
    })
}
