//! An object as the vertex shaders read it.

use bytemuck::{Pod, Zeroable};

/// An object as the vertex shaders read it; mirrors `instance.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
pub(crate) struct Instance {
    pub(crate) rows: [[f32; 4]; 3],
    /// The tint as floats and 0; `SurfaceResources::instance_tail` in scenes with surfaces.
    pub(crate) tail: [u32; 4],
}

const _: () = assert!(size_of::<Instance>() == 64);
