//! Occlusion culling on the GPU, the heart of Antumbra: executes a [`cull::FramePlan`] on a
//! [`gpu::Device`] and reads the results back without waiting for them.
//!
//! It knows boxes and indirect draws, no materials. The owner of the objects draws them: an
//! [`ObjectRenderer`] binds pipelines and geometry, and the executor records the draws and their
//! predicates.
//!
//! | type | purpose |
//! |---|---|
//! | [`LeafTable`] | box, draws and counts per leaf of the hierarchy, on the CPU and the GPU |
//! | [`HostScene`] | objects of a host, with any number of draws in its own pipelines |
//! | [`TransparentList`] | objects that hide nothing, drawn in their order where they show |
//! | [`PlanExecutor`] | records the rounds of a plan: draws, tests, predicates, results |
//! | [`list_draws`] | hands the draws of a plan to a host that records them itself |
//! | [`OcclusionState`] | one view: its culler, its tests on their way, its newest plan |
//! | [`Method`] | the trait of all methods: [`AntumbraMethod`] is Antumbra's own |
//! | [`CostModel`], [`measure`] | costs of tests and draws on this device |
//! | [`DriverQuirks`] | the parts of a driver that may be used, after a self-test |
//!
//! A frame of somebody's own objects, each a box and an indexed draw:
//!
//! ```no_run
//! # use antumbra_occlusion as occlusion;
//! use cull::{Aabb, Camera, CullConfig, Culler, DrawPhases, Hierarchy, Strategy, CullView};
//! use occlusion::*;
//!
//! fn walk(
//!     device: &gpu::Device,
//!     boxes: &[Aabb],
//!     draw: MeshDraw,
//!     objects: &mut dyn ObjectRenderer,
//!     cameras: &[Camera],
//! ) -> Result<(), Box<dyn std::error::Error>> {
//!     let (shaders, size, slots) = (ShaderSet::embedded()?, objects.target().size(), 2);
//!     let hierarchy = Hierarchy::build(boxes)?;
//!     let info = LeafTableInfo {
//!         mesh_draws: [draw].into(),
//!         predication: None,
//!         frames_in_flight: slots,
//!     };
//!     let leaves = LeafTable::new(device, &hierarchy, info, |_object| MeshDrawId(0))?;
//!     let passes = OcclusionPasses::new(device, &shaders, objects.target().attachments())?;
//!     let mut executor = PlanExecutor { passes, leaves };
//!     let testers = executor.testers(device, objects.target(), DrawPhases::PerRound);
//!     let culler = Culler::with_testers(CullConfig::default(), testers);
//!     let mut state = OcclusionState::new(device, &hierarchy, &executor.leaves, slots, culler)?;
//!     let mut frames = gpu::FrameRing::new(device, slots)?;
//!     for camera in cameras {
//!         let bits = device.adapter().limits.sub_pixel_precision_bits;
//!         let view = CullView::new(camera, size, bits);
//!         let mut frame = frames.begin()?; // waits for the frame of two frames ago
//!         state.collect(device.completed()?, &hierarchy, &executor.leaves);
//!         state.plan_frame(&hierarchy, &executor.leaves, Strategy::ANTUMBRA, &view, 4096);
//!         execute(&mut frame, &mut executor, &mut state, objects, &shaders, &view)?;
//!         let tick = frame.submit(None)?;
//!         state.submitted(tick, &executor.leaves, None);
//!     }
//!     Ok(())
//! }
//! ```
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]
#![forbid(unsafe_code)]

mod antumbra_method;
mod costs;
mod draw_lists;
mod error;
mod execution;
mod executor;
mod host_scene;
mod leaf_table;
mod method;
mod method_state;
mod object_renderer;
mod occlusion_state;
mod outcomes;
mod passes;
mod quirks;
mod rect;
mod shader_set;
mod test_layout;
mod transparent_list;
mod visible_draws;

pub use antumbra_method::AntumbraMethod;
pub use costs::calibration::{CalibrationScene, PATCH_TRIANGLES, measure};
pub use costs::device_costs::{
    ChoiceRequest, CostModel, CullingSetup, DeviceCosts, QueryResetCosts,
};
pub use costs::frame_times::FrameTimes;
pub use costs::skipped_ranges::SkippedRanges;
pub use draw_lists::DrawList;
pub use error::{
    BucketError, CannotCount, DrawsAmongTests, Error, NotUploaded, PlanError, TargetError,
    WrongAttachments,
};
pub use execution::{ListedTests, execute, list_draws};
pub use executor::PlanExecutor;
pub use host_scene::{HostObject, HostScene};
pub use leaf_table::{
    BucketDraw, BucketId, BucketTableInfo, LeafCount, LeafElements, LeafTable, LeafTableInfo,
    MAX_BUCKETS, MeshDraw, MeshDrawId,
};
pub use method::{
    Method, MethodConstructor, MethodRequest, MethodScene, MethodStats, MethodSupport,
};
pub use method_state::MethodState;
pub use object_renderer::{
    DrawBuckets, ObjectPass, ObjectRenderer, Rendering, UpcomingDraws, render, render_last,
};
pub use occlusion_state::OcclusionState;
pub use outcomes::{FrameStats, Outcomes};
pub use passes::{
    BoxVolume, BoxVolumeConstants, BoxVolumeIo, BoxVolumePass, ComputeTest, ComputeTestIo,
    EyeConstants, LeafBoxIo, LeafBoxPass, LeafLinks, ListDrawsIo, ListDrawsPass, ListedRange,
    OcclusionPasses, ProxyBox, ProxyConstants, ProxyEyes, ProxyIo, ProxyPass, RANGE_SIZE_BYTES,
    ScatterIo, ScatterPass,
};
pub use quirks::{DriverAssumption, DriverQuirks};
pub use rect::Rect;
pub use shader_set::{SectionShaders, ShaderSet};
pub use transparent_list::TransparentList;
