//! The viewer in a window.
//!
//! An [`interaction`] is pure: it turns input events ([`input`]) and late results of frames into
//! commands of a [session](crate::session). It moves the camera, drags ([`drag`]) the lid and
//! [section planes](tools), turns with the [cube](view_cube), and records a [path](camera_path). An
//! open window shows the [`panel`] of tools with its [tree of parts](part_rows), and the [`signs`]
//! over the image. It draws frames while something changes.

pub mod app;
pub mod camera_path;
pub mod context;
pub mod drag;
mod gesture;
pub mod input;
pub mod interaction;
pub mod keys;
mod opened;
pub mod panel;
pub mod part_rows;
pub mod signs;
pub mod tools;
pub mod view_cube;
