//! Batched occlusion queries (GPU Gems, 29.3): a query per object behind some large occluders, and
//! a wait for all.

use cull::{BlockingKind, BlockingOptions, Strategy};
use occlusion::Method;

use crate::blocking::BlockingMethod;

/// The strategy of this method.
pub const BATCHED: Strategy =
    Strategy::new("batched", "a query per object behind large ones, one wait").blocking();

/// Creates the method. [`cull::BlockingCuller`] makes its decisions.
pub(crate) fn method(options: &BlockingOptions) -> Box<dyn Method> {
    Box::new(BlockingMethod::new([BATCHED], BlockingKind::Batched, options))
}
