//! The constants of the views that proxies are drawn with: one view, or several at once.

use bytemuck::{Pod, Zeroable};
use cull::CullView;
use gpu::BufferSlice;

/// The views that proxies are drawn in.
#[derive(Clone, Copy)]
pub enum ProxyEyes<'a> {
    /// One view, whose constants are pushed.
    One(&'a CullView),
    /// Several views at once (multiview): a buffer with an [`EyeConstants`] per view.
    Several(BufferSlice),
}

impl<'a> From<&'a CullView> for ProxyEyes<'a> {
    fn from(view: &'a CullView) -> Self {
        Self::One(view)
    }
}

/// The constants of one of several views that are drawn at once; mirrors `eye.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct EyeConstants {
    view_proj: [f32; 16],
    eye: [f32; 4],
    row_w: [f32; 4],
    margin_m: [f32; 2],
    unused: [f32; 2],
}

const _: () = assert!(size_of::<EyeConstants>() == 112);

impl EyeConstants {
    /// Creates the constants for the proxies of a view.
    pub fn of(view: &CullView) -> Self {
        Self {
            view_proj: view.proxy_view_proj().to_cols_array(),
            eye: view.rays.eye().to_array(),
            row_w: view.rays.row_w().to_array(),
            margin_m: view.margin.metres(),
            unused: [0.0; 2],
        }
    }
}
