//! The draws of frames by concern.

mod shading;
