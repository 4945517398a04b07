//! Occlusion culling on the GPU, the core of Antumbra: executes a [`cull::FramePlan`] on a
//! [`gpu::Device`] and reads the results back without waiting for them.
//!
//! This crate works with boxes and indirect draws, not with materials. The owner of the objects
//! draws them: its [`ObjectRenderer`] binds pipelines and geometry, and the executor records the
//! draws with their predicates.
//!
//! | type | purpose |
//! |---|---|
//! | [`CulledScene`] | hierarchy, draws per leaf and passes of a scene; adds, moves, removes objects |
//! | [`FrameScope`] | a frame of a scene: uploads, plans, records, ends |
//! | [`OcclusionState`] | one view: its culler, its tests in flight, its newest plan |
//! | [`ObjectRenderer`] | the seam to the owner of the objects |
//! | [`TransparentList`] | objects that hide nothing, drawn in their order where they show |
//! | [`LeafTable`] | box, draws and counts per leaf of the hierarchy, on the CPU and the GPU |
//! | [`Method`] | the trait of all methods: [`AntumbraMethod`] is Antumbra's own |
//! | [`CostModel`], [`measure`] | costs of tests and draws on this device |
//! | [`DriverQuirks`] | the parts of a driver that may be used, after a self-test |
//!
//! A loop that draws a host's own objects in one pipeline:
//!
//! ```no_run
//! # use antumbra_occlusion as occlusion;
//! use cull::{Camera, CullView};
//! use occlusion::*;
//!
//! fn walk(
//!     device: &gpu::Device,
//!     boxes: &[HostObject<'_>],
//!     objects: &mut dyn ObjectRenderer,
//!     cameras: &[Camera],
//! ) -> Result<(), Box<dyn std::error::Error>> {
//!     let options = CulledSceneOptions {
//!         object_capacity: boxes.len(),
//!         draw_capacity: boxes.len() as u32,
//!         ..Default::default()
//!     };
//!     let attachments = objects.target().attachments();
//!     let mut scene = CulledScene::new(device, attachments, &options)?;
//!     scene.add(boxes, &mut Vec::new())?;
//!     let mut state = scene.new_view(objects.target())?;
//!     let mut frames = gpu::FrameRing::new(device, 2)?;
//!     for camera in cameras {
//!         let bits = device.adapter().limits.sub_pixel_precision_bits;
//!         let view = CullView::new(camera, objects.target().size(), bits);
//!         let frame = frames.begin()?; // waits for the frame of two frames ago
//!         let mut scope = scene.begin(frame)?; // uploads changes
//!         scope.draw(&mut state, &view, objects)?; // reads results, plans, records
//!         scope.submit(None)?;
//!     }
//!     Ok(())
//! }
//! ```
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]
#![forbid(unsafe_code)]

mod antumbra_method;
mod costs;
mod culled_scene;
mod draw_lists;
mod error;
mod execution;
mod frame_scope;
mod leaf_table;
mod method;
mod method_state;
mod object_renderer;
mod occlusion_state;
mod outcomes;
mod passes;
mod quirks;
mod rect;
mod shaded_objects;
mod shader_set;
mod test_layout;
mod transparent_list;
mod visible_draws;

pub use antumbra_method::AntumbraMethod;
pub use costs::box_bench::{
    BenchItem, BoxBench, BoxSize, CalibrationScene, PATCH_TRIANGLES, PredicateResult,
};
pub use costs::calibration::measure;
pub use costs::device_costs::{
    ChoiceRequest, CostModel, CullingSetup, DeviceCosts, QueryResetCosts,
};
pub use costs::frame_times::FrameTimes;
pub use costs::skipped_ranges::SkippedRanges;
pub use culled_scene::{CulledScene, CulledSceneOptions, HostObject, ScenePartsMut};
pub use draw_lists::DrawList;
pub use error::{
    BucketError, CannotCount, DrawsAmongTests, Error, NotUploaded, TargetError, WrongAttachments,
};
pub use execution::execute;
pub use frame_scope::{DrawRequest, FrameScope, ListedView, PerView, PlannedView};
pub use glam;
pub use leaf_table::{
    BucketDraw, BucketId, LeafCount, LeafElements, LeafTable, LeafTableInfo, MAX_BUCKETS, MeshDraw,
    MeshDrawId,
};
pub use method::{Method, MethodConstructor, MethodRequest, MethodStats, MethodSupport};
pub use method_state::MethodState;
pub use object_renderer::{ObjectRenderer, Rendering};
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
pub use shaded_objects::{
    DrawBuckets, ObjectPass, ShadedObjects, UpcomingDraws, render, render_last,
};
pub use shader_set::{SectionShaders, ShaderSet};
pub use transparent_list::TransparentList;
