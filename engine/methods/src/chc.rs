//! Coherent hierarchical culling as published (CHC; Bittner, Wimmer, Piringer, Purgathofer 2004;
//! GPU Gems 2, 6.4 and 6.5): queries of the frontier alternate with draws, in several submits per
//! frame.

use cull::{BlockingKind, ChcOptions, Strategy};
use occlusion::MethodConstructor;

use crate::blocking::blocking;

/// The strategy of this method.
pub const CHC: Strategy = Strategy::new("chc", "coherent hierarchical culling, as published")
    .blocking()
    .with_sample_threshold();

/// Returns the method's constructor. [`cull::BlockingCuller`] makes its decisions.
pub fn chc(options: ChcOptions) -> MethodConstructor {
    blocking(CHC, BlockingKind::Chc(options))
}
