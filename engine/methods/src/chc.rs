//! Coherent hierarchical culling as published (CHC; Bittner, Wimmer, Piringer, Purgathofer 2004; GPU Gems 2,
//! 6.4 and 6.5): queries of the frontier and draws interleave, several submits per frame.

use cull::{DialogueOptions, Strategy};
use occlusion::Method;

use crate::blocking::BlockingMethod;

/// Makes the method. Its decisions are those of [`cull::Dialogue`].
pub(crate) fn method(options: &DialogueOptions) -> Box<dyn Method> {
    Box::new(BlockingMethod::new(Strategy::Coherent, options))
}
