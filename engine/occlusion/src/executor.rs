//! The executor of plans over the leaves of one scene.

use cull::{DrawPhases, VisibilityTestSupport};
use gpu::{Device, PredicationMode, Target};

use crate::error::Error;
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
    /// Returns the testers that plans may use on `device`, for views that are drawn to `target` in
    /// these phases: those of the device that can be [trusted](OcclusionPasses::with_quirks), and
    /// none where something that skips hidden draws cannot.
    pub fn testers(
        &self,
        device: &Device,
        target: &Target,
        draw_phases: DrawPhases,
    ) -> VisibilityTestSupport {
        let own = self.leaves.predicates.predication();
        let executors: &[PredicationMode] = match draw_phases {
            DrawPhases::PerRound => &[own],
            // The host draws compacted lists, whose commands lack instances where their number is
            // not counted; boxes of leaves are drawn by the table.
            DrawPhases::Two => &[own, PredicationMode::Compacted, PredicationMode::Instances],
        };
        let offered = VisibilityTestSupport { draw_phases, ..self.passes.testers(device, target) };
        let quirks = self.passes.quirks();
        executors.iter().fold(offered, |offered, executor| quirks.testers(offered, *executor))
    }

    /// Refuses a change of the target's size, from the first to the second, that takes away a
    /// tester: views plan with those that there were when they were made.
    ///
    /// # Errors
    /// A size that is too large for a test.
    pub fn check_resize(&self, device: &Device, from: [u32; 2], to: [u32; 2]) -> Result<(), Error> {
        match ComputeTest::check(device, from) {
            Ok(()) => ComputeTest::check(device, to),
            Err(_) => Ok(()),
        }
    }

    /// Drops the passes that depend on the size of the target, after a change of it. The next
    /// frame that needs one makes it again.
    pub fn resized(&mut self) {
        self.passes.compute_test = None;
    }
}
