//! The last frame of a walk.

use crate::rgba_image::RgbaImage;

/// The last frame of a walk ([`Renderer::finish`](crate::Renderer::finish)).
#[derive(Clone, Debug, PartialEq)]
pub struct LastFrame {
    /// The number of opaque objects that the GPU drew.
    pub drawn: u64,
    /// The number of triangles in these objects.
    pub triangles: u64,
    /// The number of opaque objects whose box meets the frustum, which plain frustum culling draws.
    pub in_frustum: u64,
    /// The image.
    pub image: RgbaImage,
}
