//! The passes: each a struct with its pipeline, and an `Io` that lists what it reads and writes.

mod leaf_box;
mod opaque;
mod overlay;
mod proxy;
mod seen;

pub use leaf_box::{LeafBoxIo, LeafBoxPass};
pub use opaque::{OpaqueIo, OpaquePass};
pub use overlay::{OverlayIo, OverlayPass, OverlayVertex};
pub use proxy::{ProxyBox, ProxyIo, ProxyPass};
pub use seen::{SeenIo, SeenPass};
