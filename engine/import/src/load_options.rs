//! The options of loading a file.

use crate::Limits;

/// The options of loading a file.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// The limits on the file's demands.
    pub limits: Limits,
    /// The number of triangles above which a rigid mesh with a single object is cut into spatial
    /// pieces, each an object of at most a quarter as many triangles. `None` leaves all meshes
    /// whole. Default: 65,536.
    pub cut_above_triangles: Option<usize>,
    /// The factor of all light before tone mapping, as
    /// [`Surfaces::exposure`](scene::Surfaces::exposure). `None`, the default, is 1; lights that
    /// would turn most of the lit objects white are dimmed then, with a note.
    pub exposure: Option<f32>,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { limits: Limits::default(), cut_above_triangles: Some(1 << 16), exposure: None }
    }
}
