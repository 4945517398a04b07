//! Projections of all kinds, as matrices of a host.

use antumbra_cull::{Camera, ClipY, CullView, DepthConvention, Projection, ViewProjection};
use glam::{Mat4, Vec2, Vec3, Vec4};

/// The properties of a host's matrix that a camera does not have.
#[derive(Clone, Copy, Debug)]
pub struct Optics {
    pub depth: DepthConvention,
    pub y: ClipY,
    /// The far plane; with `None` there is one only if the camera has one.
    pub far: Option<f32>,
    /// The position of the image centre, relative to half of the image.
    pub off_centre: Vec2,
    /// The longest jitter (pixels).
    pub jitter: f32,
    /// A factor for the whole matrix.
    pub scale: f32,
}

impl Optics {
    /// Returns the matrix of a frame of `camera` on an image of `size` pixels.
    pub fn projection(&self, camera: &Camera, frame: u64, size: [u32; 2]) -> ViewProjection {
        let size = Vec2::new(size[0] as f32, size[1] as f32);
        let half_height = 0.5 * camera.projection.height_at(1.0);
        let scale = Vec2::new(half_height * size.x / size.y, half_height).recip();
        // Renderers use Halton's sequence for jitters; any sequence that changes in each frame
        // works here.
        let jitter = Vec2::from_angle(frame as f32 * 2.4) * self.jitter * 2.0 / size;
        let near = camera.near;
        let (row_z, row_w) = match camera.projection {
            Projection::Perspective { .. } => {
                // Depth is `a + b / view depth`.
                let [a, b] = match (self.depth, self.far) {
                    (DepthConvention::Reversed, None) => [0.0, near],
                    (DepthConvention::Standard, None) => [1.0, -near],
                    (DepthConvention::Reversed, Some(far)) => {
                        [-near / (far - near), near * far / (far - near)]
                    }
                    (DepthConvention::Standard, Some(far)) => {
                        [far / (far - near), -near * far / (far - near)]
                    }
                };
                (Vec4::new(0.0, 0.0, -a, b), Vec4::new(0.0, 0.0, -1.0, 0.0))
            }
            Projection::Orthographic { far, .. } => {
                let slope = (far - near).recip();
                let row_z = match self.depth {
                    DepthConvention::Reversed => Vec4::new(0.0, 0.0, slope, far * slope),
                    DepthConvention::Standard => Vec4::new(0.0, 0.0, -slope, -near * slope),
                };
                (row_z, Vec4::W)
            }
        };
        let aside = self.off_centre + jitter;
        let up = if self.y == ClipY::Up { 1.0 } else { -1.0 };
        let row_x = Vec4::X * scale.x + row_w * aside.x;
        let row_y = Vec4::Y * (up * scale.y) - row_w * (up * aside.y);
        let to_clip = Mat4::from_cols(row_x, row_y, row_z, row_w).transpose() * self.scale;
        let forward = camera.forward.try_normalize().unwrap_or(Vec3::NEG_Z);
        let right = forward.cross(camera.up).try_normalize();
        let right = right.unwrap_or_else(|| forward.any_orthonormal_vector());
        let row = |axis: Vec3| axis.extend(-axis.dot(camera.eye));
        let to_eye = [row(right), row(right.cross(forward)), row(-forward), Vec4::W];
        let matrix = to_clip * Mat4::from_cols_array_2d(&to_eye.map(Into::into)).transpose();
        ViewProjection { matrix, depth: self.depth, y: self.y }
    }

    /// Returns the view of a frame of `camera`.
    pub fn view(&self, camera: &Camera, frame: u64, size: [u32; 2], bits: u32) -> CullView {
        let projection = self.projection(camera, frame, size);
        CullView::from_matrix(&projection, size, bits).unwrap_or_else(|error| {
            panic!("{error}: {self:?} {camera:?}");
        })
    }
}
