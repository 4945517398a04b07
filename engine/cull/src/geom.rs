//! Boxes, cameras, frustums, and the margins of proxies.

pub(crate) mod bounds;
pub(crate) mod box_shadow_volumes;
pub(crate) mod camera;
pub(crate) mod detail;
pub(crate) mod frustum;
pub(crate) mod margin;
pub(crate) mod multi_view;
pub(crate) mod outline;
pub(crate) mod projection;
pub(crate) mod rays;
pub(crate) mod section;
pub(crate) mod view;
