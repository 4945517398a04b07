//! The passes of a plan. Each is a struct with its pipeline, and has an `Io` struct of the buffers
//! that it reads and writes.

mod box_volume;
mod compute_test;
mod eyes;
mod leaf_box;
mod list_draws;
mod proxy;
mod scatter;

use cull::{DrawPhases, VisibilityTestSupport};
use gpu::{Attachments, Device, OptionalFeature, Target};

use crate::error::Error;
use crate::quirks::DriverQuirks;
use crate::shader_set::ShaderSet;
pub use box_volume::{BoxVolume, BoxVolumeConstants, BoxVolumeIo, BoxVolumePass};
pub use compute_test::{ComputeTest, ComputeTestIo};
pub use eyes::{EyeConstants, ProxyEyes};
pub use leaf_box::{LeafBoxIo, LeafBoxPass, LeafLinks};
pub use list_draws::{ListDrawsIo, ListDrawsPass, ListedRange, RANGE_SIZE_BYTES};
pub use proxy::{ProxyBox, ProxyConstants, ProxyIo, ProxyPass};
pub use scatter::{ScatterIo, ScatterPass};

/// The passes that all views of a scene share.
pub struct OcclusionPasses {
    /// The pass that tests boxes by queries and by flags.
    pub proxies: ProxyPass,
    /// The pass that tests the leaves below a visible node. Needs fragment shaders that can write
    /// to buffers, and a driver that can be trusted with them.
    pub leaf_boxes: Option<LeafBoxPass>,
    /// The pass that tests boxes by compute shader.
    pub compute_test: ComputeTest,
    /// The passes that list draws: for a host that records its draws, and for
    /// [`gpu::PredicationMode::Compacted`].
    pub list_draws: ListDrawsPass,
    /// The pass that uploads changed leaves.
    pub scatter: ScatterPass,
    /// The attachments that boxes are tested against.
    attachments: Attachments,
    /// The parts of the driver that are used.
    quirks: DriverQuirks,
}

impl OcclusionPasses {
    /// Compiles the passes for renderings to `attachments`.
    ///
    /// # Errors
    /// [`gpu::Error::Unsupported`] for several views at once where the device has no multiview; a
    /// failed call.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        Self::with_quirks(device, shaders, attachments, DriverQuirks::default())
    }

    /// Compiles the passes of [`OcclusionPasses::new`] for a driver that failed a self-test. Scenes
    /// and views with these passes do not use what `quirks` disables; where necessary, they skip
    /// hidden draws by another predication mode.
    ///
    /// # Errors
    /// The errors of [`OcclusionPasses::new`].
    pub fn with_quirks(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
        quirks: DriverQuirks,
    ) -> Result<Self, Error> {
        let has_stores = device.capabilities().has(OptionalFeature::FragmentStores);
        let can_store = has_stores && quirks.allows_leaf_boxes();
        let leaf_boxes = can_store.then(|| LeafBoxPass::new(device, shaders, attachments));
        Ok(Self {
            proxies: ProxyPass::new(device, shaders, attachments)?,
            leaf_boxes: leaf_boxes.transpose()?,
            compute_test: ComputeTest::new(device, shaders, attachments.samples)?,
            list_draws: ListDrawsPass::new(device, shaders)?,
            scatter: ScatterPass::new(device, shaders)?,
            attachments,
            quirks,
        })
    }

    /// Compiles these passes again, with other shaders and for other attachments.
    ///
    /// # Errors
    /// A shader that does not fit its pass, a failed call.
    pub fn recompiled(
        &self,
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        Self::with_quirks(device, shaders, attachments, self.quirks.clone())
    }

    /// Returns the parts of the driver that are used.
    pub fn quirks(&self) -> &DriverQuirks {
        &self.quirks
    }

    /// Returns the testers that `device` supports for views that are drawn to `target`.
    /// [`CulledScene::testers`](crate::CulledScene::testers) returns the testers that plans may
    /// use.
    pub fn testers(&self, device: &Device, target: &Target) -> VisibilityTestSupport {
        VisibilityTestSupport {
            queries: true,
            flags: self.proxies.can_flag(),
            compute: target.can_copy_depth() && ComputeTest::check(device, target.size()).is_ok(),
            leaf_tests: self.leaf_boxes.is_some(),
            draw_phases: DrawPhases::PerRound,
        }
    }

    /// Returns the attachments that boxes are tested against.
    pub fn attachments(&self) -> Attachments {
        self.attachments
    }
}
