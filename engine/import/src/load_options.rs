//! How a file is loaded.

use crate::Limits;

/// How a file is loaded.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// What it may at most ask for.
    pub limits: Limits,
    /// Meshes of more triangles than this that are seen once and keep their form are cut into
    /// pieces that lie side by side, of at most a quarter as many triangles, each an object. `None`
    /// leaves all whole. Default: 65,536.
    pub cut_above_triangles: Option<usize>,
    /// Factor of all light before tone mapping, as
    /// [`Surfaces::exposure`](scene::Surfaces::exposure). `None`, the default, is 1; lights that
    /// would leave most of what they shine on white are dimmed then, which is noted.
    pub exposure: Option<f32>,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { limits: Limits::default(), cut_above_triangles: Some(1 << 16), exposure: None }
    }
}
