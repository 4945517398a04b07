//! The passes: each a struct with its pipeline, and an `Io` that lists its reads and writes.

mod count;
mod deform;
mod flat;
mod opaque;
mod overlay;
mod seen;
mod sky;
mod surface;

pub use count::CountPass;
pub(crate) use deform::{DeformIo, DeformPass, Deformation, REST_WORDS};
pub use flat::{FlatDraw, FlatIo, FlatPass, FlatVertex};
pub use opaque::{OpaqueIo, OpaquePass};
pub use overlay::{OverlayIo, OverlayPass, OverlayVertex};
pub use seen::{SeenIo, SeenPass};
pub use sky::SkyPass;
pub use surface::{SurfaceIo, SurfaceKind, SurfacePass};
