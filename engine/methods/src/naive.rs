//! Naive occlusion queries (GPU Gems, 29.2): a query per object, front to back, and a wait for each.

use cull::{DialogueOptions, Strategy};
use occlusion::Method;

use crate::blocking::BlockingMethod;

/// Makes the method. Its decisions are those of [`cull::Dialogue`].
pub(crate) fn method(options: &DialogueOptions) -> Box<dyn Method> {
    Box::new(BlockingMethod::new(Strategy::Naive, options))
}
