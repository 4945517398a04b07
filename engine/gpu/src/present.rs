//! The presentation of frames in a window.

#[cfg(feature = "loaded")]
pub(crate) mod display_link;
pub(crate) mod present_mode;
pub(crate) mod surface;
pub(crate) mod swapchain;
pub(crate) mod window_copy;
