//! Edges of objects as a drawing in CAD shows them, and outlines of objects. [How](
//! ../../../../docs/book/src/edges.md).

mod options;
mod outlines;
mod record;
pub(crate) mod state;

pub use options::{EdgeMode, EdgeOptions, ObjectOutline};
pub(crate) use options::{check_edges, check_outlines};
pub(crate) use outlines::record_outlines;
pub(crate) use record::record_edges;
