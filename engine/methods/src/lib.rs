//! The methods of the literature and of today's engines, a file each: they run on the same scenes, frames and
//! passes as ours, so that comparisons compare methods and nothing else.
//!
//! A renderer carries out those that it is given ([`ALL`]). A new method is a file with a type that implements
//! [`occlusion::Method`], and a line in [`ALL`].
#![forbid(unsafe_code)]

mod batched;
mod blocking;
mod chc;
mod depth_pyramid;
mod ideal;
mod naive;
mod next_frame;
mod stop_and_wait;

use occlusion::MethodConstructor;

pub use depth_pyramid::{PyramidLevel, PyramidPass, pyramid_levels};

/// All of them.
pub const ALL: &[MethodConstructor] = &[
    naive::method,
    batched::method,
    next_frame::method,
    stop_and_wait::method,
    chc::method,
    depth_pyramid::method,
    ideal::method,
];
