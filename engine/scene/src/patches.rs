//! Curved surfaces: bicubic Bezier patches, cut into triangles without cracks.

mod captured;
mod ellipsoid;
mod evaluate;
mod grid;
mod levels;
mod surface;
#[cfg(test)]
mod tests;
mod welder;

pub use captured::{PatchSides, captured_mesh, captured_triangle_count};
pub use ellipsoid::ellipsoid;
pub use evaluate::{evaluated, tessellated};
pub use grid::{EvaluatedPoint, SurfaceGrid, SurfacePoint};
pub use levels::{MAX_LEVEL, TessellationLevels, TessellationView};
pub use surface::{MAX_PATCHES, Patch, PatchEdge, PatchError, PatchSurface};
