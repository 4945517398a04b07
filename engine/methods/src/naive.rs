//! Naive occlusion queries (GPU Gems, 29.2): a query per object, front to back, and a wait for
//! each.

use cull::{BlockingKind, BlockingOptions, Strategy};
use occlusion::Method;

use crate::blocking::BlockingMethod;

/// The strategy of this method.
pub const NAIVE: Strategy =
    Strategy::new("naive", "an occlusion query per object, a wait for each").blocking();

/// Creates the method. [`cull::BlockingCuller`] makes its decisions.
pub(crate) fn method(options: &BlockingOptions) -> Box<dyn Method> {
    Box::new(BlockingMethod::new([NAIVE], BlockingKind::Naive, options))
}
