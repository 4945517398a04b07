//! Matrices of a host: the matrices of cameras with all changes that a host may make.

use cull::{Camera, ClipY, CullView, DepthConvention, ViewProjection};
use glam::{Mat4, Vec2, Vec4};

/// The changes that a host makes to the matrix of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// The direction of depth.
    pub depth: DepthConvention,
    /// The direction of y.
    pub y: ClipY,
    /// The distance of a far plane, for a camera in perspective (metres).
    pub far: Option<f32>,
    /// The middle of the image, in halves of the image.
    pub off_centre: Vec2,
    /// The jitter (pixels), which differs between frames.
    pub jitter_pixels: f32,
}

impl Lens {
    /// No changes.
    pub const PLAIN: Self = Self {
        depth: DepthConvention::Reversed,
        y: ClipY::Down,
        far: None,
        off_centre: Vec2::ZERO,
        jitter_pixels: 0.0,
    };

    /// Returns the matrix of a frame of `camera` on an image of `size` pixels.
    pub fn projection(&self, camera: &Camera, frame: u64, size: [u32; 2]) -> ViewProjection {
        let plain = CullView::new(camera, size, 8);
        let size = Vec2::new(size[0] as f32, size[1] as f32);
        let jitter = Vec2::from_angle(frame as f32 * 2.4) * self.jitter_pixels * 2.0 / size;
        let x = Vec4::X;
        let mut y = Vec4::Y;
        let mut z = Vec4::Z;
        let w = Vec4::W;
        let aside = self.off_centre + jitter;
        let x = x + w * aside.x;
        y += w * aside.y;
        if let Some(far) = self.far {
            z = (z * far - w * camera.near) / (far - camera.near);
        }
        if self.depth == DepthConvention::Standard {
            z = w - z;
        }
        if self.y == ClipY::Up {
            y = -y;
        }
        let changed = Mat4::from_cols(x, y, z, w).transpose();
        ViewProjection { matrix: changed * plain.view_proj, depth: self.depth, y: self.y }
    }

    /// Returns the view of a frame of `camera` on a device with this sub-pixel precision.
    pub fn view(&self, camera: &Camera, frame: u64, size: [u32; 2], bits: u32) -> CullView {
        CullView::from_matrix(&self.projection(camera, frame, size), size, bits)
            .expect("a projection")
    }
}
