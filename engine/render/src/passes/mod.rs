//! The passes: each a struct with its pipeline, and an `Io` that lists what it reads and writes.

mod opaque;
mod overlay;
mod proxy;
mod scatter;

pub use opaque::{OpaqueIo, OpaquePass};
pub use overlay::{OverlayIo, OverlayPass, OverlayVertex};
pub use proxy::{ProxyBox, ProxyIo, ProxyPass};
pub use scatter::{ScatterIo, ScatterPass};
