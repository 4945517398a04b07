//! Coherent hierarchical culling as published (CHC; Bittner, Wimmer, Piringer, Purgathofer 2004;
//! GPU Gems 2, 6.4 and 6.5): queries of the frontier and draws interleave, several submits per
//! frame.

use cull::{BlockingKind, CoherentOptions, Strategy};
use occlusion::MethodConstructor;

use crate::blocking::blocking;

/// The strategy of this method.
pub const COHERENT: Strategy =
    Strategy::new("coherent", "coherent hierarchical culling, as published")
        .blocking()
        .with_sample_threshold();

/// Returns the method's constructor. [`cull::BlockingCuller`] makes its decisions.
pub fn coherent(options: CoherentOptions) -> MethodConstructor {
    blocking(COHERENT, BlockingKind::Coherent(options))
}
