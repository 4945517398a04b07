//! The executor of plans over the leaves of one scene.

use cull::TesterSupport;
use gpu::Device;

use crate::leaf_table::LeafTable;
use crate::passes::{ComputeTest, OcclusionPasses};

/// The passes and leaves with which plans over one scene are [executed](crate::execute); all its
/// views share them.
pub struct PlanExecutor {
    /// The passes that test boxes and upload.
    pub passes: OcclusionPasses,
    /// The leaves that can be drawn.
    pub leaves: LeafTable,
}

impl PlanExecutor {
    /// Returns the testers that plans may use on `device`, for views of up to `size` pixels.
    pub fn testers(&self, device: &Device, size: [u32; 2]) -> TesterSupport {
        TesterSupport {
            flags: self.passes.proxies.can_flag(),
            compute: ComputeTest::check(device, size).is_ok(),
            leaf_tests: self.passes.leaf_boxes.is_some(),
        }
    }
}
