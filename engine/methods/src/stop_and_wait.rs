//! Hierarchical stop-and-wait (GPU Gems 2, 6.3): the hierarchy from the root down, a wait at each
//! node.

use cull::{BlockingOptions, Strategy};
use occlusion::Method;

use crate::blocking::BlockingMethod;

/// Creates the method. [`cull::BlockingCuller`] makes its decisions.
pub(crate) fn method(options: &BlockingOptions) -> Box<dyn Method> {
    Box::new(BlockingMethod::new(Strategy::StopAndWait, options))
}
