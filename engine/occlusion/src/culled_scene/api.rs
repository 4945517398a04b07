//! The views and frames of a scene.

mod frames;
mod views;
