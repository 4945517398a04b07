//! Batched occlusion queries (GPU Gems, 29.3): a query for each object after some large occluders,
//! and one wait for all queries.

use cull::{BatchedOptions, BlockingKind, Strategy};
use occlusion::MethodConstructor;

use crate::blocking::blocking;

/// The strategy of this method.
pub const BATCHED: Strategy =
    Strategy::new("batched", "a query per object behind large ones, one wait").blocking();

/// Returns the method's constructor. [`cull::BlockingCuller`] makes its decisions.
pub fn batched(options: BatchedOptions) -> MethodConstructor {
    blocking(BATCHED, BlockingKind::Batched(options))
}
