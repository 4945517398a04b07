//! The draws of frames by concern.

mod caps;
mod fragments;
mod poses;
mod shading;
