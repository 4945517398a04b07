//! Occlusion culling on the GPU, the heart of Antumbra: executes a [`cull::FramePlan`] on a
//! [`gpu::Device`] and brings the results back without waiting for them.
//!
//! It knows boxes and indirect draws, no materials. Whoever owns the objects draws them: an
//! [`ObjectRenderer`] binds pipelines and geometry, and the executor records which draws happen and
//! under which predicate.
//!
//! | type | what it is |
//! |---|---|
//! | [`LeafTable`] | a box, a draw and counts per leaf of the hierarchy, on the CPU and on the GPU |
//! | [`PlanExecutor`] | records the rounds of a plan: draws, tests, predicates, results |
//! | [`VisibilityState`] | one view: its culler, its tests on their way, its newest plan |
//! | [`Method`] | the trait of all methods: [`PlannedMethod`] is ours |
//! | [`Costs`], [`measure`] | prices of tests and draws on this device |
#![forbid(unsafe_code)]

mod calibration;
mod error;
mod execution;
mod executor;
mod frame_times;
mod leaf_table;
mod method;
mod method_state;
mod object_renderer;
mod outcomes;
mod passes;
mod planned;
mod rect;
mod sent_frames;
mod shader_set;
mod test_layout;
mod visibility_state;

pub use calibration::{CalibrationScene, Costs, PATCH_TRIANGLES, cost_table, measure};
pub use error::Error;
pub use execution::execute;
pub use executor::PlanExecutor;
pub use frame_times::{FrameTimes, is_timed_after};
pub use leaf_table::{LeafCount, LeafElements, LeafTable, LeafTableInfo, MeshDraw, MeshDrawId};
pub use method::{
    Method, MethodConstructor, MethodRequest, MethodScene, MethodStats, MethodSupport,
};
pub use method_state::MethodState;
pub use object_renderer::{ObjectPass, ObjectRenderer, Rendering};
pub use outcomes::{FrameOutcome, Outcomes};
pub use passes::{
    ComputeTest, ComputeTestIo, LeafBoxIo, LeafBoxPass, OcclusionPasses, ProxyBox, ProxyIo,
    ProxyPass, ScatterIo, ScatterPass,
};
pub use planned::PlannedMethod;
pub use rect::Rect;
pub use shader_set::ShaderSet;
pub use visibility_state::VisibilityState;
