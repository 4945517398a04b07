//! Edges of objects as a drawing in CAD shows them, and outlines of objects. [How](
//! ../../../../docs/edges.md).

mod options;
mod outlines;
mod record;

use cull::LeafRange;
use gpu::StencilTarget;

pub use options::{EdgeMode, EdgeOptions, ObjectOutline};
pub(crate) use options::{check_edges, check_outlines};
pub(crate) use outlines::record_outlines;
pub(crate) use record::record_edges;

/// The edges and outlines of a renderer.
#[derive(Default)]
pub(crate) struct Edges {
    pub(crate) options: EdgeOptions,
    /// Those that have objects.
    pub(crate) outlines: Vec<ObjectOutline>,
    /// The marks of outlined objects, for the target that they were made for.
    stencil: Option<StencilTarget>,
    /// The leaves of a view, kept to allocate nothing.
    ranges: Vec<LeafRange>,
}

impl Edges {
    /// Returns true if something is drawn.
    pub(crate) fn has_draws(&self) -> bool {
        self.options.mode != EdgeMode::Off || !self.outlines.is_empty()
    }

    /// Forgets the images of the target before.
    pub(crate) fn resized(&mut self) {
        self.stencil = None;
    }
}
