//! The calls of a scene that change all of it; nothing below imports them.

mod cut_meshes;
