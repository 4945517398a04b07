//! The draws of frames by concern.

mod caps;
mod shading;
