//! The functions of the interface. Each function checks its pointers and leaves the work to an
//! object.

pub mod context;
pub mod culler;
#[cfg(feature = "vulkan")]
pub mod device;
#[cfg(feature = "renderer")]
pub mod device_costs;
#[cfg(feature = "loaded")]
pub mod device_open;
pub mod hierarchy;
#[cfg(feature = "import")]
pub mod playback;
#[cfg(feature = "renderer")]
pub mod renderer;
#[cfg(feature = "renderer")]
pub mod renderer_view;
#[cfg(feature = "vulkan")]
pub mod scene;
#[cfg(feature = "import")]
pub mod scene_file;
#[cfg(feature = "renderer")]
pub mod self_test;
#[cfg(feature = "renderer")]
pub mod shadows;
