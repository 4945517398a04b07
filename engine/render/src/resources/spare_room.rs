//! Room for what is added while a renderer runs.

/// Room that a renderer keeps for what is added while it runs, beside that of what is removed:
/// nothing is made larger then. By default there is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SpareRoom {
    /// Point and spot lights of a scene with surfaces: 48 bytes each. With any, the pipelines are
    /// compiled for both kinds.
    pub lights: u32,
    /// Directional lights of a scene with surfaces. Each costs every pixel a little, also while it
    /// is not there. Together with those of the scene that shine they are at most
    /// [`MAX_DIRECTIONAL_LIGHTS`](scene::limits::MAX_DIRECTIONAL_LIGHTS).
    pub directional_lights: u32,
}
