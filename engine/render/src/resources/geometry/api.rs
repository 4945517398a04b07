//! The parts of a scene's geometry that only some frames need.

mod cut;
mod restore;
