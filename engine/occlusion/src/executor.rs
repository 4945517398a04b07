//! What plans over the leaves of one scene are executed with.

use cull::TesterSupport;
use gpu::Device;

use crate::leaf_table::LeafTable;
use crate::passes::{ComputeTest, OcclusionPasses};

/// What plans over the leaves of one scene are [executed](crate::execute) with; all its views share
/// it.
pub struct PlanExecutor {
    /// What tests boxes and uploads.
    pub passes: OcclusionPasses,
    /// What can be drawn.
    pub leaves: LeafTable,
}

impl PlanExecutor {
    /// Returns what plans may make use of on `device`, for views of up to `size` pixels. With a
    /// threshold only queries tell enough: other testers do not count samples.
    pub fn testers(&self, device: &Device, size: [u32; 2]) -> TesterSupport {
        let is_exact = self.leaves.threshold_samples() == 0;
        TesterSupport {
            flags: is_exact && self.passes.proxies.can_flag(),
            compute: is_exact && ComputeTest::check(device, size).is_ok(),
            parts: self.passes.leaf_boxes.is_some(),
        }
    }
}
