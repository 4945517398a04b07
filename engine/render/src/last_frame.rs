//! The last frame of a walk.

use crate::rgba_image::RgbaImage;

/// The last frame of a walk ([`Renderer::finish`](crate::Renderer::finish)).
#[derive(Clone, Debug, PartialEq)]
pub struct LastFrame {
    /// Opaque objects that the GPU drew.
    pub drawn: u64,
    /// Triangles of those.
    pub triangles: u64,
    /// Opaque objects whose box meets the frustum: those that plain frustum culling draws.
    pub in_frustum: u64,
    /// The image.
    pub image: RgbaImage,
}
