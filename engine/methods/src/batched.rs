//! Batched occlusion queries (GPU Gems, 29.3): a query per object behind some large occluders, and
//! a wait for all.

use cull::{BlockingOptions, Strategy};
use occlusion::Method;

use crate::blocking::BlockingMethod;

/// Creates the method. [`cull::BlockingCuller`] makes its decisions.
pub(crate) fn method(options: &BlockingOptions) -> Box<dyn Method> {
    Box::new(BlockingMethod::new(Strategy::Batched, options))
}
