//! The functions of the interface. Each function checks its pointers and leaves the work to an
//! object.

pub mod context;
pub mod culler;
#[cfg(feature = "vulkan")]
pub mod device;
#[cfg(feature = "renderer")]
pub mod device_costs;
pub mod hierarchy;
#[cfg(feature = "renderer")]
pub mod renderer;
#[cfg(feature = "vulkan")]
pub mod scene;
#[cfg(feature = "renderer")]
pub mod self_test;
