//! The passes: each a struct with its pipeline, and an `Io` that lists what it reads and writes.

mod compute_test;
mod count;
mod deform;
mod flat;
mod leaf_box;
mod opaque;
mod overlay;
mod proxy;
mod pyramid;
mod pyramid_cull;
mod scatter;
mod seen;
mod sky;
mod surface;

pub use compute_test::{ComputeTest, ComputeTestIo};
pub use count::CountPass;
pub(crate) use deform::{DeformIo, DeformPass, Deformation, REST_WORDS};
pub use flat::{FlatDraw, FlatIo, FlatPass, FlatVertex};
pub use leaf_box::{LeafBoxIo, LeafBoxPass};
pub use opaque::{OpaqueIo, OpaquePass};
pub use overlay::{OverlayIo, OverlayPass, OverlayVertex};
pub use proxy::{ProxyBox, ProxyIo, ProxyPass};
pub use pyramid::{PyramidLevel, PyramidPass, pyramid_levels};
pub(crate) use pyramid_cull::{Counters, ListKind, Phase, PyramidCullIo, PyramidCullPass};
pub use scatter::{ScatterIo, ScatterPass};
pub use seen::{SeenIo, SeenPass};
pub use sky::SkyPass;
pub use surface::{SurfaceIo, SurfaceKind, SurfacePass};
