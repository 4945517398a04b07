//! Hierarchical stop-and-wait (GPU Gems 2, 6.3): the hierarchy from the root down, a wait at each
//! node.

use cull::{BlockingKind, BlockingOptions, Strategy};
use occlusion::Method;

use crate::blocking::BlockingMethod;

/// The strategy of this method.
pub const STOP_AND_WAIT: Strategy =
    Strategy::new("stop_and_wait", "the hierarchy from its root, a wait at each node").blocking();

/// Creates the method. [`cull::BlockingCuller`] makes its decisions.
pub(crate) fn method(options: &BlockingOptions) -> Box<dyn Method> {
    Box::new(BlockingMethod::new([STOP_AND_WAIT], BlockingKind::StopAndWait, options))
}
