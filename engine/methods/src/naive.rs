//! Naive occlusion queries (GPU Gems, 29.2): a query for each object, front to back, with a wait
//! after each query.

use cull::{BlockingKind, Strategy};
use occlusion::MethodConstructor;

use crate::blocking::blocking;

/// The strategy of this method.
pub const NAIVE: Strategy =
    Strategy::new("naive", "an occlusion query per object, a wait for each").blocking();

/// Returns the method's constructor. [`cull::BlockingCuller`] makes its decisions.
pub(crate) fn method() -> MethodConstructor {
    blocking(NAIVE, BlockingKind::Naive)
}
