//! Boxes, cameras, frustums, and how much larger a proxy must be.

pub(crate) mod bounds;
pub(crate) mod camera;
pub(crate) mod detail;
pub(crate) mod frustum;
pub(crate) mod margin;
pub(crate) mod outline;
pub(crate) mod view;
