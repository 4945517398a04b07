//! Batched occlusion queries (GPU Gems, 29.3): a query per object behind some large occluders, and a wait
//! for all.

use cull::{DialogueOptions, Strategy};
use occlusion::Method;

use crate::blocking::BlockingMethod;

/// Makes the method. Its decisions are those of [`cull::Dialogue`].
pub(crate) fn method(options: &DialogueOptions) -> Box<dyn Method> {
    Box::new(BlockingMethod::new(Strategy::Batched, options))
}
