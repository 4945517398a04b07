//! Hierarchical stop-and-wait (GPU Gems 2, 6.3): traverses the hierarchy from the root down, with a
//! wait at each node.

use cull::{BlockingKind, Strategy};
use occlusion::MethodConstructor;

use crate::blocking::blocking;

/// The strategy of this method.
pub const STOP_AND_WAIT: Strategy =
    Strategy::new("stop_and_wait", "the hierarchy from its root, a wait at each node").blocking();

/// Returns the method's constructor. [`cull::BlockingCuller`] makes its decisions.
pub(crate) fn method() -> MethodConstructor {
    blocking(STOP_AND_WAIT, BlockingKind::StopAndWait)
}
