//! Batched occlusion queries (GPU Gems, 29.3): a query per object behind some large occluders, and
//! a wait for all.

use cull::{BlockingOptions, Strategy};
use occlusion::Method;

use crate::blocking::BlockingMethod;

/// Makes the method. Its decisions are those of [`cull::BlockingCuller`].
pub(crate) fn method(options: &BlockingOptions) -> Box<dyn Method> {
    Box::new(BlockingMethod::new(Strategy::Batched, options))
}
