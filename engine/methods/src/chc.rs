//! Coherent hierarchical culling as published (CHC; Bittner, Wimmer, Piringer, Purgathofer 2004;
//! GPU Gems 2, 6.4 and 6.5): queries of the frontier and draws interleave, several submits per
//! frame.

use cull::{BlockingKind, BlockingOptions, Strategy};
use occlusion::Method;

use crate::blocking::BlockingMethod;

/// The strategy of this method.
pub const COHERENT: Strategy =
    Strategy::new("coherent", "coherent hierarchical culling, as published")
        .blocking()
        .with_sample_threshold();

/// Creates the method. [`cull::BlockingCuller`] makes its decisions.
pub(crate) fn method(options: &BlockingOptions) -> Box<dyn Method> {
    Box::new(BlockingMethod::new([COHERENT], BlockingKind::Coherent, options))
}
