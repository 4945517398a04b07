//! The parts of a scene's geometry that only some frames ask for.

mod cut;
