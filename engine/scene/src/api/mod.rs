//! What a scene does as a whole; nothing below imports it.

mod cut_meshes;
