//! Naive occlusion queries (GPU Gems, 29.2): a query per object, front to back, and a wait for
//! each.

use cull::{BlockingOptions, Strategy};
use occlusion::Method;

use crate::blocking::BlockingMethod;

/// Creates the method. [`cull::BlockingCuller`] makes its decisions.
pub(crate) fn method(options: &BlockingOptions) -> Box<dyn Method> {
    Box::new(BlockingMethod::new(Strategy::Naive, options))
}
