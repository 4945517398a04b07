//! The calls of a scene's surfaces that only some programs need.

mod restore;
