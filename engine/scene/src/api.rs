//! Calls that change a whole scene; no other module imports them.

mod cut_meshes;
