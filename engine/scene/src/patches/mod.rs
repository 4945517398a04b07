//! Curved surfaces: bicubic Bezier patches, cut into triangles without cracks.

mod ellipsoid;
mod evaluate;
mod grid;
mod levels;
mod surface;
#[cfg(test)]
mod tests;

pub use ellipsoid::ellipsoid;
pub use evaluate::{evaluated, tessellated};
pub use grid::{EvaluatedPoint, SurfaceGrid, SurfacePoint};
pub use levels::{MAX_LEVEL, TessellationLevels, TessellationView};
pub use surface::{MAX_PATCHES, Patch, PatchEdge, PatchError, PatchSurface};
